// From an app, what its nodes cost, and a number of cores, to a plan: what all of it is about. Pure and deterministic:
// values in, plan out. It reads no clock: how long it may search is given as an effort, which is the same on every
// machine; `Plan::solve_time` is left 0, for the caller to fill in.
//
// How it goes about it:
//   expected.h         the plan of the least expected objective: what sessions and `catan plan` have
//   formulas.h         a plan in some milliseconds, by formulas of means alone
//   frames.h           the plan in frames that is tried beside what the search finds
//   schedule_search.h  the search, by formulas of means (surrogate.h) and trials (trial/trial.h)
//   moves.h            its steps
//   scoring.h          what a trial says of a schedule, and by what schedules are compared
//   pipelines.h        several cores for one subchain
//   explain.h          why a plan is as it is, by planning again
//
// What it makes satisfies `plan::validate`.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include <cstddef>

#include "base/result.h"
#include "graph/app.h"

namespace ctn::planner {

// As many as Linux can name in an affinity mask of default size.
constexpr int kMaxCores = 1024;
constexpr std::size_t kMaxSubchains = 256;

// Whether an app can be planned for at all. Errors (kCaller): no cores, too many, or more than the app lists; slack out
// of range; no subchains, or more than this plans for.
Status check_request(const graph::App& app, int cores, double slack);

// The same app with so many cores more (or fewer) of a kind than the first `cores` of those that it lists; the app
// itself where it lists none. What it is made for is planning with cores that are not there.
graph::App with_more_cores(const graph::App& app, int cores, std::size_t kind, int more);
// The index of the kind of the fastest cores; 0 where all are alike.
std::size_t fastest_kind(const graph::App& app);

}  // namespace ctn::planner
