// The threads at the dispatcher level: spawned behind a gate, placed, started together, and stopped.
//
// Thread safety: publish(), raise(), move_to_online_cpus(), keep_on_cpus(), all() and work() by the housekeeping thread
// while it runs; else one thread, which starts and stops the session.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/result.h"
#include "driver/planning_loop.h"
#include "graph/app.h"
#include "os/os.h"
#include "runtime/controller_thread.h"
#include "runtime/enforcer.h"
#include "runtime/node_link.h"
#include "runtime/region.h"

namespace ctn::runtime {

using Controllers = std::vector<std::unique_ptr<ControllerThread>>;

class ControllerThreads {
 public:
  // `cpus`: the CPUs that the session was given; each has one controller of a core. References outlive it.
  ControllerThreads(const graph::App& app, os::Os& os, Enforcer& enforcer, const Region& region, const Links& links,
                    os::CpuSet cpus);
  ~ControllerThreads() { stop(); }
  ControllerThreads(const ControllerThreads&) = delete;
  ControllerThreads& operator=(const ControllerThreads&) = delete;

  // One a subchain and, where cores may be `shared`, one a core. They wait at the gate until go() or stop().
  // Precondition: an assignment was published.
  void spawn(bool shared);
  // Errors: a CPU that cannot be had.
  Status place(os::Level level);
  void go();
  // While they run; a higher one than before.
  void raise(os::Level level);
  // They end; a thread at the gate ends without having begun.
  void stop();

  // What they carry out from now on.
  void publish(Assignment assignment);
  // What is known of a clock of others from now on.
  void know_clock(NodeId node, const Ticks& ticks) { controls_.clocks.write(node, ticks); }
  // Of the CPUs that were given, these are left.
  void move_to_online_cpus(const os::CpuSet& online);
  // The same, of controllers that another program has moved.
  void keep_on_cpus(const os::CpuSet& online);

  // Between holders, a subchain's state can be taken out and put back (assignment_board.h).
  Handover& handover(SubchainId subchain) { return controls_.handovers[subchain.index()]; }
  const Controllers& all() const { return controllers_; }

  // So far. While they run.
  driver::ControllerWork work() const;

 private:
  os::CpuSet cpus_of(std::size_t controller, const os::CpuSet& online) const;

  const graph::App& app_;
  os::Os& os_;
  Enforcer& enforcer_;
  const os::CpuSet cpus_;
  const std::vector<SubchainLinks> subchains_;
  Controls controls_;
  Controllers controllers_;  // subchains, then cores
  std::vector<os::ThreadId> ids_;
  std::vector<std::unique_ptr<os::Thread>> threads_;
  std::atomic<std::uint32_t> ready_{0};
  enum Gate : std::uint32_t { kClosed, kOpen, kAbandoned };
  std::atomic<std::uint32_t> gate_{kClosed};
};

}  // namespace ctn::runtime
