// What a policy (policy.h) means for the threads that carry it out: for each subchain where it runs, at which level and
// how it is paced, for each core how those that share it take turns. A value; where there is a plan it follows from it.
//
// Units: in the types. Thread safety: plain values and pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "dispatch/shared_core_schedule.h"
#include "dispatch/subchain_trigger.h"
#include "graph/app.h"
#include "os/cpu_set.h"
#include "os/level.h"
#include "plan/plan.h"

namespace ctn::policy {

struct SubchainPlace {
  int core = -1;                           // that it shares; -1: it has `cpus` to itself
  os::CpuSet cpus;                         // where its threads run
  dispatch::Pacing pacing;                 // where it shares no core
  os::Level level = os::Level::kOrdinary;  // where it shares no core
  std::vector<os::Level> levels;           // the same node by node, in the order they run; empty: `level` for all
  bool present = true;                     // false: one of its nodes is missing, and no controller holds it
  int threads = 0;                         // that each of its nodes works on; 0: no plan says

  // Of its position-th node, where it shares no core.
  os::Level level_of(std::size_t position) const { return levels.empty() ? level : levels[position]; }

  friend bool operator==(const SubchainPlace&, const SubchainPlace&) = default;
};

struct Assignment {
  std::uint64_t number = 0;                         // of those published, counted from 1
  std::vector<SubchainPlace> places;                // by SubchainId
  std::vector<dispatch::SharedCoreSchedule> cores;  // by core; without slots where no subchains share it
};

// Removes the subchains that are not `present` (by SubchainId): no controller holds them, and the others go on without
// them; a follower of one of them is triggered by time.
void remove_absent(Assignment& assignment, const std::vector<bool>& present);

struct AssignmentOptions {
  bool stealing = true;
};

// Core k of the plan is the k-th of `cpus`. Preconditions: the plan is valid for the app, on as many cores as `cpus`.
Assignment assignment_of(const graph::App& app, const plan::Plan& plan, const os::CpuSet& cpus,
                         const AssignmentOptions& options);

}  // namespace ctn::policy
