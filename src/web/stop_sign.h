// Tells all threads of a server that it stops.
//
// Thread safety: any thread at any time.
#pragma once

#include <atomic>
#include <cstdint>

#include "base/time.h"
#include "os/threads.h"

namespace ctn::web {

class StopSign {
 public:
  explicit StopSign(os::Threads& threads) : threads_(threads) {}

  void give() {
    given_.store(1);
    threads_.wake(given_);
  }
  bool given() const { return given_.load() != 0; }
  // Until it is given, or until then.
  void wait(TimePoint deadline) const { threads_.wait(given_, 0, deadline); }

 private:
  os::Threads& threads_;
  std::atomic<std::uint32_t> given_{0};
};

}  // namespace ctn::web
