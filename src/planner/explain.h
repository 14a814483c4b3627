// Why a plan is as it is: what binds each subchain's period, what each bound costs, what one core more or fewer would
// do, how far behind the next best allocation is, and what a weight twice as large would change. Found by planning
// again with one thing changed, so that every figure is that of a plan which could be had.
//
// A plan that is not proven optimal is compared with plans that may not be either: differences below its gap say
// nothing.
//
// Units: see plan.h; objectives in ms. Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"
#include "planner/planner.h"

namespace ctn::planner {

// Subchains that share a core, or one that owns some.
struct CoreGroup {
  std::vector<SubchainId> subchains;  // ascending
  int cores = 1;
  int kind = 0;  // of its cores, among the app's

  friend auto operator<=>(const CoreGroup&, const CoreGroup&) = default;
};

// Who shares with whom and who owns how many of which kind, whatever the cores' numbers: equal for the same allocation.
// `app` is the one that the plan was made for, with the cores that it was made for.
std::vector<CoreGroup> allocation_groups(const plan::Plan& plan, const graph::App& app);

// The first that applies is given, in this order.
enum class Binding {
  kNothing,      // it costs nothing and has no period
  kExactRate,    // of `node`
  kRateCap,      // of `node`
  kLongestNode,  // it owns its cores: more of them would not help
  kCost,         // it owns its cores: more of them could help
  kOtherRate,    // the frame waits for the cap or the exact rate of `through`
  kMinSlice,     // with a smaller slice of its own, the objective would be less
  kBound,        // `bounds` hold it to this rate at the expense of others
  kOtherBound,   // `bounds` hold `through`, on the same core, to its rate at its expense
  kCore,         // its part of the core that it shares: what the weights make best
};

struct Reason {
  Binding binding = Binding::kCore;
  std::optional<NodeId> node;         // whose rate, or which is the longest
  std::optional<SubchainId> through;  // which other subchain; of several bounds, by the first
  std::vector<std::string> bounds;    // keys, as in plan::RelaxedBound
  Millis cost{0};                     // of the longest node (kLongestNode), else of a run, with the planned threads
  std::vector<SubchainId> others;     // that share its core
  double core_part = 0.0;             // what it uses of its cores, of what the slack leaves
};

// What planning again with one thing changed gave.
struct Variation {
  std::optional<plan::Plan> plan;
  std::string refusal;  // why there is no plan
};

// A bound that may be relaxed, and the plan without it.
struct BoundCost {
  std::string key;
  Millis asked{0};
  Millis planned{0};
  bool met = false;    // just as asked, scaled by the plan's relax factor
  bool binds = false;  // met, missed, or there is a better plan without it
  // What the objective would be less by without it. Below 0 where bounds are relaxed: the others then give way less.
  double cost = 0.0;
  Variation without;
};

// The best plan among other allocations.
struct RunnerUp {
  std::optional<plan::Plan> plan;  // none: no other allocation can be had
  bool proven = false;             // all allocations were looked at to the end; else those near the plan's
  std::size_t allocations = 0;     // how many were looked at
};

// The plan where one term's weight is twice as large.
struct DoubledWeight {
  Variation with;
  std::vector<Millis> terms;  // its terms, in the order of the objective
  double objective = 0.0;     // under the weights as they are
  bool allocation_changes = false;
};

struct Explanation {
  double objective = 0.0;
  std::vector<Millis> terms;    // in the order of the objective, as planned
  std::vector<Reason> reasons;  // by SubchainId
  std::vector<BoundCost> bounds;
  std::vector<Variation> one_more;                  // core, by kind
  std::vector<std::optional<Variation>> one_fewer;  // core, by kind; none: there is no other, or none of that kind
  RunnerUp runner_up;
  std::vector<DoubledWeight> doubled;  // in the order of the objective
};

// Preconditions: `plan` is what `make_plan` made of the other arguments; `request.warm` counts for nothing.
Explanation explain(const graph::App& app, const model::CostTable& costs, const Request& request,
                    const plan::Plan& plan);

}  // namespace ctn::planner
