// The threads that trigger subchains, as the runtime has them (runtime/trigger_thread.h, core_thread.h): the same state
// machines of `dispatch`, driven by virtual time. One a subchain, which paces it while it shares no core, and under a
// plan one a core, which takes turns among those that share it. At any time one of them holds a subchain, or none does.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "dispatch/shared_core_dispatcher.h"
#include "dispatch/subchain_trigger.h"
#include "graph/app.h"
#include "policy/assignment.h"
#include "sim/cpus.h"
#include "sim/journal.h"
#include "sim/machine.h"
#include "sim/nodes.h"

namespace ctn::sim {

class Controllers {
 public:
  // Controllers are numbered: subchains, then cores (none where `cores` is 0). Their threads are `first` and those that
  // follow. All outlive it.
  Controllers(const graph::App& app, const Machine& machine, int cores, Nodes& nodes, Cpus& cpus, Cpus::Thread first,
              Journal& journal);

  std::size_t count() const { return sleeping_.size(); }

  // They begin under that assignment, each when the first of its subchains does: `first`, by SubchainId, or empty.
  void start(policy::Assignment assignment, const os::CpuSet& cpus, os::Level level, const std::vector<Nanos>& first);
  // A new one: all are woken to look.
  void publish(policy::Assignment assignment);
  void nudge(std::size_t controller, int from_cpu);

  // --- by the CPUs' client; threads counted from `first` ---
  Nanos begin(Cpus::Thread thread, int cpu);
  bool done(Cpus::Thread thread);

 private:
  struct Sleeping {
    bool nudged = false;
    TimePoint until = kNever;
  };
  struct Pacer {  // of one subchain
    SubchainId subchain;
    std::uint64_t following = 0;
    policy::SubchainPlace place;
    std::optional<dispatch::SubchainTrigger> trigger;  // none: the subchain is not in its hands
    bool contained = false;
  };
  struct Core {
    int number = 0;
    std::uint64_t following = 0;
    dispatch::SharedCoreDispatcher dispatcher{TimePoint{}, {}};
    std::vector<std::uint64_t> progress;
    std::optional<SubchainId> awaited;
    std::vector<SubchainId> absent;  // slots of the assignment followed that have not come yet
  };

  std::size_t number_of_core(int core) const { return pacers_.size() + static_cast<std::size_t>(core); }

  void take_over(policy::Assignment assignment);
  Nanos first_of(std::size_t controller, const std::vector<Nanos>& first) const;

  TimePoint step(Pacer& pacer, int cpu);
  void follow(Pacer& pacer);
  void give_up(Pacer& pacer);
  TimePoint step(Core& core, int cpu);
  void follow(Core& core);
  void carry_out(Core& core, const dispatch::SharedCoreDispatcher::Decision& decision, int cpu);

  void hold(SubchainId subchain, std::size_t controller, const os::CpuSet& cpus);
  void hand_over(SubchainId subchain, const dispatch::RunState& state);

  MachineCosts costs_;
  Nodes& nodes_;
  Cpus& cpus_;
  Cpus::Thread first_;
  Journal& journal_;
  policy::Assignment assignment_;
  std::vector<Pacer> pacers_;
  std::vector<Core> cores_;
  std::vector<Sleeping> sleeping_;                              // by controller
  std::vector<std::optional<dispatch::RunState>> handed_over_;  // by subchain
  bool real_time_;
};

}  // namespace ctn::sim
