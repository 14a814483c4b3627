// How long a shared core takes from the end of one node's slice to the other's first instruction, both always busy.
//
// Measured: a core's thread of the runtime (runtime/controller_thread.h) gives two subchains slices of a millisecond;
// their runs never end. Bare: the minimum that does the same, a thread with an absolute timer and two changes of level.
// The two take turns, a quarter of a second each, on the same core.
//
// Real-time threads here end by themselves at a time that is set when they begin. Needs the permission for real-time
// levels.
#pragma once

#include <vector>

#include "base/result.h"
#include "bench/bench_context.h"
#include "bench/figure.h"

namespace ctn::tool {

Result<std::vector<Figure>> measure_hand_over(const BenchContext& context);

}  // namespace ctn::tool
