// What a bound callback throws. It is called in its node's thread, where nobody of the program could catch it: the port
// hands it on to where it would come out without Catan, as of the program's spinner. What becomes of it there the
// framework decides, or who calls the spinner.
//
// Thread safety: call_handing_on() as the call, and what hands on; ThrownExceptions from any thread.
#pragma once

#include <deque>
#include <exception>
#include <mutex>
#include <utility>

namespace catan_ros {

// Makes the call. Where it throws, `hand_on` is called with what is thrown, and the result is `if_thrown`. `hand_on`
// may throw it again: then that is what this does.
template <class Call, class Result, class HandOn>
Result call_handing_on(Call&& call, Result if_thrown, HandOn&& hand_on) {
  try {
    return std::forward<Call>(call)();
  } catch (...) {
    std::forward<HandOn>(hand_on)(std::current_exception());
    return if_thrown;
  }
}

// Exceptions on their way from nodes' threads to one that spins.
class ThrownExceptions {
 public:
  void put(std::exception_ptr thrown) {
    const std::lock_guard lock(mutex_);
    all_.push_back(std::move(thrown));
  }
  // Throws the one that was put first, each once; none: does nothing.
  void throw_first() {
    std::exception_ptr first;
    {
      const std::lock_guard lock(mutex_);
      if (all_.empty()) return;
      first = std::move(all_.front());
      all_.pop_front();
    }
    std::rethrow_exception(std::move(first));
  }
  bool empty() const {
    const std::lock_guard lock(mutex_);
    return all_.empty();
  }
  void clear() {
    std::deque<std::exception_ptr> dropped;  // let go without the mutex
    const std::lock_guard lock(mutex_);
    dropped = std::exchange(all_, {});
  }

 private:
  mutable std::mutex mutex_;
  std::deque<std::exception_ptr> all_;
};

}  // namespace catan_ros
