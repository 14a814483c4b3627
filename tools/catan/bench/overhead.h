// What scheduling itself costs: the CPU time of all threads that belong to Catan while the navigation case study runs
// on one core, its nodes burning CPU time as their load says.
//
// A figure for all of them and one for each kind of thread, in percent of a core, sampled every half second. Planning
// has a figure of its own, and is in no other: what it may use is said of a minute (policy/planning_budget.h).
// Needs the permission for real-time levels.
#pragma once

#include <vector>

#include "base/result.h"
#include "bench/bench_context.h"
#include "bench/figure.h"

namespace ctn::tool {

// Nodes and scheduler in one process.
Result<std::vector<Figure>> measure_overhead_in_process(const BenchContext& context);
// A server, and the nodes in another process.
Result<std::vector<Figure>> measure_overhead_served(const BenchContext& context);

}  // namespace ctn::tool
