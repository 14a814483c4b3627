// Trials (src/trial) beside what they are short for: the simulator, on the same schedules at the same costs.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/mixed.h"
#include "baselines/policies.h"
#include "planner/frames.h"
#include "planner/testing/random_apps.h"
#include "policy/replan.h"
#include "policy/testing/given_places.h"
#include "sim/clocks.h"
#include "sim/simulation.h"
#include "trial/trial.h"
#include "trial_runs.h"

namespace ctn {
namespace {

using std::chrono::seconds;

constexpr std::uint64_t kSeed = 7;
constexpr Nanos kMeasured = seconds{60};

planner::RandomCase random_case(std::uint64_t seed, int subchains, int cores) {
  return planner::random_case(seed,
                              {.subchains = subchains,
                               .chains = 4,
                               .queue = seed % 3 == 0,
                               .caps = seed % 2 == 0,
                               .pairs = true,
                               .kinds = seed % 4 == 0},
                              cores);
}

// --- Fixed priorities ---

// The plan that the policy below is to follow.
baselines::RatePlan& given_plan() {
  static baselines::RatePlan plan;
  return plan;
}

Result<baselines::RatePlan> plan_as_given(const graph::App&, const model::CostTable&, const baselines::RateRequest&) {
  return given_plan();
}

// Any core and any period, so that a core has work for 65 % of its time at most, and the shorter the period the higher
// the priority: then each run ends within its period.
baselines::RatePlan random_rates(const planner::RandomCase& of, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) { return low + (high - low) * fraction_of(random()); };
  const std::size_t count = of.app.graph.subchains().size();
  baselines::RatePlan plan;
  std::vector<double> part(count);
  std::vector<double> sum(static_cast<std::size_t>(of.cores), 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    plan.subchains.push_back({.core = static_cast<int>(random() % static_cast<unsigned>(of.cores))});
    part[i] = uniform(0.1, 1.0);
    sum[static_cast<std::size_t>(plan.subchains[i].core)] += part[i];
  }
  for (std::size_t i = 0; i < count; ++i) {
    baselines::TaskPlan& task = plan.subchains[i];
    const model::CostTable there = of.costs.on(of.app, of.app.kind_of(task.core));
    const Millis cost = there.subchain_total(of.app.graph, SubchainId(i));
    task.period = cost * (sum[static_cast<std::size_t>(task.core)] / (0.65 * part[i])) +
                  there.subchain_wait(of.app.graph, SubchainId(i));
  }
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return plan.subchains[a].period > plan.subchains[b].period; });
  for (std::size_t i = 0; i < count; ++i) plan.subchains[order[i]].priority = static_cast<int>(i) + 1;
  return plan;
}

trial::Schedule schedule_of(const baselines::RatePlan& plan, int cores) {
  trial::Schedule schedule{.cores = cores, .subchains = {}, .frames = {}, .pipelines = {}};
  // The simulator's controllers begin one after the other, and the grids of their triggers with them.
  const sim::MachineCosts machine;
  const Nanos apart = machine.context_switch + machine.dispatch_event;
  for (const baselines::TaskPlan& task : plan.subchains) {
    const auto before = static_cast<Nanos::rep>(schedule.subchains.size());
    schedule.subchains.push_back(
        {.core = task.core, .priority = task.priority, .period = to_nanos(task.period), .phase = before * apart});
  }
  return schedule;
}

struct Both {
  trial::Figures tried;
  sim::Outcome simulated;
};

Both run_both(const planner::RandomCase& of, const trial::Schedule& schedule, sim::Options options) {
  const model::Workload work = varying(of.app, of.costs);
  options.machine.cores = of.cores;
  const sim::ClockChance clocks = options.clocks;
  auto outcome =
      sim::simulate(of.app, std::make_unique<sim::DrawnCosts>(of.app, work, kSeed), std::move(options), kMeasured);
  if (!outcome) throw std::runtime_error(outcome.error().message());
  const trial::Samples samples(of.app, work, Nanos{0}, kSeed);
  const Nanos warm_up = of.app.scheduler.bootstrap + policy::kSettle;
  const trial::Options tried{
      .horizon = kMeasured, .warm_up = warm_up, .p95 = true, .clocks = sim::draw_clocks(of.app.graph, clocks).external};
  return {trial::Trial(of.app, samples).run(schedule, tried), std::move(*outcome)};
}

double deviation(double figure, double of) { return std::abs(figure / of - 1.0); }

