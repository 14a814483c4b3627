// CPU time that several threads have used since a moment, of threads that may join or end meanwhile. One that has
// ended counts with what it had used when it was read last; one that has joined, from when it was read first: what it
// did before may have been for another.
//
// No allocation once it has seen as many threads as there are. Units: Nanos. Thread safety: none; one owner.
#pragma once

#include <algorithm>
#include <vector>

#include "base/time.h"
#include "os/threads.h"

namespace ctn::runtime {

class CpuTimes {
 public:
  void begin() { threads_.clear(); }

  // `cpu`: what the thread has used since it began.
  void read(os::ThreadId thread, Nanos cpu) {
    const auto known =
        std::find_if(threads_.begin(), threads_.end(), [&](const Used& used) { return used.thread == thread; });
    if (known == threads_.end()) {
      threads_.push_back({thread, cpu, cpu});
    } else {
      known->now = std::max(known->now, cpu);
    }
  }

  // Since begin().
  Nanos used() const {
    Nanos total{0};
    for (const Used& thread : threads_) total += thread.now - thread.before;
    return total;
  }

 private:
  struct Used {
    os::ThreadId thread;
    Nanos before{0};
    Nanos now{0};
  };

  std::vector<Used> threads_;
};

}  // namespace ctn::runtime
