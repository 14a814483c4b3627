#include "architecture/source_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <regex>
#include <set>
#include <sstream>

namespace ctn::architecture {
namespace {

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  std::istringstream stream{std::string(text)};
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

enum class Strings { kKeep, kBlank };

// The index past a string or character literal that begins at `begin`.
std::size_t end_of_literal(std::string_view text, std::size_t begin) {
  if (text[begin] == '"' && begin > 0 && text[begin - 1] == 'R') {
    const std::size_t open = text.find('(', begin);
    if (open == std::string_view::npos) return text.size();
    const std::string close = ")" + std::string(text.substr(begin + 1, open - begin - 1)) + "\"";
    const std::size_t end = text.find(close, open);
    return end == std::string_view::npos ? text.size() : end + close.size();
  }
  std::size_t i = begin + 1;
  while (i < text.size() && text[i] != text[begin] && text[i] != '\n') i += text[i] == '\\' ? 2 : 1;
  return std::min(i + 1, text.size());
}

// Comments (and, if asked, literals) become blanks; line numbers stay.
std::string without_comments(std::string_view text, Strings strings) {
  std::string out(text);
  const auto blank = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (out[i] != '\n') out[i] = ' ';
    }
  };
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i + 1;
    if (text.substr(i, 2) == "//") {
      end = std::min(text.find('\n', i), text.size());
      blank(i, end);
    } else if (text.substr(i, 2) == "/*") {
      const std::size_t close = text.find("*/", i + 2);
      end = close == std::string_view::npos ? text.size() : close + 2;
      blank(i, end);
    } else if (text[i] == '"' ||
               (text[i] == '\'' && (i == 0 || std::isalnum(static_cast<unsigned char>(text[i - 1])) == 0))) {
      end = end_of_literal(text, i);
      if (strings == Strings::kBlank) blank(i + 1, end - 1);
    }
    i = end;
  }
  return out;
}

bool starts_with_any(std::string_view path, std::initializer_list<std::string_view> prefixes) {
  for (const std::string_view prefix : prefixes) {
    if (path.starts_with(prefix)) return true;
  }
  return false;
}

struct Include {
  int line = 0;
  bool quoted = false;
  std::string target;

  std::string folder() const {
    const std::size_t slash = target.find('/');
    return slash == std::string::npos ? std::string{} : target.substr(0, slash);
  }
};

std::vector<Include> includes_of(std::string_view text) {
  static const std::regex pattern{R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])"};
  std::vector<Include> includes;
  int number = 0;
  for (const std::string& line : lines_of(without_comments(text, Strings::kKeep))) {
    ++number;
    std::smatch match;
    if (line.find('#') != std::string::npos && std::regex_search(line, match, pattern))
      includes.push_back({number, match[1] == "\"", match[2]});
  }
  return includes;
}

// Which module's header a quoted include names. The public headers are the api's, save for those that need no library:
// the error types, what a node's function is given, and a session's figures.
std::string module_of(const Include& include) {
  if (include.folder() != "catan") return include.folder();
  static const std::set<std::string> by_themselves{"catan/awaited.h", "catan/result.h",   "catan/run.h",
                                                   "catan/channel.h", "catan/snapshot.h", "catan/summary.h",
                                                   "catan/changes.h"};
  return by_themselves.contains(include.target) ? "base" : "api";
}

class Checker {
 public:
  Checker(const SourceFile& file, const ModuleTable& modules)
      : file_(file), modules_(modules), includes_(includes_of(file.text)) {}

  std::vector<std::string> run() {
    check_module_includes();
    check_public_headers();
    check_users_of_the_api();
    check_operating_system();
    check_clocks();
    check_waits();
    check_header_guard();
    return std::move(found_);
  }

 private:
  bool in(std::initializer_list<std::string_view> prefixes) const { return starts_with_any(file_.path, prefixes); }
  void report(int line, std::string_view what) { found_.push_back(fmt::format("{}:{}: {}", file_.path, line, what)); }

  bool for_tests() const {
    return file_.path.ends_with("_test.cpp") || file_.path.find("/testing/") != std::string::npos;
  }

