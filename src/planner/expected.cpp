#include "planner/expected.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>
#include <vector>

#include "plan/batches.h"
#include "plan/limits.h"
#include "plan/predict.h"
#include "plan/promise.h"
#include "plan/validate.h"
#include "planner/formulas.h"
#include "planner/frames.h"
#include "planner/pipelines.h"
#include "planner/planner.h"
#include "trial/schedule.h"
#include "trial/trial.h"

namespace ctn::planner {
namespace {

// A budget is for what nobody has seen: runs that were measured keep to it, all others' promises are for the planned
// percentile anyway.
constexpr double kBudgetMargin = 2.0;
// Steps at effort 1.
constexpr double kGuesses = 24'000;
constexpr std::chrono::duration<double> kWork{5.0};

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

// As many steps as in one go, with word of them on the way.
void look_for_priorities(ScheduleSearch& search, const graph::App& app, const ExpectedRequest& request) {
  const bool frames = request.known && std::any_of(request.known->cores.begin(), request.known->cores.end(),
                                                   [](const plan::CorePlan& core) { return !core.slots.empty(); });
  if (request.known && !frames) {
    trial::Schedule schedule = trial::schedule_of(app, *request.known);
    schedule.cores = request.cores;
    search.add(std::move(schedule), std::nullopt);
  }
  search.guess(static_cast<std::size_t>(kGuesses * request.effort));
  const Nanos all = std::chrono::duration_cast<Nanos>(kWork * request.effort);
  const Nanos begin = search.work();
  constexpr Nanos kWord = std::chrono::milliseconds{100};
  for (Nanos done{0}; done < all; done = search.work() - begin) {
    search.improve(std::min(kWord, all - done));
    if (request.on_progress) {
      request.on_progress(std::min(1.0, to_millis(search.work() - begin) / to_millis(all)));
    }
  }
}

plan::Plan with_expectation(ScheduleSearch& search, const graph::App& app, plan::Plan plan,
                            const trial::Schedule& schedule) {
  plan.expected = expectation_of(app, plan, schedule, search.expected(schedule));
  return plan;
}

// Whoever asks offline has an app that tells its ticks.
std::vector<NodeId> clocks_of(const graph::Graph& graph) {
  std::vector<NodeId> clocks;
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    if (graph.nodes()[index].has_clock()) clocks.emplace_back(index);
  }
  return clocks;
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

}  // namespace

std::optional<plan::Plan> plan_of(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs,
                                  const trial::Schedule& schedule, double slack) {
  return plan::settle_batches(app, costs, [&](const std::vector<plan::Batch>& batches) {
    return plan_with(batches, app, samples, plan::at_batches(costs, batches, app.graph), schedule, slack);
  });
}

// A response time is a latency and a period on average, too. Of a pipeline it is what its pacing was made from, so that
// it is paced as it was tried.
plan::Expectation expectation_of(const graph::App& app, const plan::Plan& plan, const trial::Schedule& schedule,
                                 const Expected& expected) {
  const trial::Figures& figures = expected.figures;
  plan::Expectation expectation{.objective = figures.objective, .subchains = {}, .chains = {}};
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const plan::SubchainPlan& promised = plan.subchains[i];
    const Millis period{figures.subchains[i].period_ms};
    const bool measured = period > Millis{0};
    expectation.subchains.push_back(
        {measured ? std::min(period, promised.period) : promised.period, promised.execution});
  }
  for (const trial::Pipeline& pipeline : schedule.pipelines) {
    const dispatch::Pacing& pacing = pipeline.pacing;
    if (pacing.after_completion == Nanos{0}) continue;
    expectation.subchains[pipeline.subchain.index()] = {
        to_millis(pacing.period), to_millis(pacing.period * pacing.max_in_flight - pacing.after_completion)};
  }
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    if (app.objective[term].metric != graph::Metric::kResponseTime) continue;
    const trial::TermFigures& of = figures.terms[term];
    const Millis response{of.mean_ms};
    const Millis period =
        of.count > 0 ? std::min(to_millis(expected.horizon) / static_cast<double>(of.count), response) : response;
    expectation.chains.push_back({response, response - period, period});
  }
  return expectation;
}

Result<plan::Plan> make_expected_plan(const graph::App& app, const trial::Samples& samples,
                                      const model::CostTable& costs, const ExpectedRequest& request) {
  if (Status asked = check_request(app, request.cores, request.slack); !asked) return asked.error();
  std::optional<plan::Plan> frames;
  if (may_have_frames(app)) {
    Result<plan::Plan> made = make_plan_in_frames(app, costs, {.cores = request.cores, .slack = request.slack});
    if (!made && !may_have_priorities(app)) return made;
    if (made) frames = *std::move(made);
  }
  ScheduleSearch search(app, {.cores = request.cores, .slack = request.slack, .seed = request.seed});
  search.know_clocks(clocks_of(app.graph));
  search.set_costs(samples, costs);
  if (!may_have_priorities(app)) return with_expectation(search, app, *frames, trial::schedule_of(app, *frames));
  if (frames) search.add(trial::schedule_of(app, *frames), frames->relax_factor);
  look_for_priorities(search, app, request);
  // The search goes by a guess of what is promised; here it is known.
  std::optional<plan::Plan> best;
  trial::Schedule best_schedule;
  double best_score = std::numeric_limits<double>::infinity();
  for (const Found& found : search.best()) {
    std::optional<plan::Plan> plan = found.relax ? frames : plan_of(app, samples, costs, found.schedule, request.slack);
    if (!plan || !plan::validate(*plan, app, costs, request.cores)) continue;
    const double score = relaxed_score(found.score, plan->relax_factor);
    if (score >= best_score) continue;
    best_score = score;
    best = std::move(plan);
    best_schedule = found.schedule;
  }
  if (!best) return unattainable(app, costs, {.cores = request.cores, .slack = request.slack});
  return with_expectation(search, app, *std::move(best), best_schedule);
}

}  // namespace ctn::planner
