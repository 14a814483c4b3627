// The search for the schedule of the least expected objective: local search over cores, priorities, periods, pauses,
// phases and who triggers whom.
//
// How it goes:
//   1. From several beginnings, thousands of steps by formulas of means (surrogate.h). They say which schedules are
//      worth a trial.
//   2. The best of each beginning is tried (trial/trial.h), and the best of those are improved step by step, each step
//      by a short trial, and by a long one if that looks good. Round by round fewer of them go on.
//   3. Schedules of other forms (frames, several cores for one subchain), and the one in force, are tried beside them.
// Cost draws are the same in all trials, so that two schedules differ by what they do and not by luck.
//
// What is compared (score): the weighted sum of means; more where bounds are not kept as promised, for each part by
// which they would have to be relaxed; more for a tail far from the mean; and a core that is used beyond what the slack
// leaves is worse than anything.
//
// Nothing is proven of the result but its promises, which plan/promise.h computes. The same request gives the same
// answer on every machine.
//
// Units: in the types. Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "graph/app.h"
#include "model/cost.h"
#include "trial/samples.h"
#include "trial/schedule.h"
#include "trial/trial.h"

namespace ctn::planner {

// A schedule that somebody else has found, and by how much bounds are relaxed under it.
struct KnownSchedule {
  trial::Schedule schedule;
  double relax = 1.0;
};

struct SearchRequest {
  int cores = 1;
  double slack = graph::kDefaultSlack;
  std::size_t guesses = 24'000;  // steps by the surrogate, about a microsecond each
  std::size_t trials = 2'000;    // each of some hundred microseconds to some milliseconds; 0: the best guess
  std::uint64_t seed = 1;
  // To be tried as they are; those without frames are improved too. Valid for the app and the cores.
  std::vector<KnownSchedule> known;
};

struct Found {
  trial::Schedule schedule;
  trial::Figures figures;  // of a long trial, with p95
  Nanos horizon{0};        // of that
  double score = 0.0;      // what it would be if all bounds were kept
};

// How far apart means and tails may be before it counts: a mean of many good runs hides the ones that take ten times as
// long, which a robot does not forgive.
constexpr double kTailWeight = 0.05;

// A core may be used for so much more than what the slack leaves before it counts: luck of the draws.
constexpr double kLoadTolerance = 0.005;

// What a bound that has to be relaxed by all of itself adds to the score, as a multiple of the objective.
constexpr double kBoundWeight = 5.0;
inline double relaxed_score(double score, double relax) { return score * (1.0 + kBoundWeight * (relax - 1.0)); }

// `planned`: the percentiles that promises go by. Preconditions: request.cores >= 1, and the app lists as many if it
// lists any; slack in [0, 1); the app has a subchain.
// Few; those that are known are the last of them, in their order.
std::vector<Found> search_schedule(const graph::App& app, const trial::Samples& samples,
                                   const model::CostTable& planned, const SearchRequest& request);

}  // namespace ctn::planner
