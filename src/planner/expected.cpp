#include "planner/expected.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "plan/limits.h"
#include "plan/predict.h"
#include "plan/promise.h"
#include "plan/validate.h"
#include "planner/planner.h"
#include "trial/schedule.h"
#include "trial/trial.h"

namespace ctn::planner {
namespace {

// A budget is for what nobody has seen: runs that were measured keep to it, all others' promises are for the planned
// percentile anyway.
constexpr double kBudgetMargin = 1.2;
// Steps at effort 1.
constexpr double kGuesses = 24'000;
constexpr double kTrials = 2'000;

Millis longest_run(const graph::App& app, const trial::Samples& samples, SubchainId id, std::size_t kind) {
  Nanos longest{0};
  for (const NodeId node : app.graph.subchain(id).nodes) {
    Nanos of_node{0};
    for (std::uint32_t number = 0; number < trial::Samples::kDraws; ++number) {
      of_node = std::max(of_node, samples.draw(node, kind, number));
    }
    longest += of_node;
  }
  return to_millis(longest);
}

// A schedule has whole nanoseconds; caps and exact rates have more digits.
plan::Member member_of(const graph::App& app, const trial::Place& place, SubchainId id, Millis budget) {
  plan::Member member;
  member.subchain = id;
  member.priority = place.priority;
  member.budget = budget;
  member.after = place.after;
  const plan::PeriodLimits limits = plan::period_limits(app.graph, id);
  member.period = limits.exact.value_or(std::max(to_millis(place.period), limits.min));
  if (place.pause) member.pause = to_millis(*place.pause);
  if (!place.pause && !place.after) member.phase = to_millis(place.phase);
  return member;
}

// What a trial measured, beside what it promises. A response time is a latency and a period on average, too.
plan::Expectation expectation_of(const plan::Plan& plan, const Found& found) {
  plan::Expectation expected;
  expected.objective = found.figures.objective;
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const plan::SubchainPlan& promised = plan.subchains[i];
    const double period = found.figures.subchains[i].period_ms;
    expected.subchains.push_back(
        {period > 0.0 ? std::min(Millis{period}, promised.period) : promised.period, promised.execution});
  }
  return expected;
}

void expect_chains(plan::Expectation& expected, const graph::App& app, const Found& found) {
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    if (app.objective[term].metric != graph::Metric::kResponseTime) continue;
    const trial::TermFigures& figures = found.figures.terms[term];
    const Millis response{figures.mean_ms};
    const Millis period = figures.count > 0
                              ? std::min(to_millis(found.horizon) / static_cast<double>(figures.count), response)
                              : response;
    expected.chains.push_back({response, response - period, period});
  }
}

}  // namespace

std::optional<plan::Plan> plan_of(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs,
                                  const Found& found, double slack) {
  const std::vector<model::CostTable> by_kind = model::costs_by_kind(app, costs);
  plan::Plan plan;
  plan.planner = "auto";
  plan.quality = plan::Quality::kFeasible;
  plan.gap = 1.0;
  plan.slack = slack;
  plan.cores.resize(static_cast<std::size_t>(found.schedule.cores));
  for (std::size_t i = 0; i < found.schedule.subchains.size(); ++i) {
    if (found.schedule.subchains[i].form != trial::Form::kPriority) return std::nullopt;
    const SubchainId id(i);
    const trial::Place& place = found.schedule.subchains[i];
    const std::size_t kind = app.kind_of(place.core);
    const Millis cost = by_kind[kind].subchain_total(app.graph, id);
    plan::SubchainPlan& subchain = plan.subchains.emplace_back();
    subchain.cores = {place.core};
    subchain.slice = cost;
    if (!plan::takes_batches(app.graph, id)) subchain.every = 1;
    plan::CorePlan& core = plan.cores[static_cast<std::size_t>(place.core)];
    core.form = plan::Form::kPriorities;
    const Millis budget = kBudgetMargin * std::max(cost, longest_run(app, samples, id, kind));
    core.members.push_back(member_of(app, place, id, budget));
  }
  for (plan::CorePlan& core : plan.cores) {
    std::sort(core.members.begin(), core.members.end(),
              [](const plan::Member& a, const plan::Member& b) { return a.priority > b.priority; });
    int priority = static_cast<int>(core.members.size());
    for (plan::Member& member : core.members) member.priority = priority--;
  }
  const std::optional<std::vector<plan::Promise>> promises = plan::promise(plan, app, costs);
  if (!promises) return std::nullopt;
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    plan.subchains[i].period = (*promises)[i].period;
    plan.subchains[i].execution = (*promises)[i].execution;
  }
  plan::fill_predictions(plan, app, costs);
  plan.expected = expectation_of(plan, found);
  expect_chains(*plan.expected, app, found);
  return plan;
}

Result<plan::Plan> make_expected_plan(const graph::App& app, const trial::Samples& samples,
                                      const model::CostTable& costs, const ExpectedRequest& request) {
  Result<plan::Plan> formulas = make_plan(app, costs, {.cores = request.cores, .slack = request.slack});
  if (!formulas) return formulas;
  SearchRequest search;
  search.cores = request.cores;
  search.slack = request.slack;
  search.seed = request.seed;
  search.guesses = static_cast<std::size_t>(kGuesses * request.effort);
  search.trials = static_cast<std::size_t>(kTrials * request.effort);
  search.known.push_back({trial::schedule_of(app, *formulas), formulas->relax_factor});
  const std::vector<Found> found = search_schedule(app, samples, costs, search);
  // The search goes by a guess of what is promised; here it is known.
  plan::Plan best = std::move(*formulas);
  double best_score = relaxed_score(found.back().score, best.relax_factor);
  for (std::size_t i = 0; i + 1 < found.size(); ++i) {
    std::optional<plan::Plan> plan = plan_of(app, samples, costs, found[i], request.slack);
    if (!plan || !plan::validate(*plan, app, costs, request.cores)) continue;
    const double score = relaxed_score(found[i].score, plan->relax_factor);
    if (score >= best_score) continue;
    best_score = score;
    best = std::move(*plan);
  }
  best.planner = "auto";
  return best;
}

}  // namespace ctn::planner
