// How long it takes from a controller's trigger to the first instruction of a node in another process, and what a run
// costs there and here to report.
//
// Measured: a controller (runtime/controller_thread.h) triggers the node of a process of its own through shared memory,
// and waits for the end of the run; NodePort::begin() and end() of runs that do nothing. Bare: a futex wake between the
// same threads and back, in turn with it; the four clock readings that a report has to hold.
//
// Needs the permission for real-time levels where it triggers; only memory where it reports.
#pragma once

#include <vector>

#include "base/result.h"
#include "bench/bench_context.h"
#include "bench/figure.h"

namespace ctn::tool {

// With the node on the controller's core, and, if there is another, on that.
Result<std::vector<Figure>> measure_trigger(const BenchContext& context);

// In process, and in another one.
Result<std::vector<Figure>> measure_reporting(const BenchContext& context);

}  // namespace ctn::tool
