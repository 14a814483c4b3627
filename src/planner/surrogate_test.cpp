// The formulas of means, beside what can be written down by hand.
#include "planner/surrogate.h"

#include <gtest/gtest.h>

#include <chrono>
#include <utility>
#include <vector>

#include "planner/clock_phases.h"
#include "planner/run_spread.h"
#include "planner/testing/small_apps.h"
#include "trial/trial.h"

namespace ctn::planner {
namespace {

TEST(Surrogate, AddsUpMeans) {
  Two two;
  EXPECT_NEAR(two.a, 1.0, 0.1) << "and what the machine takes";
  const Estimate estimate = two.surrogate(Two::schedule()).value();
  // It meets runs of a under way, and more of them come.
  const double run_of_b = (two.b + two.a * two.a / 10.0 / 2.0) / (1.0 - two.a / 10.0);
  // b is triggered with every other run of a, and may be too early for it.
  EXPECT_NEAR(estimate.objective, 10.0 + run_of_b + 20.0, 1e-9);
  EXPECT_NEAR(estimate.load, two.a / 10.0 + two.b / 20.0, 1e-9);
  EXPECT_EQ(estimate.relax, 1.0);
}

TEST(Surrogate, AFollowerDoesNotWait) {
  Two two;
  trial::Schedule schedule = Two::schedule();
  schedule.subchains[1].after = plan::After{SubchainId(0), 1};
  schedule.subchains[1].period = Nanos{0};
  const double run_of_b = two.b / (1.0 - two.a / 10.0);
  EXPECT_NEAR(two.surrogate(schedule).value().objective, two.a + run_of_b + 10.0, 1e-9);
}

// b, once in 20 ms, holds a back, which is below it now and comes every 3 ms.
TEST(Surrogate, ALongRunMakesThoseBelowItMissTriggers) {
  Two two;
  trial::Schedule schedule = Two::schedule();
  std::swap(schedule.subchains[0].priority, schedule.subchains[1].priority);
  schedule.subchains[0].period = std::chrono::milliseconds{3};
  const double held_back = two.b + two.a / (1.0 - two.b / 20.0);
  const double kept = 1.0 - (held_back - 3.0) / 20.0;
  EXPECT_NEAR(two.surrogate(schedule).value().load, two.a * kept / 3.0 + two.b / 20.0, 1e-9);
}

// The same where b is triggered by a: it runs after a's run, and holds up the next one.
TEST(Surrogate, ALeaderMissesTriggersWhileItsFollowersRun) {
  Two two;
  trial::Schedule schedule = Two::schedule();
  std::swap(schedule.subchains[0].priority, schedule.subchains[1].priority);
  schedule.subchains[0].period = std::chrono::milliseconds{3};
  schedule.subchains[1].after = plan::After{SubchainId(0), 1};
  const double kept = 1.0 - (two.b + two.a - 3.0) / 20.0;
  EXPECT_NEAR(two.surrogate(schedule).value().load, two.a * kept / 3.0 + two.b / 20.0, 1e-9);
}

// Each on a core of its own.
TEST(Surrogate, WhoComesSeldomTakesTheNewest) {
  Two two;
  trial::Schedule schedule = Two::schedule();
  schedule.cores = 2;
  schedule.subchains[0].core = 1;
  schedule.subchains[1].period = std::chrono::milliseconds{23};
  EXPECT_NEAR(two.surrogate(schedule).value().objective, two.a + 10.0 / 2.0 + two.b + 23.0, 0.05)
      << "not half of its own period";
}

// A sensor gives something each 5 ms.
TEST(Surrogate, WhoIsHeldBackDoesNotFollow) {
  graph::AppSpec spec = graph::spec_of({"sensor", "a"}, {"sensor a"});
  node(spec, "sensor").unscheduled = true;
  node(spec, "sensor").period = graph::At<Nanos>{std::chrono::milliseconds{5}, {}};
  spec.objective = {graph::response("sensor a", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  const model::CostTable costs(app.graph, Millis{1});
  const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
  Surrogate surrogate(app, samples, costs, 0.0);
  const auto objective = [&](Nanos period) {
    const trial::Place place{.period = period, .after = plan::After{*app.graph.find_node("sensor"), 1}};
    return surrogate({.cores = 1, .subchains = {place}, .frames = {}, .pipelines = {}}).value().objective;
  };
  const double follows = objective(std::chrono::milliseconds{4});
  EXPECT_NEAR(objective(std::chrono::milliseconds{8}), follows + 5.0 / 2.0 + (8.0 - 5.0), 0.1);
}

// Half of b's runs take 1 ms, the others 7: of the triggers that come meanwhile one is made up for.
TEST(Surrogate, ALongRunMissesTriggersOfItsOwn) {
  Two two;
  model::Workload work = constant_work(two.app, two.costs);
  model::NodeWork now_and_then = model::NodeWork::constant(Millis{1.0});
  now_and_then.spikes = model::Spikes{0.5, Millis{6.0}};
  work.set(NodeId(1), now_and_then);
  const trial::Samples samples(two.app, work, Nanos{0}, 1);
  Surrogate surrogate(two.app, samples, two.costs, 0.0);
  trial::Schedule schedule = Two::schedule();
  schedule.subchains[0].core = 1;
  schedule.cores = 2;
  schedule.subchains[1].period = std::chrono::milliseconds{2};
  ASSERT_TRUE(surrogate(schedule));
  EXPECT_NEAR(surrogate.period(SubchainId(1)).count(), 2.0 * (1.0 + 0.5 * (7.1 / 2.0 - 1.5)), 0.2);
}

// b, a queue node, comes each 2 ms, and a's outputs each 10.
TEST(Surrogate, RunsWithoutInputDoNotCount) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "base"}, {"a b base"});
  node(spec, "base").external = true;
  node(spec, "b").input = graph::InputKind::kQueue;
  spec.objective = {graph::period("b", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  const model::CostTable costs(app.graph, Millis{1});
  const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
  Surrogate surrogate(app, samples, costs, 0.0);
  trial::Schedule schedule = Two::schedule();
  schedule.subchains[1].period = std::chrono::milliseconds{2};
  EXPECT_NEAR(surrogate(schedule).value().objective, 10.0, 1e-9);
  schedule.subchains[1].pause = std::chrono::milliseconds{1};
  EXPECT_NEAR(surrogate(schedule).value().objective, 10.0, 1e-4);
  schedule.subchains[1].pause = std::chrono::milliseconds{20};
  EXPECT_GT(surrogate(schedule).value().objective, 20.0);
}

// b takes what a gives: two items in 20 ms, at 0.5 ms each.
TEST(Surrogate, ABatchCostsWhatComesInItsPeriod) {
  Two two;
  graph::AppSpec spec = graph::spec_of({"a", "b", "base"}, {"a b base"});
  node(spec, "base").external = true;
  node(spec, "b").input = graph::InputKind::kQueue;
  spec.objective = {graph::response("a b base", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  model::CostTable costs = two.costs;
  costs.set(NodeId(1), model::CostProfile::constant(Millis{4}).with_per_item(Millis{0.5}));
  const trial::Samples samples(app, trial::MeasuredRuns{}, costs);
  Surrogate surrogate(app, samples, costs, 0.0);
  trial::Schedule schedule = Two::schedule();
  EXPECT_NEAR(surrogate(schedule).value().load, two.a / 10.0 + (two.b + 2 * 0.5) / 20.0, 1e-9);
  // Half as often, it saves only the fixed part.
  schedule.subchains[1].period *= 2;
  EXPECT_NEAR(surrogate(schedule).value().load, two.a / 10.0 + (two.b + 4 * 0.5) / 40.0, 1e-9);
  // Right after its own run: as long as that is, so many items come.
  schedule.subchains[1].pause = Nanos{0};
  schedule.subchains[1].period = Nanos{0};
  const double load = surrogate(schedule).value().load;
  EXPECT_GT(load, 0.9);
  EXPECT_LT(load, 1.05);
}

TEST(Surrogate, IsCorrectedTermByTerm) {
  Two two;
  const double before = two.surrogate(Two::schedule()).value().objective;
  two.surrogate.correct({1.5});
  EXPECT_NEAR(two.surrogate(Two::schedule()).value().objective, 1.5 * before, 1e-9);
  EXPECT_NEAR(two.surrogate.terms().at(0), before, 1e-9);
  two.surrogate.correct({});
  EXPECT_NEAR(two.surrogate(Two::schedule()).value().objective, before, 1e-9);
}

TEST(Surrogate, KnowsLoadsAndIsCorrected) {
  Two two;
  two.surrogate.correct({1.0}, 1.1);
  const double both = two.surrogate(Two::schedule()).value().load;
  EXPECT_NEAR(both, 1.1 * (two.a / 10.0 + two.b / 20.0), 1e-9);
  EXPECT_NEAR(two.surrogate.load(SubchainId(0)), 1.1 * two.a / 10.0, 1e-9);
  EXPECT_NEAR(two.surrogate.fullest(), both / 1.1, 1e-9);
  EXPECT_NEAR(two.surrogate.period(SubchainId(1)).count(), 20.0, 1e-9);
}

// b, each 2 ms, reads what a gives each 10 ms.
TEST(Surrogate, KnowsWhoWaitsForInput) {
  Two two;
  const std::vector<NodeId> needing{NodeId(1)};
  graph::App app = two.app;
  app.graph = app.graph.needing_input(needing);
  trial::Schedule schedule = Two::schedule();
  schedule.cores = 2;
  schedule.subchains[1].core = 1;
  schedule.subchains[1].period = std::chrono::milliseconds{2};
  Surrogate surrogate(app, two.samples, two.costs, 0.0);
  ASSERT_TRUE(surrogate(schedule));
  EXPECT_NEAR(surrogate.period(SubchainId(1)).count(), 10.0, 1e-9);
  EXPECT_LT(two.surrogate(schedule)->objective, 25.0) << "the same, if b needs none";
  schedule.subchains[0].after = plan::After{SubchainId(1), 1};
  EXPECT_FALSE(surrogate(schedule)) << "a is to follow b, which waits for a";
  EXPECT_TRUE(two.surrogate(schedule));
}

TEST(Surrogate, KnowsWhenNothingIsLeft) {
  Two two;
  trial::Schedule schedule = Two::schedule();
  schedule.subchains[0].period = std::chrono::milliseconds{1};
  EXPECT_FALSE(two.surrogate(schedule));
}

TEST(Surrogate, KnowsWhatIsLeftUntilTheTick) {
  const graph::App app = drawing();
  const model::CostTable costs(app.graph, Millis{1});
  const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
  Surrogate surrogate(app, samples, costs, 0.0);
  const double cost = surrogate.mean_cost(SubchainId(0), 0);
  trial::Place place{.period = Nanos{8'333'333}, .phase = std::chrono::milliseconds{6}};
  const auto objective = [&] {
    return surrogate({.cores = 1, .subchains = {place}, .frames = {}, .pipelines = {}}).value().objective;
  };
  EXPECT_NEAR(objective(), cost + 1.5 * 8.333333, 1e-6);
  place.clock = app.graph.find_node("display");
  EXPECT_NEAR(objective(), 8.333333 - 6.0 + 8.333333, 1e-6) << "the run itself is part of what is left";
}

// A trial wakes threads late, and takes what is there just before a tick to miss it.
TEST(Surrogate, KnowsThatThreadsAreWokenLate) {
  const graph::App app = drawing();
  const model::CostTable costs(app.graph, Millis{1});
  const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
  const trial::Overheads machine{.timer_latency = std::chrono::microseconds{100},
                                 .timer_jitter = std::chrono::microseconds{200}};
  Surrogate surrogate(app, samples, costs, 0.0, machine);
  const double needed = surrogate.mean_cost(SubchainId(0), 0) + 0.3 + to_millis(kBeforeTicks).count();
  const double tick = 8.333333;
  trial::Place place{.period = Nanos{8'333'333}, .clock = app.graph.find_node("display")};
  const auto objective = [&](double before_the_tick) {
    place.phase = to_nanos(Millis{tick - before_the_tick});
    return surrogate({.cores = 1, .subchains = {place}, .frames = {}, .pipelines = {}}).value().objective;
  };
  EXPECT_NEAR(objective(needed + 0.01), needed + 0.01 + tick, 1e-6);
  EXPECT_NEAR(objective(needed - 0.01), needed - 0.01 + 2.0 * tick, 1e-6) << "it may be shown a tick later";
}

// Half of its runs take 1 ms, the others 3. Those that end too late are shown a tick later, or overwritten by the next
// run where that is in time; so of the ticks each fourth shows nothing new.
TEST(Surrogate, KnowsThatLongRunsMissTheTick) {
  const graph::App app = drawing();
  const model::CostTable costs(app.graph, Millis{1});
  model::Workload work = constant_work(app, costs);
  model::NodeWork now_and_then = model::NodeWork::constant(Millis{1.0});
  now_and_then.spikes = model::Spikes{0.5, Millis{2.0}};
  work.set(NodeId(0), now_and_then);
  const trial::Samples samples(app, work, Nanos{0}, 1);
  Surrogate surrogate(app, samples, costs, 0.0);
  const double tick = 8.333333;
  trial::Place place{.period = Nanos{8'333'333}, .clock = app.graph.find_node("display")};
  const auto objective = [&](double before_the_tick) {
    place.phase = to_nanos(Millis{tick - before_the_tick});
    return surrogate({.cores = 1, .subchains = {place}, .frames = {}, .pipelines = {}}).value().objective;
  };
  EXPECT_NEAR(objective(4.0), 4.0 + tick, 0.02) << "all are in time";
  EXPECT_NEAR(objective(2.0), 2.0 + tick / 2.0 + tick * 4.0 / 3.0, 1.1 * tick / RunSpread::kParts) << "by parts";
}

// It polls a camera each 10 ms and finds a picture each 50: what a chain takes that does not begin with the camera is
// known to be fed no sooner.
TEST(Surrogate, KnowsThatIdleRunsGiveNothing) {
  graph::AppSpec spec = graph::spec_of({"camera", "grab", "track", "imu"}, {"camera grab", "grab track", "imu track"});
  graph::node(spec, "camera").external = true;
  graph::node(spec, "camera").period = graph::At<Nanos>{std::chrono::milliseconds{50}, {}};
  spec.subchains = {graph::subchain("tracking", "grab track")};
  spec.objective = {graph::response("imu track", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  model::CostTable costs(app.graph, Millis{1});
  const auto period_of = [&] {
    const trial::Samples samples(app, constant_work(app, costs), Nanos{0}, 1);
    Surrogate surrogate(app, samples, costs, 0.0);
    const trial::Place polls{.priority = 1, .period = std::chrono::milliseconds{10}};
    const trial::Place often{.core = 1, .priority = 1, .period = std::chrono::milliseconds{2}};
    return surrogate({.cores = 2, .subchains = {polls, often}, .frames = {}, .pipelines = {}}).value().objective;
  };
  const double without = period_of();
  costs.set_idle(*app.graph.find_node("grab"), {1.0, Millis{0.1}});
  EXPECT_NEAR(period_of(), without + 40.0, 1e-6);
}

}  // namespace
}  // namespace ctn::planner
