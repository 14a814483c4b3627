// The threads of controllers (driver/controller.h), in virtual time: the drivers that the runtime has
// (runtime/controller_thread.h), one a subchain and under a plan one a core, each stepped when its thread has a CPU, at
// what that costs on the machine.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "driver/actuator.h"
#include "driver/core_driver.h"
#include "driver/planning_loop.h"
#include "driver/subchain_pacer.h"
#include "graph/app.h"
#include "policy/assignment.h"
#include "sim/cpus.h"
#include "sim/machine.h"
#include "sim/nodes.h"
#include "sim/outcome.h"

namespace ctn::sim {

class Controllers final : private driver::Actuator {
 public:
  // Controllers are numbered: subchains, then cores (none where `cores` is 0). Their threads are `first` and those that
  // follow. All outlive it.
  Controllers(const graph::App& app, const Machine& machine, int cores, Nodes& nodes, Cpus& cpus, Cpus::Thread first,
              EventLog& event_log);
  Controllers(const Controllers&) = delete;
  Controllers& operator=(const Controllers&) = delete;

  std::size_t count() const { return sleeping_.size(); }

  // How the clocks of external nodes tick, by NodeId; without a period where there is none. Before start().
  void know_clocks(std::vector<Ticks> clocks) { clocks_ = std::move(clocks); }
  // They begin under that assignment, each when the first of its subchains does: `first`, by SubchainId, or empty.
  void start(policy::Assignment assignment, const os::CpuSet& cpus, os::Level level, const std::vector<Nanos>& first);
  // A new one: all are woken to look.
  void publish(policy::Assignment assignment);
  void set_level(os::Level level);
  void wake(std::size_t controller, int from_cpu);
  // So far.
  const driver::ControllerWork& work() const { return work_; }

  // --- by the CPUs' client; threads counted from `first` ---
  Nanos begin(Cpus::Thread thread, int cpu);
  bool done(Cpus::Thread thread);

 private:
  struct Sleeping {
    bool woken = false;
    TimePoint until = kNever;
  };

  void take_over(policy::Assignment assignment);
  Nanos first_of(std::size_t controller, const std::vector<Nanos>& first) const;

  // --- driver::Actuator, for the controller that acts ---
  const policy::Assignment& assignment() override { return assignment_; }
  std::optional<dispatch::RunState> take(SubchainId subchain) override;
  void hand_over(SubchainId subchain, const dispatch::RunState& state) override;
  void move(SubchainId subchain, const os::CpuSet& cpus) override { nodes_.move(subchain, cpus); }
  void set_level(SubchainId subchain, os::Level level) override { nodes_.set_level(subchain, level); }
  void set_levels(SubchainId subchain, const policy::SubchainPlace& place) override {
    nodes_.set_levels(subchain, place);
  }
  bool threads_joined() override { return false; }  // all are there from the start
  void trigger(SubchainId subchain, std::uint64_t number, TimePoint due) override;
  std::uint64_t completed(SubchainId subchain) const override { return nodes_.signal(subchain).completed; }
  void await_completion(SubchainId subchain, bool wanted, std::uint64_t /*known*/) override {
    nodes_.signal(subchain).wants_completions = wanted;
  }
  void begin_run(SubchainId subchain) override { used_before_[subchain.index()] = nodes_.cpu_time(subchain); }
  Nanos cpu_time(SubchainId subchain) override { return nodes_.cpu_time(subchain) - used_before_[subchain.index()]; }
  Outputs outputs(const plan::Leader& leader) const override {
    return {nodes_.outputs(leader).count, nodes_.outputs(leader).newest};
  }
  bool await_outputs(const plan::Leader& leader, std::uint64_t count) override;
  void ignore_outputs(const plan::Leader& leader) override;
  std::optional<Ticks> clock(NodeId node) const override { return clocks_[node.index()]; }
  void slot_over(const dispatch::SlotUse& slot) override { event_log_.slot_over(slot); }
  void stole(const dispatch::Steal& steal) override { event_log_.stole(steal); }
  void hang_changed(SubchainId subchain, bool began, TimePoint at) override {
    event_log_.hang_changed(subchain, began, at);
  }
  void over_budget(const dispatch::Overrun& overrun) override { event_log_.over_budget(overrun); }

  MachineCosts costs_;
  Nodes& nodes_;
  Cpus& cpus_;
  Cpus::Thread first_;
  EventLog& event_log_;
  policy::Assignment assignment_;
  std::vector<Ticks> clocks_;  // by NodeId
  std::vector<driver::SubchainPacer> pacers_;
  std::vector<driver::CoreDriver> cores_;
  std::vector<Sleeping> sleeping_;                              // by controller
  std::vector<std::optional<dispatch::RunState>> handed_over_;  // by subchain
  std::vector<Nanos> used_before_;                              // by subchain: CPU time, when its run was triggered
  std::size_t acting_ = 0;                                      // the controller that steps now,
  int cpu_ = -1;                                                // and where
  driver::ControllerWork work_;
  bool real_time_;
};

}  // namespace ctn::sim
