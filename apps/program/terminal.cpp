#include "program/terminal.h"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>

namespace ctn::program {
namespace {

volatile std::sig_atomic_t g_signal = 0;

}  // namespace

int fail(const char* program, const Error& error) {
  note(program, error.message());
  return error.kind() == ErrorKind::kCaller ? kMistake : kFailure;
}

void note(const char* program, const std::string& text) {
  const std::string line = fmt::format("{}: {}\n", program, text);
  std::fwrite(line.data(), 1, line.size(), stderr);
}

int print(const std::string& text, int signal) {
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) return kFailure;
  return signal == 0 ? 0 : 128 + signal;
}

int print(const Leave& leave) {
  fmt::print(leave.code == 0 ? stdout : stderr, "{}", leave.text);
  return leave.code;
}

StatusLine::StatusLine() : terminal_(isatty(STDERR_FILENO) == 1) {}

void StatusLine::show(const std::string& line) {
  if (terminal_) fmt::print(stderr, "\r\033[K{}", line);
}

void StatusLine::clear() {
  if (terminal_) fmt::print(stderr, "\r\033[K");
}

void remember_signals() {
  for (const int number : {SIGINT, SIGTERM}) {
    std::signal(number, [](int received) { g_signal = received; });
  }
}

int signal_so_far() { return static_cast<int>(g_signal); }

}  // namespace ctn::program
