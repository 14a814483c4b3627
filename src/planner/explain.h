// Why a plan of the least expected objective (expected.h) is as it is: what sets each subchain's period, what each
// bound costs, what one core more or fewer would do, and what a weight twice as large would change. Found by planning
// again with one thing changed, and comparing what is expected, so that every figure is that of a plan which could be
// had.
//
// A search finds one plan one time and a slightly better one the next. So it is let to go on with nothing changed, too;
// what is found with other weights is a plan for these as well. The others are compared with the best of all those, and
// how much it differs from the plan says what is noise.
//
// Units: see plan.h; objectives in ms, as expected. Thread safety: pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"
#include "planner/expected.h"
#include "trial/samples.h"

namespace ctn::planner {

// Subchains that share a core, or one that owns some.
struct CoreGroup {
  std::vector<SubchainId> subchains;  // ascending
  int cores = 1;
  int kind = 0;  // of its cores, among the app's

  friend auto operator<=>(const CoreGroup&, const CoreGroup&) = default;
};

// Which subchains share a core and which own how many of which kind, whatever the cores' numbers: equal for the same
// allocation. `app` is the one that the plan was made for, with the cores that it was made for.
std::vector<CoreGroup> allocation_groups(const plan::Plan& plan, const graph::App& app);

// The first that applies is given, in this order.
enum class Binding {
  kExactRate,    // of `node`
  kRateCap,      // of `node`
  kInput,        // it runs for news, which comes no more often: that of `node`
  kLongestNode,  // it owns several cores: more of them would not help
  kBound,        // without `bounds`, which it is part of, it would be slower
  kLeader,       // triggered by outputs of `leader`
  kCost,         // it has its core, or several, to itself, and uses them: what a run costs
  kCore,         // its core is full: its part of it is what the weights make best
  kChosen,       // its core is not full: more often would not make the objective less
};

struct Reason {
  Binding binding = Binding::kChosen;
  std::optional<NodeId> node;         // whose rate, whose output, or which is the longest
  std::optional<plan::After> leader;  // whose outputs trigger it
  std::vector<std::string> bounds;    // keys, as in plan::RelaxedBound
  Millis period{0};                   // as expected
  Millis cost{0};                     // of the longest node (kLongestNode), else of a run; on average
  std::vector<SubchainId> others;     // that share its core
  double core_part = 0.0;             // what it uses of its cores, of what the slack leaves, on average
  double core_used = 0.0;             // what all together use of them
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
  Millis planned{0};  // as promised
  // What the objective would be less by without it. Below 0 where bounds are relaxed: the others then give way less.
  double cost = 0.0;
  bool binds = false;  // it costs more than noise, or is missed
  Variation without;
};

// The plan where one term's weight is twice as large.
struct DoubledWeight {
  Variation with;
  std::vector<Millis> terms;  // its terms, in the order of the objective
  double objective = 0.0;     // under the weights as they are
  bool allocation_changes = false;
};

// A difference by less than this part of the objective is no difference, even if going on gave less of one.
constexpr double kMinNoise = 0.01;

struct Explanation {
  plan::Plan again;             // the best for the app as it is that was found: what the others are compared with
  double noise = kMinNoise;     // a part of the objective, and of a term
  std::vector<Millis> terms;    // of `again`, in the order of the objective
  std::vector<Reason> reasons;  // by SubchainId
  std::vector<BoundCost> bounds;
  std::vector<Variation> one_more;                  // core, by kind
  std::vector<std::optional<Variation>> one_fewer;  // core, by kind; none: there is no other, or none of that kind
  std::vector<DoubledWeight> doubled;               // in the order of the objective
};

// Each planning again takes this part of the effort that the plan was given.
constexpr double kEffortAgain = 0.15;

// Preconditions: `plan` is what make_expected_plan() made of the other arguments. `request.known` counts for nothing,
// and on_progress is told the part of all that is done.
Explanation explain(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs,
                    const ExpectedRequest& request, const plan::Plan& plan);

}  // namespace ctn::planner
