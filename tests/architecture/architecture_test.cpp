// The repository keeps to its own rules (source_rules.h), and its pages to the repository: links lead somewhere, lines
// are not too long, and the module table of docs/architecture.md is the one that is built.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "architecture/source_rules.h"

namespace ctn::architecture {
namespace {

namespace fs = std::filesystem;
using ::testing::IsEmpty;

const fs::path kRoot{CATAN_SOURCE_DIR};

std::string read(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// The files of the repository whose name ends in one of `endings`, but for what is built and fetched.
std::vector<SourceFile> files(const std::vector<std::string>& endings) {
  std::vector<SourceFile> found;
  for (fs::recursive_directory_iterator it(kRoot), end; it != end; ++it) {
    const std::string path = it->path().lexically_relative(kRoot).generic_string();
    if (it->is_directory() &&
        (path == "build" || path == "out" || path == "bin" || path == ".git" || path == ".cache")) {
      it.disable_recursion_pending();
    } else if (it->is_regular_file() && std::any_of(endings.begin(), endings.end(),
                                                    [&](const auto& ending) { return path.ends_with(ending); })) {
      found.push_back({path, read(it->path())});
    }
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return found;
}

void append(std::vector<std::string>& all, std::vector<std::string> more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

TEST(Architecture, EveryFolderOfSourcesIsAModule) {
  const ModuleTable modules = parse_module_table(read(CATAN_MODULE_TABLE));
  ASSERT_FALSE(modules.empty()) << CATAN_MODULE_TABLE;
  for (const fs::directory_entry& entry : fs::directory_iterator(kRoot / "src")) {
    if (!entry.is_directory()) continue;
    EXPECT_TRUE(modules.contains(entry.path().filename().string())) << entry.path();
  }
}

TEST(Architecture, SourcesKeepToTheRules) {
  const ModuleTable modules = parse_module_table(read(CATAN_MODULE_TABLE));
  const std::vector<SourceFile> sources = files({".h", ".cpp"});
  ASSERT_GT(sources.size(), 20U);
  std::vector<std::string> broken;
  for (const SourceFile& source : sources) append(broken, check_source(source, modules));
  EXPECT_THAT(broken, IsEmpty());
}

TEST(Architecture, TextFilesAreClean) {
  std::vector<std::string> broken;
  for (const SourceFile& file : files({".h", ".cpp", ".md", ".txt", ".cmake", ".json", ".yaml", ".sh"})) {
    if (file.path.starts_with("fuzz/corpus/") || file.path.starts_with("tests/malformed/"))
      continue;  // faults on purpose
    append(broken, check_text(file, false));
  }
  append(broken, check_text({"Makefile", read(kRoot / "Makefile")}, true));
  EXPECT_THAT(broken, IsEmpty());
}

TEST(Docs, RelativeLinksLeadSomewhere) {
  std::vector<std::string> broken;
  for (const SourceFile& page : files({".md"})) {
    for (const Link& link : relative_links(page.text)) {
      const fs::path from = kRoot / page.path;
      const fs::path target = link.target.empty() ? from : from.parent_path() / link.target;
      const bool leads = fs::exists(target) && (link.section.empty() || target.extension() != ".md" ||
                                                sections_of(read(target)).contains(link.section));
      if (leads) continue;
      broken.push_back(page.path + ":" + std::to_string(link.line) + ": " + link.target + "#" + link.section);
    }
  }
  EXPECT_THAT(broken, IsEmpty());
}

// Tables, HTML, code and what is only a link may be wider.
TEST(Docs, ProseIsNoWiderThanCode) {
  constexpr std::ptrdiff_t kWidth = 120;
  const auto begins_character = [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; };
  const std::regex one_link{R"(\s*(?:[-*] )?!?\[[^\]]*\]\([^)]*\)[.,;:]?)"};
  std::vector<std::string> broken;
  for (const SourceFile& page : files({".md"})) {
    std::istringstream lines{page.text};
    bool fenced = false;
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
      if (line.compare(begin, 3, "```") == 0) fenced = !fenced;
      if (fenced || std::count_if(line.begin(), line.end(), begins_character) <= kWidth) continue;
      if (line[begin] == '|' || line[begin] == '<' || std::regex_match(line, one_link)) continue;
      broken.push_back(page.path + ":" + std::to_string(number) + ": more than 120 characters");
    }
  }
  EXPECT_THAT(broken, IsEmpty());
}

// Rows of docs/architecture.md that begin "| `module` |" and end in the modules it may include.
TEST(Docs, ModuleTableIsTheOneThatIsBuilt) {
  ModuleTable written;
  std::istringstream page{read(kRoot / "docs/architecture.md")};
  const std::regex row{R"(^\| `([a-z]+)` \|.*\| ([a-z, -]*) \|$)"};
  for (std::string line; std::getline(page, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    const std::string names = std::regex_replace(match[2].str(), std::regex{"[,-]"}, " ");
    const ModuleTable parsed = parse_module_table(match[1].str() + ":" + names);
    written.insert(parsed.begin(), parsed.end());
  }
  EXPECT_EQ(written, parse_module_table(read(CATAN_MODULE_TABLE)));
}

// Every target that a page tells people to make is in the Makefile.
TEST(Docs, MakeTargetsExist) {
  const std::string makefile = "\n" + read(kRoot / "Makefile");
  const std::regex command{R"((?:^|`)make ([a-z-]+))"};
  std::vector<std::string> broken;
  for (const SourceFile& page : files({".md"})) {
    std::istringstream lines{page.text};
    for (std::string line; std::getline(lines, line);) {
      for (std::sregex_iterator it(line.begin(), line.end(), command), end; it != end; ++it) {
        const std::string target = (*it)[1];
        if (makefile.find("\n" + target + ":") == std::string::npos) broken.push_back(page.path + ": make " + target);
      }
    }
  }
  EXPECT_THAT(broken, IsEmpty());
}

}  // namespace
}  // namespace ctn::architecture
