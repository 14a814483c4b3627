// CPU time of a subchain's run, from its trigger on: of all its nodes' threads. The controller that limits the run
// reads it (driver/subchain_pacer.h); what a run cost in the end its nodes report themselves.
//
// Cost: a system call a thread each time (os::CpuClock); no allocation once it has seen as many threads as there are.
// Units: Nanos. Thread safety: none; one owner, a controller's thread.
#pragma once

#include <optional>

#include "os/threads.h"
#include "runtime/cpu_times.h"
#include "runtime/node_link.h"

namespace ctn::runtime {

class RunClock {
 public:
  void begin(const SubchainLinks& subchain) {
    threads_.begin();
    visit(subchain);
  }

  // Since begin(); of threads that join or end meanwhile as CpuTimes says.
  Nanos used(const SubchainLinks& subchain) {
    visit(subchain);
    return threads_.used();
  }

 private:
  void visit(const SubchainLinks& subchain) {
    for (const NodeLink* node : subchain.nodes) {
      node->for_each_clock([&](os::ThreadId thread, os::CpuClock& clock) {
        if (const std::optional<Nanos> cpu = clock.now()) threads_.read(thread, *cpu);
      });
    }
  }

  CpuTimes threads_;
};

}  // namespace ctn::runtime
