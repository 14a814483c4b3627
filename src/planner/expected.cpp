#include "planner/expected.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "planner/formulas.h"
#include "planner/frames.h"
#include "planner/planner.h"
#include "planner/promised.h"
#include "trial/schedule.h"
#include "trial/trial.h"

namespace ctn::planner {
namespace {

// Steps at effort 1.
constexpr double kGuesses = 200'000;
constexpr std::chrono::duration<double> kWork{5.0};
// What is found is tried for so long at last. Two periods that hardly differ slide for a minute and more through what
// they do to each other, and a trial of some seconds sees but the beginning.
constexpr Nanos kSlides = std::chrono::minutes{2};

// As many steps as in one go, with word of them on the way.
void look_for_priorities(ScheduleSearch& search, const graph::App& app, const ExpectedRequest& request) {
  const bool frames = request.known && std::any_of(request.known->cores.begin(), request.known->cores.end(),
                                                   [](const plan::CorePlan& core) { return !core.slots.empty(); });
  if (request.known && !frames) {
    trial::Schedule schedule = trial::schedule_of(app, *request.known);
    schedule.cores = request.cores;
    search.add(std::move(schedule), std::nullopt);
  }
  const Nanos all = std::chrono::duration_cast<Nanos>(kWork * request.effort);
  const Nanos begin = search.work();
  const auto tell = [&] {
    if (request.on_progress) request.on_progress(std::min(1.0, to_millis(search.work() - begin) / to_millis(all)));
  };
  search.guess(static_cast<std::size_t>(kGuesses * request.effort), tell);
  constexpr Nanos kWord = std::chrono::milliseconds{100};
  for (Nanos done = search.work() - begin; done < all; done = search.work() - begin) {
    search.improve(std::min(kWord, all - done));
    tell();
  }
  search.confirm(kSlides);
}

plan::Plan with_expectation(ScheduleSearch& search, const graph::App& app, plan::Plan plan,
                            const trial::Schedule& schedule) {
  plan.expected = expectation_of(app, plan, schedule, search.expected(schedule, kSlides));
  return plan;
}

// Offline, callers have an app that tells its ticks.
std::vector<NodeId> clocks_of(const graph::Graph& graph) {
  std::vector<NodeId> clocks;
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    if (graph.nodes()[index].has_clock()) clocks.emplace_back(index);
  }
  return clocks;
}

}  // namespace

// A response time is a latency and a period on average, too. A subchain with cores of its own is paced by what is
// expected: it is paced as it was tried.
plan::Expectation expectation_of(const graph::App& app, const plan::Plan& plan, const trial::Schedule& schedule,
                                 const Expected& expected) {
  const trial::Figures& figures = expected.figures;
  plan::Expectation expectation{.objective = figures.objective, .subchains = {}, .chains = {}};
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const plan::SubchainPlan& promised = plan.subchains[i];
    const Millis period{figures.subchains[i].period_ms};
    plan::Expectation::Timing& timing =
        expectation.subchains.emplace_back(plan::Expectation::Timing{promised.period, promised.execution});
    const bool measured = period > Millis{0};
    // A promise is for runs that all cost the same, so it is not the longest period on average: not where it is for
    // typical compute times, nor of a subchain with a fixed priority, which misses triggers while a long run lasts.
    // Nor of one that waits for its input.
    const bool may_be_longer = plan.for_typical || plan::member_of(plan, SubchainId(i)) != nullptr ||
                               app.graph.awaits_input(app.graph.subchain(SubchainId(i)).head());
    if (measured && (may_be_longer || period < promised.period)) timing.period = period;
    const trial::Place& place = schedule.subchains[i];
    const bool owner = promised.cores.size() == 1 && !plan::shares_core(plan, promised);
    if (owner && place.pause) timing.execution = std::max(timing.period - to_millis(*place.pause), Millis{0});
  }
  for (const trial::Pipeline& pipeline : schedule.pipelines) {
    const dispatch::Pacing& pacing = pipeline.pacing;
    if (pacing.after_completion == Nanos{0}) continue;
    plan::Expectation::Timing& timing = expectation.subchains[pipeline.subchain.index()];
    const bool waits = app.graph.awaits_input(app.graph.subchain(pipeline.subchain).head());
    timing.period = waits ? std::max(timing.period, to_millis(pacing.period)) : to_millis(pacing.period);
    timing.execution = to_millis(pacing.period * pacing.max_in_flight - pacing.after_completion);
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
  ScheduleSearch search(
      app, {.cores = request.cores, .slack = request.slack, .seed = request.seed, .freedom = request.freedom});
  search.know_clocks(clocks_of(app.graph));
  search.set_costs(samples, costs);
  if (!may_have_priorities(app)) return with_expectation(search, app, *frames, trial::schedule_of(app, *frames));
  if (frames) search.add(trial::schedule_of(app, *frames), frames->relax_factor);
  look_for_priorities(search, app, request);
  std::optional<Promised> best = best_promised(search, app, request.cores, request.slack, frames);
  if (!best) return unattainable(app, costs, {.cores = request.cores, .slack = request.slack});
  return with_expectation(search, app, std::move(best->plan), best->schedule);
}

}  // namespace ctn::planner
