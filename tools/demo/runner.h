// Runs face_tracking once and takes what it prints. The thin layer that the rest is kept free of.
#pragma once

#include <string>

#include "base/result.h"
#include "results.h"

namespace ctn::demo {

struct FaceTracking {
  std::string program;
  double slowdown = 1.0;
  std::string faces;  // what its first run has found in the film, and the others need not look for
  std::string log;    // what it says on stderr is added
};

// The command line, quoted for a shell.
std::string command_line(const FaceTracking& app, const Trial& trial);

// Blocks until the program has ended; one that hangs is ended by timeout(1). A trial in which no picture reached the
// motor is run once more, for longer. Errors: kEnvironment, what went wrong.
Result<Measured> run_trial(const FaceTracking& app, const Trial& trial);

}  // namespace ctn::demo
