// An app in one process, on whatever operating system it is given: the nodes' threads, and a scheduler for them.
// include/catan/session.h is this engine on Linux; the tests run it in virtual time.
//
// Threads: the scheduler's (scheduler.h), and one a node that is not external.
//
// Units: in the types. Thread safety: as include/catan/session.h says.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "catan/snapshot.h"
#include "graph/app.h"
#include "os/os.h"
#include "runtime/clock_watch.h"
#include "runtime/node_threads.h"
#include "runtime/region.h"
#include "runtime/scheduler.h"
#include "runtime/wiring.h"

namespace ctn::runtime {

using EngineOptions = SchedulerOptions;

class Engine {
 public:
  static Result<std::unique_ptr<Engine>> create(graph::App app, os::Os& os, EngineOptions options);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  const graph::App& app() const { return app_; }
  Wiring& wiring() { return wiring_; }

  Status start();
  Status stop();
  Status adopt_this_thread(std::string_view node);
  Status tick(std::string_view node, TimePoint at) { return tell_tick(app_, memory_.region(), node, at); }
  Status change(const Changes& changes) { return scheduler_->change(changes); }
  Snapshot snapshot() const { return scheduler_->snapshot(); }
  Status save_flight(const std::string& path, const std::string& why) const {
    return scheduler_->save_flight(path, why);
  }

 private:
  Engine(graph::App app, os::Os& os, std::size_t cores);

  Status prepare_and_start();

  graph::App app_;
  os::Os& os_;
  LocalRegion memory_;
  Wiring wiring_;
  NodeThreads nodes_;
  std::unique_ptr<Scheduler> scheduler_;
  enum class State { kNew, kRunning, kStopped } state_ = State::kNew;
  Status stopped_ = Done{};
};

}  // namespace ctn::runtime
