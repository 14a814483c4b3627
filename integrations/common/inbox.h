// The calls that the framework has for one bound callback, until its node runs: the place of the callback queue that
// the program asked for.
//
// The framework's threads put calls in; the node's thread waits for them and takes them. A mutex is held no longer than
// it takes to move a pointer, and has priority inheritance. No call is made with it held. Calls are made one at a time.
//
// Who removes a callback may let go of what it uses right afterwards, so remove() waits for a call of it that is under
// way; a callback that removes itself does not wait. Where the framework does not wait, who removes it may have got
// what the call needs to go on; the call goes on then.
//
// Thread safety: all calls from any thread.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <thread>

#include "common/priority_mutex.h"

namespace catan_ros {

// What came of a call.
enum class Outcome {
  kCalled,
  kAgain,    // not now: another thread is in this callback
  kNothing,  // there was nothing to call: the message, or the program's object, is gone
};

class Inbox {
 public:
  using Id = std::uint64_t;  // the framework's, of a subscription, timer or service
  struct Entry {
    Id id = 0;
    std::function<Outcome()> call;
  };

  void put(Entry entry);
  void put_alone(Entry entry);  // in place of all that are there
  enum class UnderWay { kIsWaitedFor, kGoesOn };
  void remove(Id id, UnderWay call = UnderWay::kIsWaitedFor);
  // For a call of any id that is under way in another thread.
  void wait_for_call() const;
  // Makes the first call; it stays there, in front, where that gave kAgain. Not set: there is none.
  std::optional<Outcome> call_first();
  // The same from any thread. Not set: there are not more than `kept`, or another call of this callback is under way.
  std::optional<Outcome> call_first_beyond(std::size_t kept);
  // A call that has no entry here, and may be of any id.
  bool call_without_entry(const std::function<bool()>& call);
  std::deque<Entry> take_all();
  std::size_t size() const;

  // Whether the framework has anything that calls may come from. Where it has not, no time is waited for one.
  void expect_calls(bool expected);
  // Until there is a call; false: there was none in that time, or none is expected now, or it was stopped. Without
  // `patience` for as long as it takes.
  bool wait(std::optional<std::chrono::nanoseconds> patience) const;
  // Until what was put last came at `since` or later, at most for `patience`. Not at all where several entries have
  // lain there at once since the node's last call: the newest may be that one, and whether it is, frameworks that keep
  // no more do not tell.
  void wait_for_newer(std::chrono::steady_clock::time_point since, std::chrono::nanoseconds patience) const;
  void stop();
  const std::atomic<bool>& stopped() const { return stopped_; }

 private:
  struct Call {
    std::optional<Id> id;  // not set: of any
    std::thread::id thread;
  };

  // By the thread that makes the call: it is under way until this is let go.
  class EndOfCall;

  enum class Caller { kNode, kAny };
  std::optional<Outcome> call_front(Caller caller);
  bool is_under_way_elsewhere(std::optional<Id> id) const;

  PriorityMutex calling_;  // held while the first call is made
  mutable PriorityMutex mutex_;
  mutable PriorityCondition changed_;
  std::deque<Entry> entries_;
  std::optional<Call> under_way_;
  std::chrono::steady_clock::time_point last_put_{};
  bool expected_ = true;
  bool several_ = false;  // lay there at once, since call_first()
  std::atomic<bool> stopped_{false};
};

}  // namespace catan_ros
