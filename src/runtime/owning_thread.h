// A thread, and the state that it has for itself: while it runs, only its body is given the state, so no other thread
// can reach it. Before start() and after join() the state belongs to the owner of this object.
//
//   OwningThread<Count> count(os, 1);
//   count.idle().begin();
//   count.start("count", [&](Count& mine) { while (count.sleep_until(mine.due())) mine.add(); });
//   count.request_stop();
//   count.join();
//   show(count.idle());
//
// Thread safety: stopping(), wake(), request_stop() and is_current() from any thread; sleep_until() from the thread;
// the rest from the owner.
#pragma once

#include <atomic>
#include <cassert>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "os/threads.h"

namespace ctn::runtime {

template <class State>
class OwningThread {
 public:
  // `threads` outlives it. The state is made of `arguments`.
  template <class... Arguments>
  explicit OwningThread(os::Threads& threads, Arguments&&... arguments)
      : threads_(threads), state_(std::forward<Arguments>(arguments)...) {}
  ~OwningThread() {
    request_stop();
    join();
  }
  OwningThread(const OwningThread&) = delete;
  OwningThread& operator=(const OwningThread&) = delete;

  // Precondition: the thread does not run.
  State& idle() {
    assert(!thread_);
    return state_;
  }

  // Wakes before are forgotten. Precondition: it has not been started or stopped before.
  void start(const std::string& name, std::function<void(State&)> body) {
    assert(!thread_ && !stopping());
    seen_ = wakes_.load(std::memory_order_acquire);
    thread_ = threads_.spawn(name, [this, body = std::move(body)] {
      id_.store(static_cast<std::int32_t>(threads_.current_thread()));
      body(state_);
      id_.store(0);
    });
  }
  bool is_current() const { return threads_.current_thread() == os::ThreadId{id_.load()}; }

  // Until then, or until it is woken, at once if it was since it slept last; false: it is to end.
  bool sleep_until(TimePoint deadline) {
    const std::uint32_t seen = wakes_.load(std::memory_order_acquire);
    if (!stopping() && seen == seen_) threads_.wait(wakes_, seen, deadline);
    seen_ = wakes_.load(std::memory_order_acquire);
    return !stopping();
  }
  void wake() {
    wakes_.fetch_add(1, std::memory_order_release);
    threads_.wake(wakes_);
  }

  bool stopping() const { return stopping_.load(std::memory_order_acquire); }
  void request_stop() {
    stopping_.store(true, std::memory_order_release);
    wake();
  }
  // Waits for its end. Nothing where it does not run.
  void join() {
    if (thread_) thread_->join();
    thread_.reset();
  }

 private:
  os::Threads& threads_;
  State state_;
  std::atomic<std::int32_t> id_{0};
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint32_t> wakes_{0};
  std::uint32_t seen_ = 0;  // the thread's
  std::unique_ptr<os::Thread> thread_;
};

}  // namespace ctn::runtime
