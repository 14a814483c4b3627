#include "common/inbox.h"

#include <mutex>
#include <utility>

namespace catan_ros {

class Inbox::EndOfCall {
 public:
  explicit EndOfCall(Inbox& inbox) : inbox_(inbox) {}
  ~EndOfCall() {
    const std::lock_guard lock(inbox_.mutex_);
    inbox_.under_way_.reset();
    inbox_.changed_.notify_all();
  }
  EndOfCall(const EndOfCall&) = delete;
  EndOfCall& operator=(const EndOfCall&) = delete;

 private:
  Inbox& inbox_;
};

void Inbox::put(Entry entry) {
  const std::lock_guard lock(mutex_);
  several_ = several_ || !entries_.empty();
  entries_.push_back(std::move(entry));
  last_put_ = std::chrono::steady_clock::now();
  changed_.notify_all();
}

void Inbox::put_alone(Entry entry) {
  std::deque<Entry> replaced;  // let go without the mutex
  const std::lock_guard lock(mutex_);
  replaced = std::exchange(entries_, {});
  entries_.push_back(std::move(entry));
  last_put_ = std::chrono::steady_clock::now();
  changed_.notify_all();
}

// What the entries hold is let go without the mutex: that may be the last reference to the program's objects.
void Inbox::remove(Id id, UnderWay call) {
  std::deque<Entry> removed;
  const std::lock_guard lock(mutex_);
  std::deque<Entry> kept;
  for (Entry& entry : entries_) (entry.id == id ? removed : kept).push_back(std::move(entry));
  entries_ = std::move(kept);
  several_ = several_ && !entries_.empty();
  while (call == UnderWay::kIsWaitedFor && is_under_way_elsewhere(id)) changed_.wait(mutex_);
}

void Inbox::wait_for_call() const {
  const std::lock_guard lock(mutex_);
  while (is_under_way_elsewhere(std::nullopt)) changed_.wait(mutex_);
}

// Precondition: the mutex is held. Without an id: of any.
bool Inbox::is_under_way_elsewhere(std::optional<Id> id) const {
  if (!under_way_ || under_way_->thread == std::this_thread::get_id()) return false;
  return !id || under_way_->id.value_or(*id) == *id;
}

std::optional<Outcome> Inbox::call_first() {
  const std::lock_guard lock(calling_);
  return call_front(Caller::kNode);
}

std::optional<Outcome> Inbox::call_first_beyond(std::size_t kept) {
  if (!calling_.try_lock()) return std::nullopt;
  const std::lock_guard lock(calling_, std::adopt_lock);
  return size() > kept ? call_front(Caller::kAny) : std::nullopt;
}

// Precondition: calling_ is held.
std::optional<Outcome> Inbox::call_front(Caller caller) {
  std::optional<Entry> first;
  {
    const std::lock_guard lock(mutex_);
    if (entries_.empty()) return std::nullopt;
    first = std::move(entries_.front());
    entries_.pop_front();
    under_way_ = Call{first->id, std::this_thread::get_id()};
    if (caller == Caller::kNode) several_ = false;
  }
  const EndOfCall end(*this);
  const Outcome outcome = first->call();
  if (outcome == Outcome::kAgain) {
    const std::lock_guard lock(mutex_);
    entries_.push_front(std::move(*first));
  }
  first.reset();
  return outcome;
}

bool Inbox::call_without_entry(const std::function<bool()>& call) {
  {
    const std::lock_guard lock(mutex_);
    under_way_ = Call{std::nullopt, std::this_thread::get_id()};
  }
  const EndOfCall end(*this);
  return call();
}

std::deque<Inbox::Entry> Inbox::take_all() {
  const std::lock_guard lock(mutex_);
  several_ = false;
  return std::exchange(entries_, {});
}

std::size_t Inbox::size() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

void Inbox::expect_calls(bool expected) {
  const std::lock_guard lock(mutex_);
  expected_ = expected;
  changed_.notify_all();
}

bool Inbox::wait(std::optional<std::chrono::nanoseconds> patience) const {
  const std::lock_guard lock(mutex_);
  const auto until = std::chrono::steady_clock::now() + patience.value_or(std::chrono::nanoseconds{0});
  while (entries_.empty() && !stopped_.load()) {
    if (!patience) {
      changed_.wait(mutex_);
    } else if (!expected_ || (!changed_.wait_until(mutex_, until) && entries_.empty())) {
      return false;
    }
  }
  return !stopped_.load();
}

void Inbox::wait_for_newer(std::chrono::steady_clock::time_point since, std::chrono::nanoseconds patience) const {
  const std::lock_guard lock(mutex_);
  const auto until = std::chrono::steady_clock::now() + patience;
  if (several_) return;
  while (last_put_ < since && !stopped_.load()) {
    if (!changed_.wait_until(mutex_, until)) return;
  }
}

void Inbox::stop() {
  const std::lock_guard lock(mutex_);
  stopped_.store(true);
  changed_.notify_all();
}

}  // namespace catan_ros
