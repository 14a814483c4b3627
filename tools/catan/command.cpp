#include "command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "os/linux/log_output.h"

namespace ctn::tool {
namespace {

// Colours only where a person reads: on a terminal that has them, unless told not to (https://no-color.org).
bool has_colours(int file) {
  const char* const no_color = std::getenv("NO_COLOR");
  const char* const term = std::getenv("TERM");
  return isatty(file) != 0 && (no_color == nullptr || *no_color == '\0') && term != nullptr &&
         std::string_view(term) != "dumb";
}

std::string shown(const Problem& problem, bool colours) {
  const bool placed = !problem.place.file.empty();
  if (!colours) return (placed ? "" : "catan: ") + to_string(problem);
  const std::string where = placed ? to_string(Problem{problem.place, {}, {}, {}}) : "catan: ";
  const std::string key = problem.key.empty() ? "" : problem.key + ": ";
  const std::string hint = problem.hint.empty() ? "" : fmt::format("; \x1b[32m{}\x1b[0m", problem.hint);
  return fmt::format("\x1b[1m{}\x1b[0m{}\x1b[31m{}\x1b[0m{}", where, key, problem.what, hint);
}

// With whoever reads stderr, at the end.
constexpr std::chrono::milliseconds kLastWords{500};

// Nothing: stderr is written at once. It is set before there are other threads.
std::unique_ptr<os::LogOutput>& log_on_stderr() {
  static std::unique_ptr<os::LogOutput> log;
  return log;
}

}  // namespace

void print_on_stderr(std::string_view text) {
  if (os::LogOutput* const log = log_on_stderr().get()) return log->write(std::string(text));
  std::fwrite(text.data(), 1, text.size(), stderr);
}

int report_error(const Error& error) {
  const bool colours = has_colours(STDERR_FILENO);
  for (const Problem& problem : error.problems()) print_on_stderr(shown(problem, colours) + "\n");
  return error.kind() == ErrorKind::kCaller ? kMistake : kFailure;
}

void note(std::string_view text) { print_on_stderr(fmt::format("catan: {}\n", text)); }

// A handler, since unlike a signal that is ignored it is not handed on to programs that are started.
void outlive_readers() {
  static_cast<void>(std::signal(SIGPIPE, [](int) {}));
  if (log_on_stderr()) return;
  log_on_stderr() = std::make_unique<os::LogOutput>(STDERR_FILENO, [](std::uint64_t lines) {
    return fmt::format("catan: {} lines are missing here: nobody read what was before them\n", lines);
  });
}

void finish_stderr() {
  if (log_on_stderr()) static_cast<void>(log_on_stderr()->finish(kLastWords));
}

bool stdout_has_colours() { return has_colours(STDOUT_FILENO); }

void print(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stdout); }

}  // namespace ctn::tool
