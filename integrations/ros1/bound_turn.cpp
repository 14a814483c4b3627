// Of a bound node: the turn of the queue that its program asked for, which may be another one from run to run.
#include <mutex>
#include <utility>

#include "ros1/bound_node.h"

namespace catan_ros {

void BoundNode::CurrentTurn::set(std::unique_ptr<Turn> turn) {
  const std::lock_guard lock(mutex_);
  next_ = std::move(turn);
}

bool BoundNode::CurrentTurn::is_current() const {
  const std::lock_guard lock(mutex_);
  return held_ == nullptr || held_ == next_;
}

// While it waits, another queue may take the place of the one whose turn that is.
bool BoundNode::CurrentTurn::take(const std::atomic<bool>& stop) {
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      held_ = next_;
    }
    if (!held_->take(stop)) break;
    if (is_current()) return true;
    give_back();
  }
  const std::lock_guard lock(mutex_);
  held_ = nullptr;
  return false;
}

void BoundNode::CurrentTurn::give_back() {
  held_->give_back();
  const std::lock_guard lock(mutex_);
  held_ = nullptr;
}

}  // namespace catan_ros
