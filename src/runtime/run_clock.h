// CPU time of a subchain's run, from its trigger on: of all its nodes' threads. The controller that limits the run
// reads it (driver/subchain_pacer.h); what a run cost in the end its nodes report themselves.
//
// Cost: a system call a thread each time (os::CpuClock); no allocation once it has seen as many threads as there are.
// Units: Nanos. Thread safety: none; one owner, a controller's thread.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "os/threads.h"
#include "runtime/node_link.h"

namespace ctn::runtime {

class RunClock {
 public:
  void begin(const SubchainLinks& subchain) {
    threads_.clear();
    visit(subchain);
  }

  // Since begin(). A thread that has ended counts with what it had used when it was read last, one that has joined from
  // when it was read first.
  Nanos used(const SubchainLinks& subchain) {
    visit(subchain);
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

  void visit(const SubchainLinks& subchain) {
    for (const NodeLink* node : subchain.nodes) {
      node->for_each_clock([&](os::ThreadId thread, os::CpuClock& clock) { read(thread, clock); });
    }
  }

  void read(os::ThreadId thread, os::CpuClock& clock) {
    const std::optional<Nanos> cpu = clock.now();
    if (!cpu) return;  // it has ended
    const auto known =
        std::find_if(threads_.begin(), threads_.end(), [&](const Used& used) { return used.thread == thread; });
    if (known == threads_.end()) {
      threads_.push_back({thread, *cpu, *cpu});
    } else {
      known->now = std::max(known->now, *cpu);
    }
  }

  std::vector<Used> threads_;
};

}  // namespace ctn::runtime
