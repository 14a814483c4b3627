#include "ros1/turns_of_queues.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <thread>
#include <utility>

#include <boost/make_shared.hpp>
#include <boost/ref.hpp>
#include <boost/shared_ptr.hpp>

namespace catan_ros {
namespace {

constexpr std::size_t kMaxQueues = 64;
constexpr std::chrono::milliseconds kLookWhetherStopped{50};

struct Entry {
  const ros::CallbackQueue* queue = nullptr;
  TurnsOfQueue* turns = nullptr;
};

// Written under the mutex, at the end only.
struct Registry {
  std::mutex mutex;
  std::array<Entry, kMaxQueues> entries{};
  std::atomic<std::size_t> count{0};
  std::atomic<bool> any{false};
};

// Never let go: threads may still spin when the program's objects are.
Registry& registry() {
  static Registry& registry = *new Registry;
  return registry;
}

}  // namespace

TurnsOfQueue* find_turns(const ros::CallbackQueue* queue) {
  const Registry& all = registry();
  const std::size_t count = all.count.load(std::memory_order_acquire);
  for (std::size_t index = 0; index < count; ++index) {
    if (all.entries[index].queue == queue) return all.entries[index].turns;
  }
  return nullptr;
}

TurnsOfQueue* turns_of(const ros::CallbackQueue* queue) {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  if (TurnsOfQueue* const known = find_turns(queue)) return known;
  const std::size_t count = all.count.load();
  if (count == kMaxQueues) return nullptr;
  all.entries[count] = {queue, new TurnsOfQueue};
  all.count.store(count + 1, std::memory_order_release);
  all.any.store(true, std::memory_order_release);
  return all.entries[count].turns;
}

TurnsOfQueue* turns_of(ros::CallbackQueueInterface& queue) {
  const auto* const own = dynamic_cast<const ros::CallbackQueue*>(&queue);
  return own != nullptr ? turns_of(own) : nullptr;
}

const std::atomic<bool>& has_turns() { return registry().any; }

NodeletQueues& nodelet_queues() {
  static NodeletQueues& queues = *new NodeletQueues;
  return queues;
}

// What a loop finds in the queue in place of a message. One at a time is enough.
class TurnsOfQueue::WakeUp final : public ros::CallbackInterface {
 public:
  explicit WakeUp(std::atomic<bool>& is_woken) : is_woken_(is_woken) {}
  ~WakeUp() override { is_woken_.store(false); }
  WakeUp(const WakeUp&) = delete;
  WakeUp& operator=(const WakeUp&) = delete;
  CallResult call() override { return Success; }

 private:
  std::atomic<bool>& is_woken_;
};

void TurnsOfQueue::wake_loop(ros::CallbackQueueInterface& queue) {
  if (!has_waiting_loop() || is_woken_.exchange(true)) return;
  queue.addCallback(boost::make_shared<WakeUp>(boost::ref(is_woken_)), reinterpret_cast<std::uint64_t>(this));
}

// What is put into the queue. Called by its spinner, or let go unused.
class LentTurn::Loan {
 public:
  enum class State { kAsked, kGranted, kOver };

  // By the spinner: waits until the node is done.
  void grant() {
    const std::lock_guard lock(mutex_);
    if (state_ != State::kAsked) return;
    state_ = State::kGranted;
    changed_.notify_all();
    while (state_ == State::kGranted) changed_.wait(mutex_);
  }
  // By the node, or where the queue has dropped it.
  void end() {
    const std::lock_guard lock(mutex_);
    state_ = State::kOver;
    changed_.notify_all();
  }
  State wait(std::chrono::nanoseconds timeout) {
    const std::lock_guard lock(mutex_);
    const auto until = std::chrono::steady_clock::now() + timeout;
    while (state_ == State::kAsked && changed_.wait_until(mutex_, until)) {
    }
    return state_;
  }

  class Callback final : public ros::CallbackInterface {
   public:
    explicit Callback(std::shared_ptr<Loan> loan) : loan_(std::move(loan)) {}
    ~Callback() override { loan_->end(); }
    Callback(const Callback&) = delete;
    Callback& operator=(const Callback&) = delete;
    CallResult call() override {
      loan_->grant();
      return Success;
    }

   private:
    std::shared_ptr<Loan> loan_;
  };

 private:
  PriorityMutex mutex_;
  PriorityCondition changed_;
  State state_ = State::kAsked;
};

bool LentTurn::take(const std::atomic<bool>& stop) {
  while (!stop.load()) {
    loan_ = std::make_shared<Loan>();
    queue_.addCallback(boost::make_shared<Loan::Callback>(loan_), reinterpret_cast<std::uint64_t>(this));
    Loan::State state = Loan::State::kAsked;
    while (state == Loan::State::kAsked && !stop.load()) state = loan_->wait(kLookWhetherStopped);
    if (state == Loan::State::kGranted) return true;
    loan_->end();
    // The queue was cleared, or is disabled.
    if (!stop.load()) std::this_thread::sleep_for(kLookWhetherStopped);
  }
  return false;
}

void LentTurn::give_back() { loan_->end(); }

std::unique_ptr<Turn> make_turn(ros::CallbackQueueInterface& queue) {
  if (TurnsOfQueue* const turns = turns_of(queue)) return std::make_unique<QueueTurn>(*turns);
  if (auto turn = nodelet_queues().turn_of(&queue)) return turn;
  return std::make_unique<LentTurn>(queue);
}

}  // namespace catan_ros
