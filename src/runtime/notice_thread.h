// Delivers notices (driver/notices.h) to the user's callback, in a thread of its own at the ordinary level, which
// sleeps while there are none. A callback that blocks keeps only later notices waiting: nothing else waits for it but
// stop(). The callback is that thread's alone, so it cannot be called under a lock. Without one there is no thread.
//
// Thread safety: notices() and is_current() from any thread; start() and stop() from the owner.
#pragma once

#include <utility>

#include "driver/notices.h"
#include "os/threads.h"
#include "runtime/owning_thread.h"

namespace ctn::runtime {

class NoticeThread {
 public:
  // `on_notice` may be empty. `threads` outlives it. `recorded`: see Notices.
  NoticeThread(os::Threads& threads, driver::Notices::Callback on_notice, bool recorded)
      : notices_(on_notice ? [this] { thread_.wake(); } : std::function<void()>(), recorded),
        thread_(threads, std::move(on_notice)) {}

  driver::Notices& notices() { return notices_; }

  // From now on notices are delivered, with all that were added before. Precondition: it was not started before.
  void start() {
    if (!thread_.idle()) return;
    thread_.start("catan-notices", [this](const driver::Notices::Callback& on_notice) {
      do {
        notices_.deliver(on_notice);
      } while (thread_.sleep_until(kNever));
      notices_.deliver(on_notice);  // what was added before the end was asked for
    });
  }
  // Returns when all that were added before have been delivered. May be called again.
  void stop() {
    thread_.request_stop();
    thread_.join();
  }
  bool is_current() const { return thread_.is_current(); }

 private:
  driver::Notices notices_;
  OwningThread<driver::Notices::Callback> thread_;
};

}  // namespace ctn::runtime
