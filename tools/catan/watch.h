// A process that looks on while an app runs, and saves its last seconds when that matters: what `catan watch` does, and
// what `catan run` and `catan serve` start beside them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "flight/late_watch.h"
#include "graph/app.h"
#include "os/linux/child_process.h"

namespace CLI {
class App;
}

namespace ctn::tool {

// When the last seconds are saved, and where.
struct WatchedApp {
  std::vector<std::string> on_late;  // "CHAIN" or "CHAIN>MS"
  std::string folder = ".";
  int at_most = 20;

  void add_to(CLI::App& command);

  // kCaller: all that is wrong with it for this app.
  Status check(const graph::App& app, int flight_recorder_mib) const;

  // Starts `catan watch` for what schedules there (attach.h). It must outlive what it watches, so its owner waits for
  // it when that has ended.
  Result<os::ChildProcess> start_watching(const std::string& target) const;
};

// kCaller: all that names no chain.
Result<std::vector<flight::WatchedChain>> watched_chains(const graph::App& app, const std::vector<std::string>& texts);

}  // namespace ctn::tool
