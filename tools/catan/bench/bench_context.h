// What all measurements of `catan bench` are given, and how they put a thread where it is to be.
//
// Thread safety: plain values; functions from any thread.
#pragma once

#include <optional>

#include "base/result.h"
#include "os/os.h"

namespace ctn::tool {

struct BenchContext {
  os::Os& os;
  int core = 0;                   // where everything shares one
  std::optional<int> other_core;  // another, if there is one
  double seconds = 20.0;          // for all figures; each takes its part
};

// Puts the calling thread on `cpu` at `level`. Threads that call it end with the measurement, and their scheduling with
// them.
inline Status place_this_thread(os::Os& os, os::Level level, int cpu) {
  const os::ThreadId thread = os.current_thread();
  if (Status placed = os.set_affinity(thread, os::CpuSet{cpu}); !placed) return placed;
  return os.set_level(thread, level);
}

inline Nanos part_of(const BenchContext& context, double part) {
  return to_nanos(Millis{1000.0 * context.seconds * part});
}

}  // namespace ctn::tool
