// Runs face_tracking once and takes what it prints. The thin layer that the rest is kept free of.
#pragma once

#include <string>

#include "base/result.h"
#include "results.h"

namespace ctn::demo {

// The command line, quoted for a shell.
std::string command_line(const std::string& program, const Trial& trial, double slowdown);

// Blocks until the program has ended; one that hangs is ended by timeout(1). What it says on stderr is added to `log`.
// A trial in which no picture reached the motor is run once more, for longer. Errors: kEnvironment, what went wrong.
Result<Measured> run_trial(const std::string& program, const Trial& trial, double slowdown, const std::string& log);

}  // namespace ctn::demo
