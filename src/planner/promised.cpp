#include "planner/promised.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "dispatch/subchain_trigger.h"
#include "plan/batches.h"
#include "plan/limits.h"
#include "plan/predict.h"
#include "plan/promise.h"
#include "plan/validate.h"
#include "planner/moves.h"
#include "planner/pipelines.h"
#include "planner/scoring.h"

namespace ctn::planner {
namespace {

// A budget is for runs longer than any that was seen: runs that were measured keep to it, all others' promises are for
// the planned percentile anyway.
constexpr double kBudgetMargin = 2.0;

// `batches`: how many items its runs may have.
Millis longest_run(const graph::App& app, const trial::Samples& samples, const std::vector<plan::Batch>& batches,
                   SubchainId id, std::size_t kind) {
  Nanos longest{0};
  for (const NodeId node : app.graph.subchain(id).nodes) {
    Nanos of_node{0};
    for (std::uint32_t number = 0; number < trial::Samples::kDraws; ++number) {
      of_node = std::max(of_node, samples.draw(node, kind, number));
    }
    longest += of_node;
    for (const plan::Batch& batch : batches) {
      if (batch.node == node) longest += samples.of_items(node, kind, static_cast<std::size_t>(batch.items));
    }
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
  if (place.pause || place.after) return member;
  member.phase = to_millis(place.phase);
  member.clock = place.clock;
  return member;
}

// Where runs have such batches; `costs`: of these runs.
std::optional<plan::Plan> plan_with(const std::vector<plan::Batch>& batches, const graph::App& app,
                                    const trial::Samples& samples, const model::CostTable& costs,
                                    const trial::Schedule& schedule, double slack) {
  const std::vector<model::CostTable> by_kind = model::costs_by_kind(app, costs);
  plan::Plan plan;
  plan.batches = batches;
  plan.planner = "auto";
  plan.quality = plan::Quality::kFeasible;
  plan.gap = 1.0;
  plan.slack = slack;
  plan.cores.resize(static_cast<std::size_t>(schedule.cores));
  for (plan::CorePlan& core : plan.cores) core.frames = app.scheduler.frames;
  for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
    if (schedule.subchains[i].form == trial::Form::kFrames) return std::nullopt;
    const SubchainId id(i);
    const trial::Place& place = schedule.subchains[i];
    if (place.form == trial::Form::kPipeline) {
      const auto pipeline = std::find_if(schedule.pipelines.begin(), schedule.pipelines.end(),
                                         [&](const trial::Pipeline& each) { return each.subchain == id; });
      plan.subchains.push_back(planned_pipeline(app, by_kind[app.kind_of(pipeline->cores.front())], *pipeline, slack));
      continue;
    }
    const std::size_t kind = app.kind_of(place.core);
    const Millis cost = by_kind[kind].subchain_total(app.graph, id);
    plan::SubchainPlan& subchain = plan.subchains.emplace_back();
    subchain.cores = {place.core};
    subchain.slice = cost;
    subchain.wait = costs.subchain_wait(app.graph, id);
    if (!plan::takes_batches(app.graph, id)) subchain.every = 1;
    plan::CorePlan& core = plan.cores[static_cast<std::size_t>(place.core)];
    core.form = plan::Form::kPriorities;
    const Millis budget = kBudgetMargin * std::max(cost, longest_run(app, samples, batches, id, kind));
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
    if (schedule.subchains[i].form != trial::Form::kPriority) continue;
    plan.subchains[i].period = (*promises)[i].period;
    plan.subchains[i].execution = (*promises)[i].execution;
  }
  plan::fill_predictions(plan, app, costs);
  return plan;
}

// Of each subchain what a run takes as planned, waits too; by kind, then subchain.
std::vector<std::vector<Millis>> run_times(const graph::App& app, const model::CostTable& costs, double slack) {
  std::vector<std::vector<Millis>> times;
  for (const model::CostTable& table : model::costs_by_kind(app, costs)) {
    std::vector<Millis> of_kind;
    for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
      const SubchainId id(i);
      of_kind.push_back(table.subchain_total(app.graph, id) / (1.0 - slack) + costs.subchain_wait(app.graph, id));
    }
    times.push_back(std::move(of_kind));
  }
  return times;
}

// The most expensive first, core by core, with all that exclusive groups join to it; on each core those of exact rates
// above the others, the highest rate on top.
trial::Schedule one_by_one(const graph::App& app, const std::vector<Millis>& expense, int cores) {
  const std::size_t count = app.graph.subchains().size();
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return expense[a] > expense[b]; });
  trial::Schedule schedule{
      .cores = cores, .subchains = std::vector<trial::Place>(count), .frames = {}, .pipelines = {}};
  const std::vector<std::vector<SubchainId>> joined = app.joined_by_exclusion();
  std::vector<bool> placed(count, false);
  int next = 0;
  for (const std::size_t i : order) {
    if (placed[i]) continue;
    const int core = next++ % cores;
    const auto place = [&](std::size_t one) {
      schedule.subchains[one].core = core;
      placed[one] = true;
    };
    place(i);
    for (const SubchainId other : joined[i]) place(other.index());
  }
  const auto exact = [&](std::size_t i) {
    constexpr Millis kNone{kInfinity};
    return plan::period_limits(app.graph, SubchainId(i)).exact.value_or(kNone);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return exact(a) < exact(b); });
  for (std::size_t rank = 0; rank < count; ++rank) {
    schedule.subchains[order[rank]].priority = static_cast<int>(count - rank);
  }
  return schedule;
}