// Each response time of which there are some hundred samples, and the objective.
void expect_close(const planner::RandomCase& of, const Both& both, double response, double objective) {
  std::size_t chain = 0;
  for (std::size_t term = 0; term < of.app.objective.size(); ++term) {
    if (of.app.objective[term].metric != graph::Metric::kResponseTime) continue;
    const sim::ChainOutcome& simulated = both.simulated.chains[chain++];
    if (simulated.response_ms.count < 100) continue;
    EXPECT_LT(deviation(both.tried.terms[term].mean_ms, simulated.response_ms.mean), response)
        << simulated.path << ": " << both.tried.terms[term].mean_ms << " ms tried, " << simulated.response_ms.mean
        << " ms simulated";
  }
  ASSERT_TRUE(both.simulated.objective.has_value());
  EXPECT_LT(deviation(both.tried.objective, *both.simulated.objective), objective)
      << both.tried.objective << " tried, " << *both.simulated.objective << " simulated";
  // Of all cores together: threads of a pipeline may be on any of its own.
  double busy = 0.0;
  for (std::size_t core = 0; core < both.tried.busy.size(); ++core) {
    busy += both.tried.busy[core] - both.simulated.cores[core].real_time - both.simulated.cores[core].ordinary;
  }
  EXPECT_NEAR(busy, 0.0, 0.02);
}

class TrialAgreement : public ::testing::TestWithParam<int> {};

TEST_P(TrialAgreement, WithTheSimulatorOnFixedPriorities) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const planner::RandomCase of = random_case(seed, 3 + GetParam() % 5, 1 + GetParam() % 3);
  given_plan() = random_rates(of, seed);
  const sim::Options options{.policy = std::make_shared<baselines::RatesPolicy>("given", plan_as_given, of.costs)};
  expect_close(of, run_both(of, schedule_of(given_plan(), of.cores), options), 0.03, 0.02);
}

TEST_P(TrialAgreement, WithTheSimulatorOnWhatThePlannerMakes) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const planner::RandomCase of = random_case(seed, 3 + GetParam() % 5, 1 + GetParam() % 4);
  const plan::Plan plan = planner::make_plan_in_frames(of.app, of.costs, {.cores = of.cores}).value();
  sim::Options options{.policy = policy::make_policy("catan").value()};
  options.plans = {{Nanos{0}, plan}};
  expect_close(of, run_both(of, trial::schedule_of(of.app, plan), options), 0.06, 0.03);
}

// Who is triggered by time alone, as plans of fixed priorities have it: while a run waits, no other is triggered.
sim::Options following(const trial::Schedule& schedule) {
  std::vector<policy::SubchainPlace> places;
  for (const trial::Place& place : schedule.subchains) {
    places.push_back(policy::place_by_phase(place.priority - 1, place.core, place.period, place.phase));
  }
  return {.policy = std::make_shared<policy::GivenPlaces>(std::move(places))};
}

// Callbacks of messages, as often as they are triggered.
TEST_P(TrialAgreement, WithTheSimulatorWhereRunsNeedInput) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  planner::RandomCase of = random_case(seed, 3 + GetParam() % 5, 1 + GetParam() % 3);
  planner::need_input(of.app);
  const trial::Schedule schedule = schedule_of(random_rates(of, seed), of.cores);
  expect_close(of, run_both(of, schedule, following(schedule)), 0.03, 0.02);
}

// Every other node waits for up to two times as long as it computes.
planner::RandomCase with_waits(planner::RandomCase of, std::uint64_t seed) {
  for (std::size_t node = 0; node < of.app.graph.nodes().size(); ++node) {
    const std::uint64_t chance = mixed_of(seed, node);
    if (chance % 2 == 0 || of.app.graph.nodes()[node].external) continue;
    const double part = static_cast<double>(chance % 97) / 48.0;
    of.costs.set_wait(NodeId(node), part * of.costs[NodeId(node)].single_thread());
  }
  return of;
}

TEST_P(TrialAgreement, WithTheSimulatorWhereRunsWait) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const planner::RandomCase of = with_waits(random_case(seed, 3 + GetParam() % 5, 1 + GetParam() % 3), seed);
  given_plan() = random_rates(of, seed);
  const sim::Options options{.policy = std::make_shared<baselines::RatesPolicy>("given", plan_as_given, of.costs)};
  expect_close(of, run_both(of, schedule_of(given_plan(), of.cores), options), 0.03, 0.02);
}

TEST_P(TrialAgreement, WithTheSimulatorOnWhatThePlannerMakesWhereRunsWait) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const planner::RandomCase of = with_waits(random_case(seed, 3 + GetParam() % 5, 1 + GetParam() % 4), seed);
  const plan::Plan plan = planner::make_plan_in_frames(of.app, of.costs, {.cores = of.cores}).value();
  sim::Options options{.policy = policy::make_policy("catan").value()};
  options.plans = {{Nanos{0}, plan}};
  expect_close(of, run_both(of, trial::schedule_of(of.app, plan), options), 0.06, 0.03);
}

