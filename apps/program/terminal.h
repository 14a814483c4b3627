// How the apps' programs talk to who started them: errors, the live line, the result, and signals that end them early.
//
// Thread safety: one thread.
#pragma once

#include <string>

#include "catan/result.h"

namespace ctn::program {

// Prints the error on stderr, behind the program's name. Returns the exit code.
int fail(const char* program, const Error& error);

// Prints the result on stdout. Returns the exit code: 128 + `signal` where a signal (not 0) has ended the program.
int print(const std::string& text, int signal);

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

}  // namespace ctn::program