// Of a subchain without an exact rate that has to be triggered by arrival: after so many outputs that they are a period
// apart.
void set_period(const graph::App& app, SubchainId id, Millis period, trial::Place& place) {
  place.period = to_nanos(plan::period_limits(app.graph, id).exact.value_or(period));
  if (app.graph.node(app.graph.subchain(id).head()).trigger != graph::TriggerBy::kArrival) return;
  const Arrival arrival = arrivals_of(app.graph, id).front();
  place.after = plan::After{arrival.node, static_cast<int>(std::ceil(period / arrival.apart))};
}

// Each subchain in turn, so seldom that each run is over before its next trigger.
std::optional<Promised> slowed(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs,
                               int cores, double slack) {
  const std::vector<std::vector<Millis>> times = run_times(app, costs, slack);
  trial::Schedule schedule = one_by_one(app, times.front(), cores);
  std::vector<Millis> in_turn(static_cast<std::size_t>(cores), to_millis(dispatch::kShortestPeriod));  // by core
  for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
    const int core = schedule.subchains[i].core;
    in_turn[static_cast<std::size_t>(core)] += times[app.kind_of(core)][i];
  }
  // Exact rates take of what is there, and batches grow with periods.
  constexpr double kFirst = 2.0;
  constexpr double kLast = 4096.0;
  const std::vector<plan::UsefulPeriod> useful = plan::useful_periods(app.graph);
  for (double factor = kFirst; factor <= kLast; factor *= 2.0) {
    for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
      trial::Place& place = schedule.subchains[i];
      const Millis period = factor * in_turn[static_cast<std::size_t>(place.core)];
      set_period(app, SubchainId(i), std::max(period, useful[i].min), place);
    }
    std::optional<plan::Plan> plan = plan_of(app, samples, costs, schedule, slack);
    if (plan) return Promised{*std::move(plan), std::move(schedule)};
  }
  return std::nullopt;
}

}  // namespace

std::optional<plan::Plan> plan_of(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs,
                                  const trial::Schedule& schedule, double slack) {
  std::optional<plan::Plan> plan = plan::settle_batches(app, costs, [&](const std::vector<plan::Batch>& batches) {
    return plan_with(batches, app, samples, plan::at_batches(costs, batches, app.graph), schedule, slack);
  });
  if (plan && !plan::validate(*plan, app, costs, schedule.cores)) return std::nullopt;
  return plan;
}

std::optional<Promised> best_promised(const ScheduleSearch& search, const graph::App& app, int cores, double slack,
                                      const std::optional<plan::Plan>& frames) {
  const trial::Samples& samples = search.samples();
  const model::CostTable& costs = search.planned();
  std::optional<Promised> best;
  double best_score = kInfinity;
  for (const Found& found : search.best()) {
    std::optional<plan::Plan> plan =
        found.schedule.frames.empty() ? plan_of(app, samples, costs, found.schedule, slack) : frames;
    if (!plan) continue;
    const double score = relaxed_score(found.score, plan->relax_factor);
    if (score >= best_score) continue;
    best_score = score;
    best = Promised{*std::move(plan), found.schedule};
  }
  return best ? best : slowed(app, samples, costs, cores, slack);
}

}  // namespace ctn::planner