  // What is for tests alone may use the fake system, whatever its module.
  void check_module_includes() {
    if (!in({"src/"})) return;
    const std::string module = file_.path.substr(4, file_.path.find('/', 4) - 4);
    const auto row = modules_.find(module);
    if (row == modules_.end()) return report(1, fmt::format("src/{} is no module of the build", module));
    for (const Include& include : includes_) {
      if (!include.quoted) {
        if (modules_.contains(include.folder())) report(include.line, "a module's header is included with quotes");
        continue;
      }
      const std::string other = module_of(include);
      if (for_tests() && include.target.starts_with("os/fake/")) continue;
      if (!modules_.contains(other)) {
        report(include.line, fmt::format("\"{}\" does not start with the name of a module", include.target));
      } else if (other != module && !row->second.contains(other)) {
        report(include.line, fmt::format("{} may not include {}", module, other));
      }
    }
  }

  // The public API needs nothing but the standard library: C++'s, and in its one C header C's.
  void check_public_headers() {
    if (!in({"include/"})) return;
    const bool is_c = file_.path == "include/catan/catan.h";
    for (const Include& include : includes_) {
      const bool standard = !include.quoted && (is_c ? include.target == "stddef.h" || include.target == "stdint.h"
                                                     : include.target.find_first_of("/.") == std::string::npos);
      if (!standard && !(include.quoted && include.folder() == "catan")) {
        report(include.line, fmt::format("a public header may not include {}", include.target));
      }
    }
  }

  void check_users_of_the_api() {
    if (!in({"apps/", "examples/", "integrations/"})) return;
    const std::string folder = file_.path.substr(0, file_.path.find('/'));
    for (const Include& include : includes_) {
      if (include.quoted && modules_.contains(include.folder())) {
        report(include.line, fmt::format("{} use only the public API, not {}", folder, include.target));
      }
    }
  }

  void check_operating_system() {
    if (!in({"src/", "include/", "apps/", "tools/"})) return;
    static const std::regex system_header{R"((sched|pthread)\.h|(sys|linux)/.*)"};
    for (const Include& include : includes_) {
      if (!in({"src/os/linux/"}) && !include.quoted && std::regex_match(include.target, system_header)) {
        report(include.line, fmt::format("only os/linux may include <{}>", include.target));
      }
    }
    static const std::regex policy{R"(\bSCHED_[A-Z]+)"};
    if (!in({"src/os/"}))
      match_lines(policy, {"SCHED_"}, Strings::kKeep, "only os knows scheduling classes; here they are levels");
  }

  void check_clocks() {
    static const std::regex clock{
        R"(\b(steady_clock|system_clock|high_resolution_clock)\s*::\s*now\b|\bclock_gettime\b|\bgettimeofday\b)"
        R"(|\btimespec_get\b|(?:^|[^\w.>])time\s*\(\s*(nullptr|NULL|0)\s*\))"};
    if (in({"src/"}) && !in({"src/os/"})) {
      match_lines(clock, {"clock", "time"}, Strings::kBlank, "only os reads a clock");
    }
  }

  // Os::wait(): the word may have changed for the last time since whoever waits looked at it. Tests may try that.
  void check_waits() {
    if (file_.path.ends_with("_test.cpp")) return;
    static const std::regex waits_for_now{R"(\bwait\s*\(\s*(\w+)\s*,\s*\1\s*\.\s*load\b)"};
    match_lines(waits_for_now, {"wait"}, Strings::kBlank,
                "wait for a change of the value that was looked at, not of the newest");
  }

  void check_header_guard() {
    if (!file_.path.ends_with(".h")) return;
    for (const std::string& line : lines_of(without_comments(file_.text, Strings::kBlank))) {
      if (line == "#pragma once") return;
    }
    report(1, "a header has #pragma once");
  }

  // Each match has one of the words in it, which is a hundred times as fast to find out.
  void match_lines(const std::regex& pattern, std::initializer_list<std::string_view> words, Strings strings,
                   std::string_view what) {
    int number = 0;
    for (const std::string& line : lines_of(without_comments(file_.text, strings))) {
      ++number;
      const auto in_line = [&](std::string_view word) { return line.find(word) != std::string::npos; };
      if (std::any_of(words.begin(), words.end(), in_line) && std::regex_search(line, pattern)) report(number, what);
    }
  }

  const SourceFile& file_;
  const ModuleTable& modules_;
  std::vector<Include> includes_;
  std::vector<std::string> found_;
};

