// The rules of docs/architecture.md that a compiler cannot check, as functions from a file's text to what breaks them:
// who may include whom, who may know the operating system, who may read a clock, what a header looks like.
//
// They look at text, not at meaning: comments and (where it matters) string literals are taken out first, macros are
// not expanded. Thread safety: pure functions.
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace ctn::architecture {

// Module -> the modules that it may include, itself not among them.
using ModuleTable = std::map<std::string, std::set<std::string>, std::less<>>;

// From the "module:dependency dependency" lines that the build writes.
ModuleTable parse_module_table(std::string_view text);

struct SourceFile {
  std::string path;  // from the root of the repository, as "src/plan/plan.h"
  std::string text;
};

// All that is wrong with a C++ file, each as "path:line: what". Empty: nothing.
std::vector<std::string> check_source(const SourceFile& file, const ModuleTable& modules);

// What every text file keeps to: UTF-8, no trailing blanks, a newline at its end, and no tabs unless they are syntax.
std::vector<std::string> check_text(const SourceFile& file, bool tabs_allowed);

// A link of a Markdown file to another file of the repository.
struct Link {
  int line = 0;
  std::string target;   // empty: the page itself
  std::string section;  // empty: none
};
// Links and pictures, Markdown's and HTML's; those that lead out of the repository are left out, and so is what stands
// in code.
std::vector<Link> relative_links(std::string_view markdown);
// What a link may name after its "#": the page's headings, as GitHub writes them there, and elements with an id.
std::set<std::string> sections_of(std::string_view markdown);

}  // namespace ctn::architecture
