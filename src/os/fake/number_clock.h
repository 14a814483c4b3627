// The CPU clock of a thread that is found by its number each time, for systems where that costs nothing.
//
// Units: Nanos. Thread safety: as os.h.
#pragma once

#include <memory>
#include <optional>

#include "os/threads.h"

namespace ctn::os {

class NumberClock : public CpuClock {
 public:
  // `threads` outlives it. kEnvironment: the thread is gone.
  static Result<std::unique_ptr<CpuClock>> make(Threads& threads, ThreadId thread) {
    if (const Result<Nanos> used = threads.thread_cpu_time(thread); !used) return used.error();
    return std::unique_ptr<CpuClock>(new NumberClock(threads, thread));
  }

  std::optional<Nanos> now() override {
    const Result<Nanos> used = threads_.thread_cpu_time(thread_);
    return used ? std::optional(*used) : std::nullopt;
  }

 private:
  NumberClock(Threads& threads, ThreadId thread) : threads_(threads), thread_(thread) {}

  Threads& threads_;
  ThreadId thread_;
};

}  // namespace ctn::os