// The length of the UTF-8 sequence at the front of `text`; none where there is no valid one.
std::optional<std::size_t> utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return std::nullopt;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return std::nullopt;
  }
  const bool overlong = (lead == 0xE0 && byte(1) < 0xA0) || (lead == 0xF0 && byte(1) < 0x90);
  const bool beyond = (lead == 0xED && byte(1) > 0x9F) || (lead == 0xF4 && byte(1) > 0x8F);
  if (overlong || beyond) return std::nullopt;
  return length;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::optional<std::size_t> length = utf8_length(text);
    if (!length) return false;
    text.remove_prefix(*length);
  }
  return true;
}

// The lines of a Markdown page that are no code.
void for_each_line_of_text(std::string_view markdown, const std::function<void(int, const std::string&)>& visit) {
  bool fenced = false;
  int number = 0;
  for (const std::string& line : lines_of(markdown)) {
    ++number;
    if (line.starts_with("```")) fenced = !fenced;
    if (!fenced) visit(number, line);
  }
}

}  // namespace

ModuleTable parse_module_table(std::string_view text) {
  ModuleTable table;
  for (const std::string& line : lines_of(text)) {
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    std::istringstream names{line.substr(colon + 1)};
    std::set<std::string>& row = table[line.substr(0, colon)];
    for (std::string name; names >> name;) row.insert(name);
  }
  return table;
}

std::vector<std::string> check_source(const SourceFile& file, const ModuleTable& modules) {
  return Checker(file, modules).run();
}

std::vector<std::string> check_text(const SourceFile& file, bool tabs_allowed) {
  std::vector<std::string> found;
  const auto report = [&](int line, std::string_view what) {
    found.push_back(fmt::format("{}:{}: {}", file.path, line, what));
  };
  int number = 0;
  for (const std::string& line : lines_of(file.text)) {
    ++number;
    if (!is_utf8(line)) report(number, "not UTF-8");
    if (!tabs_allowed && line.find('\t') != std::string::npos) report(number, "a tab");
    if (line.find_last_not_of(" \t\r") + 1 != line.size()) report(number, "blanks at the end of the line");
  }
  if (!file.text.empty() && !file.text.ends_with('\n')) report(number, "no newline at the end of the file");
  return found;
}

std::vector<Link> relative_links(std::string_view markdown) {
  static const std::regex pattern{R"re(\]\(\s*<?([^)\s>]+)|\b(?:src|href)="([^"]+)")re"};
  static const std::regex elsewhere{R"(^([a-z]+:|//).*)"};
  static const std::regex not_shown{R"(`[^`]*`|<!--.*?-->)"};
  std::vector<Link> links;
  for_each_line_of_text(markdown, [&](int number, const std::string& written) {
    const std::string line = std::regex_replace(written, not_shown, "");
    for (std::sregex_iterator it(line.begin(), line.end(), pattern), end; it != end; ++it) {
      const std::string target = (*it)[1].matched ? (*it)[1] : (*it)[2];
      if (std::regex_match(target, elsewhere)) continue;
      const std::size_t hash = std::min(target.find('#'), target.size());
      links.push_back({number, target.substr(0, hash), target.substr(std::min(hash + 1, target.size()))});
    }
  });
  return links;
}

std::set<std::string> sections_of(std::string_view markdown) {
  static const std::regex heading{R"(^#+ +(.*))"};
  static const std::regex linked{R"(\[([^\]]*)\]\([^)]*\))"};
  static const std::regex id{R"re(\bid="([^"]+)")re"};
  std::set<std::string> sections;
  for_each_line_of_text(markdown, [&](int, const std::string& line) {
    std::smatch match;
    if (std::regex_search(line, match, id)) sections.insert(match[1]);
    if (!std::regex_match(line, match, heading)) return;
    std::string section;
    for (const char c : std::regex_replace(match[1].str(), linked, "$1")) {
      const auto byte = static_cast<unsigned char>(c);
      if (c == ' ') section += '-';
      if (std::isalnum(byte) != 0 || c == '-' || c == '_') section += static_cast<char>(std::tolower(byte));
    }
    sections.insert(section);
  });
  return sections;
}

}  // namespace ctn::architecture
