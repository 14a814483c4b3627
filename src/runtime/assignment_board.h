// How an assignment (policy/assignment.h) gets to controllers (controller_thread.h) that may never wait for it: the
// session's housekeeping thread publishes it on a board, and subchains pass from one controller to another by a
// hand-over.
//
// Units: in the types. Thread safety: as each class says.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "dispatch/shared_core_member.h"
#include "policy/assignment.h"

namespace ctn::runtime {

using policy::Assignment;

// Thread safety: publish() from one thread, read() from one thread a reader; neither waits.
class AssignmentBoard {
 public:
  explicit AssignmentBoard(std::size_t readers);
  // It never looks. Before the first publish(), or in its thread.
  void leave_out(std::size_t reader);

  // Numbers it. What no reader can be looking at any more is dropped.
  void publish(Assignment assignment);
  // The newest; good until the reader's next look. Precondition: there is one.
  const Assignment& read(std::size_t reader);
  // How many are kept, the newest included.
  std::size_t kept() const { return kept_.size(); }

 private:
  std::atomic<const Assignment*> latest_{nullptr};
  std::deque<std::atomic<std::uint64_t>> seen_;  // by reader: the number of the newest that it looked at
  std::deque<std::unique_ptr<const Assignment>> kept_;
  std::uint64_t published_ = 0;
};

// Holds a subchain on its way between two controllers, with the state of its runs: the one that hands it over puts it
// here, the next one takes it. At most one controller holds a subchain at a time.
// Thread safety: put() by the holder, take() by any thread; neither waits.
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
