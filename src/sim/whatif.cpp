#include "sim/whatif.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/expected.h"
#include "planner/formulas.h"
#include "sim/batch.h"
#include "sim/run_costs.h"
#include "sim/simulation.h"

namespace ctn::sim {
namespace {

constexpr double kMaxRatio = 64.0;
constexpr double kAccuracy = 1.005;

// Of the search: enough to tell plans apart; more is for those who wait for one plan only.
constexpr double kEffort = 0.03;
// For a limit: where it lies is known no better than guesses find the plan that just holds.
constexpr std::size_t kGuesses = 20'000;

double slack_of(const graph::App& app) { return app.scheduler.slack.value_or(graph::kDefaultSlack); }

Result<plan::Plan> plan_for(const graph::App& app, const model::Workload& work, int cores, std::uint64_t seed) {
  return planner::make_expected_plan(app, trial::Samples(app, work, Nanos{0}, seed), work.costs(app.graph),
                                     {.cores = cores, .slack = slack_of(app), .effort = kEffort});
}

// Whether formulas find a plan that keeps all bounds as promised.
bool can_hold(const graph::App& app, const model::Workload& work, int cores) {
  const model::CostTable costs = work.costs(app.graph);
  const planner::FormulaRequest request{
      .cores = cores, .slack = slack_of(app), .guesses = kGuesses, .count_cores = false};
  const auto holds = [](const Result<plan::Plan>& plan) { return plan.ok() && plan->relax_factor <= 1.0; };
  if (holds(planner::make_plan_by_formulas(app, costs, request))) return true;
  return planner::may_have_frames(app) && planner::may_have_priorities(app) &&
         holds(planner::make_guessed_plan(app, trial::Samples(app, work, Nanos{0}, 1), costs, request));
}

Promise promise_of(const plan::Plan& plan) {
  Promise promise{.objective = plan.objective, .relax_factor = plan.relax_factor, .responses_ms = {}};
  for (const plan::ChainPlan& chain : plan.chains) promise.responses_ms.push_back(chain.response.count());
  return promise;
}

Answer answer_one(const graph::App& app, const model::Workload& work, const Hypothesis& asked,
                  const WhatIfOptions& options) {
  Answer answer{.asked = asked, .promised = {}, .simulated = {}, .why_not = {}};
  const graph::App changed = app_under(app, asked);
  const model::Workload changed_work = work_under(app, work, asked);
  if (options.policy->follows_plan()) {
    const Result<plan::Plan> plan = plan_for(changed, changed_work, asked.cores, options.seed);
    if (plan) {
      answer.promised = promise_of(*plan);
    } else {
      answer.why_not = plan.error().message();
      return answer;
    }
  }
  Options simulated;
  simulated.policy = options.policy;
  simulated.reserve = options.reserve;
  simulated.machine.cores = asked.cores;
  simulated.costs = changed_work.costs(changed.graph);
  auto outcome = simulate(changed, std::make_unique<DrawnCosts>(changed, changed_work, options.seed), simulated,
                          to_nanos(Millis{options.seconds * 1000.0}));
  if (outcome) {
    answer.simulated = std::move(*outcome);
  } else {
    answer.why_not = outcome.error().message();
  }
  return answer;
}

// The largest x in [1/64, 64] for which `holds` is true, to one part in 200; none if there is none. Looked for from
// above in steps, since what holds for one value need not hold for all smaller ones: cores may be too fast for a rate
// cap.
template <class Holds>
std::optional<double> largest(const Holds& holds) {
  constexpr double kStep = 1.19;  // a quarter of an octave
  double high = kMaxRatio;
  if (holds(high)) return high;
  double low = high / kStep;
  while (!holds(low)) {
    high = low;
    low /= kStep;
    if (low < 1.0 / kMaxRatio) return std::nullopt;
  }
  while (high / low > kAccuracy) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

bool Answer::simulation_holds() const {
  if (!simulated) return false;
  const auto misses_bound = [](const ChainOutcome& chain) {
    if (!chain.bound_ms) return false;
    return chain.response_ms.count == 0 || chain.over_bound * 100 > chain.response_ms.count;
  };
  return std::none_of(simulated->chains.begin(), simulated->chains.end(), misses_bound) &&
         std::none_of(simulated->nodes.begin(), simulated->nodes.end(),
                      [](const NodeOutcome& node) { return node.too_slow; });
}

bool Answer::holds() const { return simulation_holds() && (!promised || promise_holds()); }

graph::App app_under(const graph::App& app, const Hypothesis& asked) {
  graph::App changed = app;
  if (asked.term) changed.objective.at(*asked.term).weight = asked.weight;
  return changed;
}

model::Workload work_under(const graph::App& app, const model::Workload& work, const Hypothesis& asked) {
  model::Workload changed = work;
  for (std::size_t index = 0; index < app.graph.nodes().size(); ++index) {
    const NodeId id(index);
    const double factor = (asked.node == id ? asked.factor : 1.0) / asked.speed;
    changed.set(id, work[id].times(factor));
  }
  return changed;
}

Result<std::vector<Answer>> answer(const graph::App& app, const model::Workload& work,
                                   const std::vector<Hypothesis>& asked, const WhatIfOptions& options) {
  if (app.core_count()) {
    return Error::caller("the app lists its cores, so what they would be with others cannot be asked",
                         "ask for a copy of the app file without `cores`");
  }
  std::vector<Answer> answers(asked.size());
  Progress progress(options.on_progress);
  for_each_in_parallel(asked.size(), options.threads, [&](std::size_t index) {
    answers[index] = answer_one(app, work, asked[index], options);
    progress.add();
  });
  return answers;
}

const Answer* cheapest(const std::vector<Answer>& answers) {
  const Answer* best = nullptr;
  const auto capacity = [](const Answer& of) {
    return std::pair(static_cast<double>(of.asked.cores) * of.asked.speed, of.asked.cores);
  };
  for (const Answer& each : answers) {
    if (each.holds() && (best == nullptr || capacity(each) < capacity(*best))) best = &each;
  }
  return best;
}

std::optional<double> min_speed(const graph::App& app, const model::Workload& work, int cores) {
  const std::optional<double> slowness = largest([&](double ratio) {
    return can_hold(app, work_under(app, work, {.cores = cores, .speed = 1.0 / ratio}), cores);
  });
  return slowness ? std::optional(1.0 / *slowness) : std::nullopt;
}

std::optional<double> max_factor(const graph::App& app, const model::Workload& work, Hypothesis asked, NodeId node) {
  asked.node = node;
  return largest([&](double factor) {
    asked.factor = factor;
    return can_hold(app_under(app, asked), work_under(app, work, asked), asked.cores);
  });
}

}  // namespace ctn::sim