// --- A display ---

// Two chains that end at its ticks, of which one begins at those of a camera.
planner::RandomCase with_display(std::uint64_t seed, Nanos camera = std::chrono::microseconds{33'333}) {
  graph::AppSpec spec =
      graph::spec_of({"camera", "track", "draw", "warp", "display"}, {"camera track draw warp display", "track warp"});
  for (const char* name : {"camera", "display"}) graph::node(spec, name).external = true;
  graph::node(spec, "camera").period = graph::At<Nanos>{camera, {}};
  graph::node(spec, "display").period = graph::At<Nanos>{std::chrono::microseconds{8'333}, {}};
  spec.objective = {graph::response("camera track draw warp display", 0.5), graph::response("track warp display", 0.5),
                    graph::response("draw warp display", 1.0)};
  graph::App app = graph::build_app(spec).value();
  model::CostTable costs(app.graph, Millis{1.0});
  costs.set(*app.graph.find_node("track"), model::CostProfile::constant(Millis{6.0}));
  return {.app = std::move(app), .costs = std::move(costs), .cores = 1 + static_cast<int>(seed % 2)};
}

TEST_P(TrialAgreement, WithTheSimulatorOfClocksThatAreNotOurs) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const planner::RandomCase of = with_display(seed);
  given_plan() = random_rates(of, seed);
  sim::Options options{.policy = std::make_shared<baselines::RatesPolicy>("given", plan_as_given, of.costs)};
  options.clocks = {.seed = seed, .drift_ppm = 200.0};
  expect_close(of, run_both(of, schedule_of(given_plan(), of.cores), options), 0.03, 0.02);
}

// Mostly sooner than the camera's next tick, for which track waits then. The camera's phase to the display has to
// change soon: all keep step with the camera, and at 33.3 ms it would be chance for minutes which tick each is in time
// for.
TEST_P(TrialAgreement, WithTheSimulatorBehindACameraWhereRunsNeedInput) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  planner::RandomCase of = with_display(seed, std::chrono::milliseconds{31});
  planner::need_input(of.app);
  const trial::Schedule schedule = schedule_of(random_rates(of, seed), of.cores);
  sim::Options options = following(schedule);
  options.clocks = {.seed = seed, .drift_ppm = 200.0};
  const Both both = run_both(of, schedule, options);
  expect_close(of, both, 0.03, 0.02);
  EXPECT_GE(both.tried.subchains[0].period_ms, 30.9) << "what is triggered more often waits";
}

// Both draw at each tick, warp just before it.
TEST(TrialAgreementOfClocks, WithTheSimulatorOnPhasesToADisplay) {
  const planner::RandomCase of = with_display(1);
  trial::Schedule schedule{.cores = 2, .subchains = {}, .frames = {}, .pipelines = {}};
  const NodeId display = *of.app.graph.find_node("display");
  const Nanos tick = *of.app.graph.node(display).period;
  std::vector<policy::SubchainPlace> places;
  const auto add = [&](int core, int priority, Nanos period, Nanos phase, bool to_display) {
    schedule.subchains.push_back({.core = core, .priority = priority, .period = period, .phase = phase});
    places.push_back(policy::place_by_phase(priority - 1, core, period, phase));
    if (!to_display) return;
    schedule.subchains.back().clock = display;
    places.back().pacing.clock = display;
    places.back().pacing.ticks = {static_cast<int>(period / tick), 1};
  };
  add(0, 1, std::chrono::milliseconds{20}, Nanos{0}, false);
  add(1, 1, 2 * tick, std::chrono::milliseconds{4}, true);
  add(1, 2, tick, std::chrono::milliseconds{7}, true);
  sim::Options options{.policy = std::make_shared<policy::GivenPlaces>(places)};
  options.clocks = {.seed = 5, .drift_ppm = 100.0};
  const Both both = run_both(of, schedule, options);
  expect_close(of, both, 0.02, 0.02);
  // draw -> warp -> display: two ticks between outputs, from 4 ms after a tick to the next one.
  EXPECT_NEAR(both.simulated.chains[2].response_ms.mean, to_millis(3 * tick).count() - 4.0, 0.2);
}

INSTANTIATE_TEST_SUITE_P(RandomApps, TrialAgreement, ::testing::Range(0, 16));

}  // namespace
}  // namespace ctn
