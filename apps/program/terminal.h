// How the apps' programs talk to who started them: errors, the live line, the result, and signals that end them early.
//
// Thread safety: one thread, except note().
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "catan/result.h"
#include "program/leave.h"

namespace ctn::program {

// Prints the error on stderr, behind the program's name. Returns the exit code.
int fail(const char* program, const Error& error);

// What the user should know, on stderr, behind the program's name, as far as that can be written: a log that is full is
// no reason to end. Any thread may call it.
void note(const char* program, const std::string& text);

// Prints the result on stdout. Returns the exit code: 128 + `signal` where a signal (not 0) has ended the program.
int print(const std::string& text, int signal);

// Prints what a program leaves with. Returns the exit code.
int print(const Leave& leave);

// The live line on a terminal; nothing where stderr is none.
class StatusLine {
 public:
  StatusLine();
  void show(const std::string& line);
  void clear();

 private:
  bool terminal_;
};

// From now on SIGINT and SIGTERM are remembered, and end nothing by themselves.
void remember_signals();
// The last that came; 0: none.
int signal_so_far();

// The main function of a program: what parse_options(argc, argv) made of its command line, and `run(options)`, which
// returns the exit code. Signals are remembered meanwhile.
template <class Options, class Run>
int run_program(std::variant<Options, Leave> parsed, const Run& run) {
  if (const Leave* const leave = std::get_if<Leave>(&parsed)) return print(*leave);
  remember_signals();
  return run(std::get<Options>(std::move(parsed)));
}

}  // namespace ctn::program
