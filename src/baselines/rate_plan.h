// What the methods that Catan is compared with answer: a period, a core and a fixed priority for every subchain, made
// once and kept. A plain value, as `plan::Plan` is, but of another kind: no frames, no slices, no shares, so
// `plan::validate` has nothing to say of it; `check_rates` has.
//
// What they have in common, and how an app becomes what they know:
// - A task is a subchain. Its nodes run one after the other, on one core, each run as long as the costs say. No
//   subchain has several cores, no node several threads, no two runs of a subchain overlap.
// - A core of which `slack` is left to ordinary threads is one that takes 1 / (1 - slack) times as long.
// - Unscheduled nodes take no time from any task; in a chain they count with their period and cost.
// - A node that emits less often than it runs (`output_period`) keeps its reader waiting for that long.
//
// The figures under `chains` are by the method's own bound on the time from a change in the world to the reaction,
// which is what Catan calls a response time. Under `objective` is their weighted sum; `formula_objective` is what
// Catan's own formulas (model/evaluate.h) say of the same periods and response times of tasks.
//
// Units: Millis; core numbers as in plan.h. Thread safety: plain values, pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/ids.h"
#include "base/result.h"
#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::baselines {

struct TaskPlan {
  int core = 0;
  Millis period{0};    // between two triggers
  Millis response{0};  // from a trigger to the end of the run, at worst
  int priority = 0;    // 1 to the number of subchains, each once; a higher one pre-empts

  friend bool operator==(const TaskPlan&, const TaskPlan&) = default;
};

// A run of `to` that is triggered at R waits for the last run of `from` that was triggered at or before R - delay, and
// uses that one.
struct Precedence {
  SubchainId from;
  SubchainId to;
  Millis delay{0};

  friend bool operator==(const Precedence&, const Precedence&) = default;
};

struct RatePlan {
  std::string planner;     // which method: "davare", "verucchi"
  bool exhaustive = true;  // false: the search was cut short or local, so there may be better ones
  Millis solve_time{0};    // for the caller to fill in
  double slack = 0.0;
  double objective = 0.0;
  double formula_objective = 0.0;
  double relax_factor = 1.0;  // as in plan::Plan
  std::vector<plan::RelaxedBound> relaxed;
  std::vector<TaskPlan> subchains;   // by SubchainId
  std::vector<double> utilisations;  // by core, of what the slack leaves; at most 1
  std::vector<plan::ChainPlan> chains;
  std::vector<plan::NodePlan> nodes;
  Millis hyperperiod{0};                // after which all repeats; 0: tasks are triggered whenever, not together
  std::vector<Precedence> precedences;  // where there is a hyperperiod

  friend bool operator==(const RatePlan&, const RatePlan&) = default;
};

struct RateRequest {
  int cores = 1;
  double slack = graph::kDefaultSlack;
  std::size_t effort = 0;  // how many candidates may be looked at; 0: the method's default
};

// What `request` and the app must be for any of the methods (kCaller): as in make_plan.
Status check_request(const graph::App& app, const RateRequest& request);

// One of the chains under a method's bound.
struct ChainBound {
  Millis response{0};
  Millis latency{0};
};

// Fills in utilisations, chains (with `chains[i]` for the i-th response-time term), nodes, both objectives and bounds
// from `plan.subchains`, and the slack.
void fill_figures(RatePlan& plan, const graph::App& app, const model::CostTable& costs, int cores,
                  const std::vector<ChainBound>& chains);

// Whether it keeps to the app: cores and priorities are as said above, no core has more to do than it can, no period
// is shorter than a max_rate allows, exact rates are met, no run takes longer than its period, what the objective
// weighs adds up, every soft bound holds or is named with the right factor. Says what is wrong.
Status check_rates(const RatePlan& plan, const graph::App& app, const model::CostTable& costs, int cores);

// What a run of each subchain takes on each kind of cores, stretched by the slack; at least kMinCost, so that what
// costs nothing has a rate too. [kind][subchain].
constexpr double kMinCost = 1e-3;  // ms
std::vector<std::vector<double>> stretched_costs(const graph::App& app, const model::CostTable& costs, double slack);

// How long a reader may have to wait for an output of the element, beyond its period. 0: it emits as often as it runs.
Millis output_period(const graph::Graph& graph, const graph::ChainElement& element);

}  // namespace ctn::baselines
