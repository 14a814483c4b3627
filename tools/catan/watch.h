// `catan watch`: a process that reads the flight recorder of a running app, and saves the last seconds when a response
// is late or the app is killed. `catan run` and `catan serve` start one beside them.
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

  // kCaller: all that is wrong with these options for this app.
  Status check(const graph::App& app, int flight_recorder_mib) const;

  // Starts `catan watch TARGET` (attach.h says what a target may be) for an app that has just begun. It must outlive
  // the app, to save the app's last seconds: let_end().
  Result<os::ChildProcess> start_watching(const std::string& target) const;

  // Waits until the watch of an app that is over has ended by itself: a tenth of a second, or seconds where it had no
  // CPU until now. Without chains it has nothing to save, and is not waited for. To be called while the memory of the
  // app's flight recorder is still there.
  void let_end(os::Clock& clock, os::ChildProcess& watch) const;
};

// kCaller: all texts that name no chain.
Result<std::vector<flight::WatchedChain>> watched_chains(const graph::App& app, const std::vector<std::string>& texts);

}  // namespace ctn::tool
