// Serving an app whose nodes are other processes', until something ends it: what `catan serve` and `catan run` share.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "config/app_file.h"
#include "runtime/server.h"
#include "watch.h"

namespace ctn::tool {

struct ServingOptions {
  runtime::SchedulerOptions scheduler;
  std::string socket;                              // empty: the usual one
  std::vector<std::string> users;                  // that may register in addition, by number
  std::vector<std::vector<std::string>> commands;  // started with CATAN_SOCKET set; serving ends when all have ended
  std::vector<std::string> environment;            // of the commands, in addition: NAME=value
  bool prints_data = false;                        // on standard output, so commands print to standard error
  std::optional<WatchedApp> watched;               // a process looks on, and saves the last seconds when that matters
  // Another process beside it, told where the server listens, and ended with it; should it end sooner, serving goes on.
  std::function<std::vector<std::string>(const std::string& socket)> companion;
  std::optional<double> seconds;  // to serve after the warm-up; else until a signal or the commands end it
  std::function<void(const Snapshot&, double measured_s)> on_progress;  // if given, called twice a second
};

struct Served {
  bool warmed_up = false;
  int signal = 0;     // that ended it; 0: none did
  int exit_code = 0;  // of the first command that failed (128 + n: killed by signal n), 0: none did
};

// Commands that still run at the end are asked to end (SIGTERM), and made to after two seconds.
Result<Served> serve(config::AppFile file, const ServingOptions& options);

}  // namespace ctn::tool
