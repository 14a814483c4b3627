#include "command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace ctn::tool {
namespace {

// Colours only where a person reads: on a terminal that has them, unless told not to (https://no-color.org).
bool stderr_has_colours() {
  const char* const no_color = std::getenv("NO_COLOR");
  const char* const term = std::getenv("TERM");
  return isatty(STDERR_FILENO) != 0 && (no_color == nullptr || *no_color == '\0') && term != nullptr &&
         std::string_view(term) != "dumb";
}

std::string shown(const Problem& problem, bool colours) {
  const bool placed = !problem.place.file.empty();
  if (!colours) return (placed ? "" : "catan: ") + to_string(problem);
  const std::string where = placed ? to_string(Problem{problem.place, {}, {}, {}}) : "catan: ";
  const std::string key = problem.key.empty() ? "" : problem.key + ": ";
  const std::string mend = problem.mend.empty() ? "" : fmt::format("; \x1b[32m{}\x1b[0m", problem.mend);
  return fmt::format("\x1b[1m{}\x1b[0m{}\x1b[31m{}\x1b[0m{}", where, key, problem.what, mend);
}

}  // namespace

int report_error(const Error& error) {
  const bool colours = stderr_has_colours();
  for (const Problem& problem : error.problems()) fmt::print(stderr, "{}\n", shown(problem, colours));
  return error.kind() == ErrorKind::kCaller ? kMistake : kFailure;
}

void note(std::string_view text) { fmt::print(stderr, "catan: {}\n", text); }

void print(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stdout); }

}  // namespace ctn::tool
