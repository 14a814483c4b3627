// From an app, what its nodes cost, and a number of cores, to a plan. Pure and deterministic: values in, plan out. It
// reads no clock: how long it may search is given as a number of steps, which is the same on every machine;
// `Plan::solve_time` is left 0, for the caller to fill in.
//
// How it goes about it:
//   instance.h     the app reduced to numbers: periods, execution times, maxima of linear forms
//   allocation.h   who owns cores and who shares which: jointly with the shares, or before them
//   shares.h       stage II, the shares of an allocation: branch and bound with a Lagrangian bound
//   shared_core.h  one core under a linear objective, exactly: what the bound is made of
//   frame_fit.h    free shares where all whole numbers are decided: an interior-point method
//   owned.h        an app of one subchain
//   explain.h      why a plan is as it is, by planning again (reasons.h, runner_up.h)
//
// First without bounds: where all of them hold, that plan is the best. Else the least factor is sought by which all
// bounds must be scaled to hold, and then the best plan under the bounds so scaled. What it makes satisfies
// `plan::validate`.
//
// Subchains that no term of the objective weighs are not put off without end: no frame is longer than 100 times one run
// of everything on its core, unless a rate cap asks for it. A run that costs nothing has a share of 1 where its share
// is free.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <optional>

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::planner {

// As many as Linux can name in an affinity mask of default size.
constexpr int kMaxCores = 1024;
// As many as a set of them holds (set.h).
constexpr std::size_t kMostSubchains = 256;

// How cores are divided among subchains: as one problem with the shares, or before them as if shares were equal.
enum class Method { kJoint, kTwoStage };

struct Request {
  int cores = 1;                        // 1 to kMaxCores; of those that the app lists, the first so many
  double slack = graph::kDefaultSlack;  // fraction in [0, 1)
  Method method = Method::kJoint;
  std::size_t effort = 300'000;  // steps of each search, a few microseconds each; then the best so far, with its gap
  // A plan to begin with, of the same app; what it says of cores is all that counts. Of more than 64 subchains, the
  // search then ends as soon as it gains little, and proves less.
  const plan::Plan* warm = nullptr;
  // Whether an error says how many cores would do, for which it plans again and again.
  bool count_cores = true;
};

// The same app with so many cores more (or fewer) of a kind than the first `cores` of those that it lists; the app
// itself where it lists none. What it is made for is planning with cores that are not there.
graph::App with_more_cores(const graph::App& app, int cores, std::size_t kind, int more);
// The index of the kind of the fastest cores; 0 where all are alike.
std::size_t fastest_kind(const graph::App& app);

// Errors (kCaller): no cores, too many, or more than the app lists; slack out of range; more subchains than this plans
// for; exact rates and caps that cannot be met, with how much is missing.
Result<plan::Plan> make_plan(const graph::App& app, const model::CostTable& costs, const Request& request);

// The same for one who has a plan already: the best plan that meets all bounds, if its objective is below `limit`; none
// if there is no such plan, or none was found. Far quicker where there is none, because a bound on all plans soon says
// so. Errors: as of make_plan, save that exact rates and caps which cannot be met give none.
Result<std::optional<plan::Plan>> make_plan_below(const graph::App& app, const model::CostTable& costs,
                                                  const Request& request, double limit);

}  // namespace ctn::planner
