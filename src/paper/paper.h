// The paper's Catan, as it stands there: two stages on fixed frames. The reference that all else is compared with; what
// the scheduler `catan` does is another planner (planner/), which has its plans in frames from here.
//
//   problem.h            the app in numbers: compute times, equation (1), table 1
//   stage_one.h          stage I (section 5.1): which subchain runs on which cores
//   equal_shares.h       what stage I takes an allocation to come to
//   local_search.h       where it begins, and ends if it is cut short
//   stage_two.h          stage II (section 5.2): the fractions f_i and periods p_i on each shared core
//   relaxation.h         stage II as a geometric program, and what its solution says of whole numbers
//   geometric_program.h  how such a program is solved
//
// What the paper leaves open or has no word for is as docs/app-file.md and docs/decisions/0026 say: slack, queue nodes,
// rate caps and exact rates, cores of several kinds, min_slice.
//
// A plan is called optimal if both stages are proven, each for its own problem: stage I chooses as if shares were
// equal, so that another allocation can be better all the same. Else its gap is that of the stage that is further off.
//
// Pure and deterministic: it reads no clock. `Plan::solve_time` is left 0.
//
// Units: see plan.h. Thread safety: pure functions.
#pragma once

#include <cstddef>

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::paper {

constexpr std::size_t kMaxSubchains = 256;
constexpr int kMaxCores = 1024;

struct Request {
  int cores = 1;                          // of those that the app lists, the first so many
  double slack = graph::kDefaultSlack;    // fraction in [0, 1)
  std::size_t steps = 4'000'000;          // of each stage, below a microsecond each for an app of a few subchains
  const plan::Plan* allocated = nullptr;  // stage II alone, on the cores that each subchain has in this plan
};

// Allocation and shares are the same whatever frames the app asks for; only with fixed ones is the plan the paper's:
// see as_in_the_paper(). Errors (kCaller): no cores, too many, or more than the app lists; slack out of range; no
// subchains or too many; exact rates that cannot be met on the cores that stage I gives.
Result<plan::Plan> make_plan(const graph::App& app, const model::CostTable& costs, const Request& request);

// The app with fixed frames.
graph::App as_in_the_paper(const graph::App& app);

}  // namespace ctn::paper
