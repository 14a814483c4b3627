#include "common/nodelet_queues.h"

namespace catan_ros {

// What the queue at that address needs when a run begins.
class NodeletQueues::DirectTurn final : public Turn {
 public:
  explicit DirectTurn(Queue& queue) : queue_(queue) {}
  bool take(const std::atomic<bool>& stop) override {
    holds_ = queue_.calls.load() != Calls::kSideBySide;
    return !holds_ || queue_.turns.take(stop);
  }
  void give_back() override {
    if (holds_) queue_.turns.give_back();
  }

 private:
  Queue& queue_;
  bool holds_ = false;
};

NodeletQueues::~NodeletQueues() {
  for (std::size_t index = 0; index < count_.load(); ++index) delete queues_[index].load();
}

NodeletQueues::Queue* NodeletQueues::find(const void* queue) const {
  const std::size_t count = count_.load(std::memory_order_acquire);
  for (std::size_t index = 0; index < count; ++index) {
    Queue* const one = queues_[index].load(std::memory_order_relaxed);
    if (one->address == queue) return one;
  }
  return nullptr;
}

// Precondition: the mutex is held. Null: there are too many.
NodeletQueues::Queue* NodeletQueues::find_or_add(const void* queue) {
  if (Queue* const known = find(queue)) return known;
  const std::size_t count = count_.load();
  if (count == kMaxQueues) return nullptr;
  Queue* const added = std::make_unique<Queue>(queue).release();
  queues_[count].store(added, std::memory_order_relaxed);
  count_.store(count + 1, std::memory_order_release);
  return added;
}

void NodeletQueues::add(const void* queue, bool one_at_a_time) {
  const std::lock_guard lock(mutex_);
  Queue* const one = find_or_add(queue);
  if (one == nullptr) return;
  one->nodelet.clear();
  one->calls.store(one_at_a_time ? Calls::kOneAtATime : Calls::kSideBySide);
}

void NodeletQueues::remove(const void* queue) {
  const std::lock_guard lock(mutex_);
  Queue* const one = find(queue);
  if (one == nullptr) return;
  one->nodelet.clear();
  one->calls.store(Calls::kGone);
}

void NodeletQueues::set_nodelet(const void* queue, const std::string& nodelet) {
  const std::lock_guard lock(mutex_);
  if (Queue* const one = find_or_add(queue)) one->nodelet = nodelet;
}

std::string NodeletQueues::nodelet_of(const void* queue) const {
  const std::lock_guard lock(mutex_);
  const Queue* const one = find(queue);
  return one != nullptr ? one->nodelet : std::string();
}

bool NodeletQueues::calls_one_at_a_time(const void* queue) const {
  const Queue* const one = find(queue);
  return one != nullptr && one->calls.load() == Calls::kOneAtATime;
}

void* NodeletQueues::call(const void* queue) {
  Queue* const one = find(queue);
  const bool needs_turn = one != nullptr && one->calls.load() == Calls::kOneAtATime;
  return needs_turn && one->turns.begin() ? &one->turns : nullptr;
}

void NodeletQueues::called(void* taken) {
  if (taken != nullptr) static_cast<Turns*>(taken)->end(true);
}

std::unique_ptr<Turn> NodeletQueues::turn_of(const void* queue) {
  Queue* const one = find(queue);
  const Calls calls = one != nullptr ? one->calls.load() : Calls::kUnknown;
  const bool known = calls == Calls::kOneAtATime || calls == Calls::kSideBySide;
  return known ? std::make_unique<DirectTurn>(*one) : nullptr;
}

}  // namespace catan_ros
