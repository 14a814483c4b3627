// What a plan means for the threads that carry it out: for each subchain where it runs and how it is paced, for each
// core how those that share it take turns. A value, made from a plan; and the board on which the session's housekeeper
// publishes it to controllers (controller.h) that may never wait for it.
//
// Units: in the types. Thread safety: as each class says.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "dispatch/shared_core_member.h"
#include "dispatch/shared_core_schedule.h"
#include "dispatch/subchain_trigger.h"
#include "graph/app.h"
#include "os/os.h"
#include "plan/plan.h"

namespace ctn::runtime {

struct SubchainPlace {
  int core = -1;                           // that it shares; -1: it has `cpus` to itself
  os::CpuSet cpus;                         // where its threads run
  dispatch::Pacing pacing;                 // where it shares no core
  os::Level level = os::Level::kOrdinary;  // where it shares no core

  friend bool operator==(const SubchainPlace&, const SubchainPlace&) = default;
};

struct Assignment {
  std::uint64_t number = 0;                         // of those published, counted from 1
  std::vector<SubchainPlace> places;                // by SubchainId
  std::vector<dispatch::SharedCoreSchedule> cores;  // by core; without slots where nobody shares
};

struct AssignmentOptions {
  bool stealing = true;
};

// Core k of the plan is the k-th of `cpus`. Preconditions: the plan is valid for the app, on as many cores as `cpus`.
Assignment assignment_of(const graph::App& app, const plan::Plan& plan, const os::CpuSet& cpus,
                         const AssignmentOptions& options);

// Thread safety: publish() from one thread, look() from one thread a reader; neither waits.
class AssignmentBoard {
 public:
  explicit AssignmentBoard(std::size_t readers);

  // Numbers it. What no reader can be looking at any more is dropped.
  void publish(Assignment assignment);
  // The newest; good until the reader's next look. Precondition: there is one.
  const Assignment& look(std::size_t reader);

 private:
  std::atomic<const Assignment*> latest_{nullptr};
  std::deque<std::atomic<std::uint64_t>> seen_;  // by reader: the number of the newest that it looked at
  std::deque<std::unique_ptr<const Assignment>> kept_;
  std::uint64_t published_ = 0;
};

// Where a subchain lies between two controllers, with the state of its runs: whoever lets go of one puts it here,
// whoever is to have it takes it. At most one controller holds a subchain at a time.
// Thread safety: put() by the holder, take() by anybody; neither waits.
class Handover {
 public:
  void put(const dispatch::RunState& state) {
    state_ = state;
    full_.store(true, std::memory_order_release);
  }
  std::optional<dispatch::RunState> take() {
    if (!full_.load(std::memory_order_relaxed) || !full_.exchange(false, std::memory_order_acquire)) {
      return std::nullopt;
    }
    return state_;
  }

 private:
  std::atomic<bool> full_{false};
  dispatch::RunState state_;
};

}  // namespace ctn::runtime
