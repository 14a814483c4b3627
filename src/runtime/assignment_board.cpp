#include "runtime/assignment_board.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace ctn::runtime {

AssignmentBoard::AssignmentBoard(std::size_t readers) : seen_(readers) {}

void AssignmentBoard::leave_out(std::size_t reader) {
  seen_[reader].store(std::numeric_limits<std::uint64_t>::max(), std::memory_order_release);
}

void AssignmentBoard::publish(Assignment assignment) {
  assignment.number = ++published_;
  kept_.push_back(std::make_unique<const Assignment>(std::move(assignment)));
  latest_.store(kept_.back().get(), std::memory_order_release);
  // A reader that is just loading one has not said so yet: it may load what was the newest when it looked last, or
  // anything since.
  std::uint64_t oldest = published_;
  for (const std::atomic<std::uint64_t>& seen : seen_) oldest = std::min(oldest, seen.load(std::memory_order_acquire));
  while (kept_.front()->number < oldest) kept_.pop_front();
}

const Assignment& AssignmentBoard::read(std::size_t reader) {
  const Assignment* const latest = latest_.load(std::memory_order_acquire);
  seen_[reader].store(latest->number, std::memory_order_release);
  return *latest;
}

}  // namespace ctn::runtime
