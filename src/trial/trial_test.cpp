// Trials by hand, on a machine where scheduling costs nothing: which subchain ran from when to when, and what it came
// to.
#include "trial/trial.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "catan/channel.h"
#include "trial/testing/world.h"

namespace ctn::trial {
namespace {

using std::chrono::milliseconds;

static_assert(kQueueCapacity == QueueChannel<int>::kCapacity);

TEST(Trial, TriggersByTimeAtThePhaseAndEveryPeriodAfterIt) {
  World world(two(), {{"a", 2}, {"b", 3}});
  world.run(on_cores(2, {{.core = 0, .period = ms(10), .phase = ms(2)}, {.core = 1, .period = ms(8)}}), ms(25));
  EXPECT_EQ(world.timeline["a"], "2-4 12-14 22-24");
  EXPECT_EQ(world.timeline["b"], "0-3 8-11 16-19");
}

// 47 ms later a's triggers are at 52 and 62, b's at 48 and 56.
TEST(Trial, BeginsAsLongAfterTheFirstTriggersAsItIsTold) {
  World world(two(), {{"a", 2}, {"b", 3}});
  const Samples samples(world.app, MeasuredRuns{}, world.costs);
  const Schedule schedule = on_cores(2, {{.core = 0, .period = ms(10), .phase = ms(2)}, {.core = 1, .period = ms(8)}});
  static_cast<void>(Trial(world.app, samples)
                        .run(schedule, {.horizon = ms(20),
                                        .warm_up = Nanos{0},
                                        .since = ms(47),
                                        .overheads = Overheads::none(),
                                        .observer = &world.timeline}));
  EXPECT_EQ(world.timeline["a"], "5-7 15-17");
  EXPECT_EQ(world.timeline["b"], "1-4 9-12 17-20");
}

TEST(Trial, AHigherPriorityPreEmptsAndTheRunGoesOnAfterwards) {
  World world(two(), {{"a", 2}, {"b", 6}});
  world.run(on_cores(1, {{.priority = 2, .period = ms(10), .phase = ms(3)}, {.priority = 1, .period = ms(20)}}),
            ms(20));
  EXPECT_EQ(world.timeline["a"], "3-5 13-15");
  EXPECT_EQ(world.timeline["b"], "0-8");
}

TEST(Trial, ALowerPriorityWaitsForTheEndOfTheRun) {
  World world(two(), {{"a", 2}, {"b", 6}});
  world.run(on_cores(1, {{.priority = 1, .period = ms(20), .phase = ms(3)}, {.priority = 2, .period = ms(20)}}),
            ms(20));
  EXPECT_EQ(world.timeline["a"], "6-8");
  EXPECT_EQ(world.timeline["b"], "0-6");
}

// b is due at 20, while its run of 10 is under way: one trigger makes up for it, and the next one comes at 30.
TEST(Trial, WhatComesDueDuringARunIsMadeUpForAtItsEndAndTheGridStays) {
  World world(two(), {{"a", 12}, {"b", 4}});
  world.run(on_cores(1, {{.priority = 2, .period = ms(100), .phase = ms(5)}, {.priority = 1, .period = ms(10)}}),
            ms(45));
  EXPECT_EQ(world.timeline["b"], "0-4 17-21 21-25 30-34 40-44");
}

TEST(Trial, SeveralTriggersThatAreMissedAreMadeUpForByOne) {
  World world(two(), {{"a", 1}, {"b", 35}});
  world.run(on_cores(2, {{.core = 0, .period = ms(100)}, {.core = 1, .period = ms(10)}}), ms(80));
  EXPECT_EQ(world.timeline["b"], "0-35 35-70");
}

TEST(Trial, APauseFollowsTheRunAndThePeriodIsTheLeastBetweenTriggers) {
  World world(two(), {{"a", 2}, {"b", 9}});
  world.run(on_cores(2, {{.core = 0, .period = ms(10), .pause = ms(3)}, {.core = 1, .period = ms(10), .pause = ms(3)}}),
            ms(35));
  EXPECT_EQ(world.timeline["a"], "0-2 10-12 20-22 30-32");
  EXPECT_EQ(world.timeline["b"], "0-9 12-21 24-33");
}

TEST(Trial, WithoutAPauseARunFollowsTheOther) {
  World world(two(), {{"a", 2}, {"b", 9}});
  world.run(on_cores(2, {{.core = 0, .period = ms(10)}, {.core = 1, .period = ms(1), .pause = Nanos{0}}}), ms(30));
  EXPECT_EQ(world.timeline["b"], "0-9 9-18 18-27");
}

TEST(Trial, EverySoManyThOutputTriggersAFollower) {
  World world(two(), {{"a", 1}, {"b", 2}});
  world.run(on_cores(1, {{.priority = 1, .period = ms(5)}, {.priority = 2, .after = plan::After{SubchainId(0), 2}}}),
            ms(20));
  EXPECT_EQ(world.timeline["a"], "0-1 5-6 10-11 15-16");
  EXPECT_EQ(world.timeline["b"], "6-8 16-18");
}

TEST(Trial, AFollowersOutputsThatComeSoonerThanItsPeriodWait) {
  World world(two(), {{"a", 1}, {"b", 2}});
  world.run(
      on_cores(2, {{.core = 0, .period = ms(5)}, {.core = 1, .period = ms(8), .after = plan::After{SubchainId(0), 1}}}),
      ms(30));
  EXPECT_EQ(world.timeline["b"], "1-3 9-11 17-19 25-27");
}

// Outputs of a at 1, 6, 11, 16, ...; b begins at 1, and what came by 13 makes for one trigger then.
TEST(Trial, OutputsThatComeDuringARunOfTheFollowerMakeForOneTriggerAtItsEnd) {
  World world(two(), {{"a", 1}, {"b", 12}});
  world.run(on_cores(2, {{.core = 0, .period = ms(5)}, {.core = 1, .after = plan::After{SubchainId(0), 1}}}), ms(38));
  EXPECT_EQ(world.timeline["b"], "1-13 13-25 25-37");
}

// b is held back until 2 ms after its first trigger, and its timer is late: the output that comes just before it is the
// trigger, and the timer is none.
TEST(Trial, ATimerThatAnOutputHasForestalledTriggersNothing) {
  World world(two(), {{"a", 0.2}, {"b", 0.5}});
  const Samples samples(world.app, MeasuredRuns{}, world.costs);
  Overheads overheads = Overheads::none();
  overheads.timer_latency = std::chrono::microseconds{100};
  const Schedule schedule = on_cores(
      2, {{.core = 0, .period = ms(1)}, {.core = 1, .period = ms(1.95), .after = plan::After{SubchainId(0), 1}}});
  Trial(world.app, samples)
      .run(schedule, {.horizon = ms(4), .warm_up = Nanos{0}, .overheads = overheads, .observer = &world.timeline});
  EXPECT_EQ(world.timeline["b"], "0.3-0.8 2.3-2.8");
}

TEST(Trial, ARunBeyondItsBudgetIsDemotedUntilTheNextTrigger) {
  World world(two(), {{"a", 10}, {"b", 4}});
  world.run(on_cores(1, {{.priority = 2, .period = ms(20), .budget = ms(3)}, {.priority = 1, .period = ms(20)}}),
            ms(40));
  EXPECT_EQ(world.timeline["a"], "0-14 20-34");
  EXPECT_EQ(world.timeline["b"], "3.05-7.05 23.05-27.05") << "what is used is looked at every 50 us";
}

// Demoted at 6.05, a's run gets another budget at 20 in place of a trigger; the rest of it is less than that.
TEST(Trial, ALongRunGetsABudgetEachPeriod) {
  World world(two(), {{"a", 10}, {"b", 60}});
  world.run(on_cores(1, {{.priority = 2, .period = ms(20), .budget = ms(6)}, {.priority = 1, .period = ms(100)}}),
            ms(70));
  EXPECT_EQ(world.timeline["a"], "0-23.95 40-63.95");
}

TEST(Trial, ABudgetIsOfTheWholeRunAndOfCpuTimeAlone) {
  graph::AppSpec spec = graph::spec_of({"a", "c", "b", "h"}, {"a c", "b h"});
  spec.subchains = {graph::subchain("ac", "a c")};
  spec.objective = {graph::response("a c", 1.0)};
  World world(spec, {{"a", 2}, {"c", 4}, {"b", 4}, {"h", 3}});
  Schedule schedule = on_cores(1, std::vector<Place>(3));
  schedule.subchains[world.subchain("ac").index()] = {.priority = 2, .period = ms(50), .budget = ms(3)};
  schedule.subchains[world.subchain("b").index()] = {.priority = 1, .period = ms(50)};
  schedule.subchains[world.subchain("h").index()] = {.priority = 3, .period = ms(50), .phase = ms(1)};
  world.run(schedule, ms(50));
  EXPECT_EQ(world.timeline["h"], "1-4");
  EXPECT_EQ(world.timeline["a"], "0-5");
  EXPECT_EQ(world.timeline["b"], "6.05-10.05");
  EXPECT_EQ(world.timeline["c"], "5-13");
}

// a begins at 10 k, b ends 5 ms after that.
TEST(Trial, AResponseIsFromTheBeginOfTheSourceRunBefore) {
  World world(two(), {{"a", 2}, {"b", 3}});
  const Figures figures = world.run(
      on_cores(1, {{.priority = 1, .period = ms(10)}, {.priority = 2, .after = plan::After{SubchainId(0), 1}}}),
      ms(1000));
  EXPECT_EQ(figures.terms[0].count, 99U);
  EXPECT_NEAR(figures.terms[0].mean_ms, 15.0, 1e-9);
  EXPECT_NEAR(figures.terms[0].p95_ms, 15.0, 1e-9);
  EXPECT_EQ(figures.terms[1].count, 99U);
  EXPECT_NEAR(figures.terms[1].mean_ms, 10.0, 1e-9);
  EXPECT_NEAR(figures.objective, 15.0 + 0.5 * 10.0, 1e-9);
  EXPECT_TRUE(figures.enough);
  EXPECT_NEAR(figures.busy[0], 0.5, 1e-9);
  EXPECT_NEAR(figures.subchains[0].period_ms, 10.0, 1e-9);
  EXPECT_EQ(figures.subchains[0].runs, 100U);
}

// b is twice as slow as a: every other run of a reaches the end.
TEST(Trial, ASourceRunThatIsOvertakenCountsForNothing) {
  World world(two(), {{"a", 2}, {"b", 3}});
  const Figures figures = world.run(
      on_cores(1, {{.priority = 2, .period = ms(10)}, {.priority = 1, .period = ms(20), .phase = ms(4)}}), ms(1000));
  EXPECT_EQ(figures.terms[0].count, 49U);
  EXPECT_NEAR(figures.terms[0].mean_ms, 27.0, 1e-9);
}

// Runs of a begin at 0, 10, 20, 30; b takes those of 10 to 30 at 34 and ends at 37, 40 ms after the batch before.
TEST(Trial, AQueueNodeTakesAllOutputsSinceItsLastRun) {
  graph::AppSpec spec = two();
  graph::node(spec, "b").input = graph::InputKind::kQueue;
  World world(spec, {{"a", 2}, {"b", 3}});
  const Figures figures = world.run(
      on_cores(1, {{.priority = 2, .period = ms(10)}, {.priority = 1, .period = ms(40), .phase = ms(34)}}), ms(4000));
  // Of each four, from the begins of those before them: 37 + 10, 37, 27, 17.
  EXPECT_EQ(figures.terms[0].count, 4U * 100U - 1U);
  EXPECT_NEAR(figures.terms[0].mean_ms, (100 * (47 + 37 + 27 + 17) - 47) / 399.0, 1e-6);
  EXPECT_NEAR(figures.terms[0].p95_ms, 47.0, 1e-9);
}

// a gives an item at 2, 12, 22, 32 ...: b finds four at a time, but at first.
TEST(Trial, ARunOfAQueueNodeCostsWhatItsItemsAdd) {
  graph::AppSpec spec = two();
  graph::node(spec, "b").input = graph::InputKind::kQueue;
  World world(spec, {{"a", 2}});
  world.costs.set(NodeId(1), model::CostProfile::constant(Millis{1}).with_per_item(Millis{0.5}));
  const Schedule schedule =
      on_cores(2, {{.core = 0, .period = ms(10)}, {.core = 1, .period = ms(40), .phase = ms(14)}});
  world.run(schedule, ms(140));
  EXPECT_EQ(world.timeline["b"], "14-16 54-57 94-97 134-137");
  World seldom(spec, {{"a", 2}});
  seldom.costs = world.costs;
  seldom.runs_per_output("a", 2.0);
  seldom.run(schedule, ms(60));
  EXPECT_EQ(seldom.timeline["b"], "14-15.5 54-56") << "of each second run";
}

// b runs every 4 ms, and a gives it something every 10: at 0, 12, 20, 32, 40.
TEST(Trial, ThePeriodOfAQueueNodeIsOfRunsThatHadAnInput) {
  graph::AppSpec spec = two();
  graph::node(spec, "b").input = graph::InputKind::kQueue;
  World world(spec, {{"a", 0.5}, {"b", 1}});
  const Schedule schedule = on_cores(2, {{.core = 0, .period = ms(10)}, {.core = 1, .period = ms(4)}});
  const Figures figures = world.run(schedule, ms(1000));
  EXPECT_EQ(figures.subchains[1].runs, 250U);
  EXPECT_EQ(figures.terms[1].count, 99U);
  EXPECT_NEAR(figures.terms[1].mean_ms, 10.0, 0.05);
  EXPECT_NEAR(figures.terms[1].p95_ms, 12.0, 1e-9);

  graph::node(spec, "b").input = graph::InputKind::kLatest;
  World newest(spec, {{"a", 0.5}, {"b", 1}});
  EXPECT_NEAR(newest.run(schedule, ms(1000)).terms[1].mean_ms, 4.0, 1e-9);
}

TEST(Trial, WhoHasAnOutputPeriodEmitsOncePerPeriodOnAverage) {
  graph::AppSpec spec = two();
  graph::node(spec, "a").output_period = graph::At<Nanos>{milliseconds{25}, {}};
  World world(spec, {{"a", 1}, {"b", 2}});
  world.run(on_cores(1, {{.priority = 1, .period = ms(10)}, {.priority = 2, .after = plan::After{SubchainId(0), 1}}}),
            ms(60));
  EXPECT_EQ(world.timeline.emitted("a"), "x..x.x");
  EXPECT_EQ(world.timeline["b"], "1-3 31-33 51-53");
}

TEST(Trial, ARunThatEmitsNothingEndsItsSubchainsRun) {
  graph::AppSpec spec = two();
  spec.subchains = {graph::subchain("ab", "a b")};
  graph::node(spec, "a").output_period = graph::At<Nanos>{milliseconds{25}, {}};
  World world(spec, {{"a", 1}, {"b", 2}});
  world.run(on_cores(1, {{.period = ms(10)}}), ms(60));
  EXPECT_EQ(world.timeline["a"], "0-1 10-11 20-21 30-31 40-41 50-51");
  EXPECT_EQ(world.timeline["b"], "1-3 31-33 51-53");
}

TEST(Trial, AsManyRunsGiveAnOutputAsWereMeasured) {
  World world(two(), {{"a", 1}, {"b", 2}});
  world.runs_per_output("a", 2.5);
  const Figures figures = world.run(
      on_cores(1, {{.priority = 1, .period = ms(10)}, {.priority = 2, .after = plan::After{SubchainId(0), 1}}}),
      ms(10'000));
  EXPECT_EQ(world.timeline.emitted("a").substr(0, 11), "x..x.x..x.x");
  // From an output's source run to the end of the next output: 25 ms apart on average, and 3 ms each.
  EXPECT_NEAR(figures.terms[0].mean_ms, 25.0 + 3.0, 0.1);
}

// b finds something new in each third run, and else takes a tenth of its time and gives nothing.
TEST(Trial, RunsThatFindNothingNewAreIdle) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "c"}, {"a b c"});
  spec.objective = {graph::response("a b c", 1.0)};
  World world(spec, {{"a", 1}, {"b", 2}, {"c", 1}});
  world.costs.set_idle(*world.app.graph.find_node("b"), {1.0, Millis{0.2}});
  const Schedule schedule = on_cores(1, {{.priority = 3, .period = ms(30)},
                                         {.priority = 2, .period = ms(10), .phase = ms(4)},
                                         {.priority = 1, .after = plan::After{SubchainId(1), 1}}});
  world.run(schedule, ms(60));
  EXPECT_EQ(world.timeline["b"], "4-6 14-14.2 24-24.2 34-36 44-44.2 54-54.2");
  EXPECT_EQ(world.timeline.emitted("b"), "x..x..");
  EXPECT_EQ(world.timeline["c"], "6-7 36-37");
}

TEST(Trial, OfRunsThatFindNothingNewAsManyAreIdleAsWereMeasured) {
  World world(two(), {{"a", 1}, {"b", 2}});
  world.costs.set_idle(*world.app.graph.find_node("b"), {0.5, Millis{0.2}});
  world.run(on_cores(1, {{.priority = 2, .period = ms(50)}, {.priority = 1, .period = ms(10), .phase = ms(4)}}),
            ms(100));
  EXPECT_EQ(world.timeline["b"], "4-6 14-16 24-24.2 34-36 44-44.2 54-56 64-66 74-74.2 84-86 94-94.2");
  EXPECT_EQ(world.timeline.emitted("b"), "xx.x.xx.x.");
}

// The camera ticks each 40 ms: who runs right after each tick gives an output each time, and who runs more often none
// in between.
TEST(Trial, AnExternalNodeHasSomethingNewOnceItsClockHasTicked) {
  graph::AppSpec spec = graph::spec_of({"camera", "grab"}, {"camera grab"});
  graph::node(spec, "camera").external = true;
  graph::node(spec, "camera").period = graph::At<Nanos>{milliseconds{40}, {}};
  spec.objective = {graph::response("camera grab", 1.0)};
  World world(spec, {{"grab", 6}});
  const NodeId camera = *world.app.graph.find_node("camera");
  world.costs.set_idle(*world.app.graph.find_node("grab"), {1.0, Millis{0.2}});
  const std::vector<Ticks> clocks{{at_ms(5), ms(40)}, {}};
  world.run(on_cores(1, {{.period = ms(20)}}), ms(120), clocks);
  EXPECT_EQ(world.timeline["grab"], "0-6 20-26 40-40.2 60-66 80-80.2 100-106");
  World after(spec, {{"grab", 6}});
  after.costs = world.costs;
  const Figures figures =
      after.run(on_cores(1, {{.period = ms(40), .phase = ms(1), .clock = camera}}), ms(4000), clocks);
  EXPECT_EQ(after.timeline.emitted("grab").substr(0, 8), "xxxxxxxx");
  EXPECT_NEAR(figures.terms[0].mean_ms, 40.0 + 1.0 + 6.0, 0.1);
}

// The display ticks each 10 ms, and a's outputs are there 0.02 ms before that.
TEST(Trial, WhatIsThereTooShortlyBeforeATickMissesIt) {
  graph::AppSpec spec = graph::spec_of({"a", "display"}, {"a display"});
  graph::node(spec, "display").external = true;
  graph::node(spec, "display").period = graph::At<Nanos>{milliseconds{10}, {}};
  spec.objective = {graph::response("a display", 1.0)};
  World world(spec, {{"a", 1.98}});
  const Samples samples(world.app, MeasuredRuns{}, world.costs);
  const auto response_ms = [&](Nanos before_ticks) {
    const Figures figures = Trial(world.app, samples)
                                .run(on_cores(1, {{.period = ms(10)}}), {.horizon = ms(2000),
                                                                         .warm_up = Nanos{0},
                                                                         .overheads = Overheads::none(),
                                                                         .clocks = {{}, {at_ms(2), ms(10)}},
                                                                         .before_ticks = before_ticks});
    return figures.terms.front().mean_ms;
  };
  const double in_time = response_ms(Nanos{0});
  EXPECT_NEAR(response_ms(ms(0.01)), in_time, 1e-9);
  EXPECT_NEAR(response_ms(ms(0.03)), in_time + 10.0, 1e-6);
}

// a and b are one group, on a core each: a is due at 1, while b runs.
TEST(Trial, RunsOfAnExclusiveGroupDoNotOverlap) {
  graph::AppSpec spec = two();
  spec.exclusive = {{{"group", {}}, graph::split("a b")}};
  World world(spec, {{"a", 2}, {"b", 4}});
  const Figures figures =
      world.run(on_cores(2, {{.core = 0, .period = ms(10), .phase = ms(1)}, {.core = 1, .period = ms(10)}}), ms(20));
  EXPECT_EQ(world.timeline["a"], "4-6 14-16");
  EXPECT_EQ(world.timeline["b"], "0-4 10-14");
  EXPECT_NEAR(figures.busy[0], 0.2, 1e-9) << "who waits uses nothing";
}

// On one core high and low are an exclusive group, middle is not in it. When high wants it, low goes on above middle.
TEST(Trial, WhoIsWaitedForInAnExclusiveGroupIsRaised) {
  graph::AppSpec spec = graph::spec_of({"high", "middle", "low", "end"}, {"high end", "middle end", "low end"});
  graph::node(spec, "end").external = true;
  spec.objective = {graph::response("high end", 1.0), graph::response("middle end", 1.0),
                    graph::response("low end", 1.0)};
  spec.exclusive = {{{"group", {}}, graph::split("high low")}};
  World world(spec, {{"high", 2}, {"middle", 5}, {"low", 4}});
  world.run(on_cores(1, {{.priority = 3, .period = ms(20), .phase = ms(2)},
                         {.priority = 2, .period = ms(20), .phase = ms(1)},
                         {.priority = 1, .period = ms(20)}}),
            ms(20));
  EXPECT_EQ(world.timeline["low"], "0-5");
  EXPECT_EQ(world.timeline["high"], "5-7");
  EXPECT_EQ(world.timeline["middle"], "1-11");
}

// Two wait: the higher is next, although it came later.
TEST(Trial, OfThoseThatWaitForAnExclusiveGroupTheHighestIsNext) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "c", "end"}, {"a end", "b end", "c end"});
  graph::node(spec, "end").external = true;
  spec.objective = {graph::response("a end", 1.0), graph::response("b end", 1.0), graph::response("c end", 1.0)};
  spec.exclusive = {{{"group", {}}, graph::split("a b c")}};
  World world(spec, {{"a", 2}, {"b", 3}, {"c", 8}});
  world.run(on_cores(2, {{.core = 0, .priority = 2, .period = ms(20), .phase = ms(2)},
                         {.core = 0, .priority = 1, .period = ms(20), .phase = ms(1)},
                         {.core = 1, .priority = 1, .period = ms(20)}}),
            ms(20));
  EXPECT_EQ(world.timeline["c"], "0-8");
  EXPECT_EQ(world.timeline["a"], "8-10");
  EXPECT_EQ(world.timeline["b"], "10-13");
}

TEST(Trial, UnscheduledNodesRunAboveAllAndFollowEachOther) {
  graph::AppSpec spec = graph::spec_of({"u", "v", "a"}, {"u v a"});
  graph::node(spec, "u").unscheduled = true;
  graph::node(spec, "u").period = graph::At<Nanos>{milliseconds{10}, {}};
  graph::node(spec, "v").unscheduled = true;
  spec.objective = {graph::response("u v a", 1.0)};
  World world(spec, {{"u", 1}, {"v", 2}, {"a", 5}});
  const Figures figures = world.run(on_cores(1, {{.period = ms(10), .phase = ms(8)}}), ms(30));
  EXPECT_EQ(world.timeline["u"], "10-11 20-21");
  EXPECT_EQ(world.timeline["v"], "11-13 21-23");
  EXPECT_EQ(world.timeline["a"], "8-16 18-26");
  EXPECT_NEAR(figures.busy[0], (5 + 5 + 2 + 2 * 3) / 30.0, 1e-9);
}

TEST(Trial, UnscheduledNodesPreferAnIdleCore) {
  graph::AppSpec spec = graph::spec_of({"u", "a"}, {"u a"});
  graph::node(spec, "u").unscheduled = true;
  graph::node(spec, "u").period = graph::At<Nanos>{milliseconds{10}, {}};
  spec.objective = {graph::response("u a", 1.0)};
  World world(spec, {{"u", 1}, {"a", 5}});
  world.run(on_cores(2, {{.core = 0, .period = ms(10), .phase = ms(8)}}), ms(34));
  EXPECT_EQ(world.timeline["a"], "8-13 18-23 28-33");
}

// A plan numbers priorities core by core, and levels of threads are of these numbers: b, the highest of the app, is no
// higher than a then.
TEST(Trial, PrioritiesOfOtherCoresDoNotMoveUnscheduledNodes) {
  graph::AppSpec spec = graph::spec_of({"u", "a", "b"}, {"u a", "u b"});
  graph::node(spec, "u").unscheduled = true;
  graph::node(spec, "u").period = graph::At<Nanos>{milliseconds{10}, {}};
  spec.objective = {graph::response("u a", 1.0), graph::response("u b", 1.0)};
  World world(spec, {{"u", 1}, {"a", 5}, {"b", 5}});
  Schedule schedule = on_cores(2, {{.core = 1, .priority = 1, .period = ms(10), .phase = ms(8)},
                                   {.core = 0, .priority = 2, .period = ms(10), .phase = ms(8)}});
  world.run(schedule, ms(24));
  EXPECT_EQ(world.timeline["a"], "8-13 18-23");
  EXPECT_EQ(world.timeline["b"], "8-14 18-24") << "where u, which no core ran before, begins: on core 0";
  schedule.subchains[1].priority = 1;
  World alike(spec, {{"u", 1}, {"a", 5}, {"b", 5}});
  alike.run(schedule, ms(24));
  EXPECT_EQ(alike.timeline["b"], world.timeline["b"]);
}

TEST(Trial, ATermOfTooFewSamplesCountsAsTheHorizonAndIsReported) {
  World world(two(), {{"a", 2}, {"b", 3}});
  const Figures figures = world.run(
      on_cores(1, {{.priority = 1, .period = ms(10)}, {.priority = 2, .after = plan::After{SubchainId(1), 1}}}),
      ms(1000));
  EXPECT_FALSE(figures.enough);
  EXPECT_EQ(figures.terms[0].count, 0U);
  EXPECT_EQ(figures.terms[0].mean_ms, 1000.0);
}

TEST(Trial, WhatBeginsInTheWarmUpDoesNotCount) {
  World world(two(), {{"a", 2}, {"b", 3}});
  const Samples samples(world.app, MeasuredRuns{}, world.costs);
  const Schedule schedule =
      on_cores(1, {{.priority = 1, .period = ms(10)}, {.priority = 2, .after = plan::After{SubchainId(0), 1}}});
  const Figures figures =
      Trial(world.app, samples).run(schedule, {.horizon = ms(100), .warm_up = ms(51), .overheads = Overheads::none()});
  // From the begin at 60 to the end at 145.
  EXPECT_EQ(figures.terms[0].count, 8U);
  EXPECT_EQ(figures.subchains[1].runs, 10U);
}

// a: 4 ms, b: 5 ms; slots without slack, one frame after the other.
TEST(Trial, FramesAreThoseOfTheDispatcher) {
  World world(two(), {{"a", 4}, {"b", 5}});
  Schedule schedule = on_cores(1, {{.form = Form::kFrames}, {.form = Form::kFrames}});
  dispatch::SharedCoreSchedule frames;
  frames.slots = {{.subchain = SubchainId(0), .slice = ms(6), .every = 1, .rank = 0},
                  {.subchain = SubchainId(1), .slice = ms(3), .every = 2, .rank = 1}};
  schedule.frames = {frames};
  world.run(schedule, ms(30));
  EXPECT_EQ(world.timeline["a"], "0-4 7-11 13-17 20-24 26-30");
  EXPECT_EQ(world.timeline["b"], "4-13 17-26");
}

TEST(Trial, APipelineOverlapsRunsOnItsCores) {
  graph::AppSpec spec = two();
  spec.subchains = {graph::subchain("ab", "a b")};
  World world(spec, {{"a", 4}, {"b", 6}});
  Schedule schedule = on_cores(2, {{.form = Form::kPipeline}});
  schedule.pipelines = {{SubchainId(0), {0, 1}, 1, dispatch::pacing_of_owned(Millis{6}, Millis{10}, Nanos{0})}};
  const Figures figures = world.run(schedule, ms(30));
  EXPECT_EQ(world.timeline["a"], "0-4 6-10 12-16 18-22 24-28");
  EXPECT_EQ(world.timeline["b"], "4-10 10-16 16-22 22-28");
  EXPECT_NEAR(figures.subchains[0].period_ms, 6.0, 1e-9);
}

TEST(Trial, ThreadsOfANodeShareItsRun) {
  graph::AppSpec spec = two();
  spec.subchains = {graph::subchain("ab", "a b")};
  graph::node(spec, "b").max_threads = graph::At<int>{2, {}};
  World world(spec, {{"a", 4}, {"b", 6}});
  Schedule schedule = on_cores(2, {{.form = Form::kPipeline}});
  schedule.pipelines = {{SubchainId(0), {0, 1}, 2, dispatch::pacing_of_owned(Millis{10}, Millis{7}, Nanos{0})}};
  world.run(schedule, ms(20));
  EXPECT_EQ(world.timeline["a"], "0-4 10-14");
  EXPECT_EQ(world.timeline["b"], "4-7 14-17");
}

TEST(Trial, IsTheSameEachTimeAndOtherwiseWithOtherDraws) {
  World world(two(), {});
  model::Workload work(world.app.graph);
  for (const NodeId node : {NodeId(0), NodeId(1)}) {
    work.set(node, {model::CostProfile::constant(Millis{4}), {Millis{2}}, 0.0, {0.01, Millis{5}}});
  }
  const Samples samples(world.app, work, Nanos{0}, 1);
  const Trial trial(world.app, samples);
  const Schedule schedule = on_cores(1, {{.priority = 1, .period = ms(10)}, {.priority = 2, .period = ms(12)}});
  const Figures once = trial.run(schedule, {.p95 = true});
  const Figures again = trial.run(schedule, {.p95 = true});
  const Figures otherwise = trial.run(schedule, {.first_draw = 1000, .p95 = true});
  EXPECT_EQ(once.objective, again.objective);
  EXPECT_EQ(once.terms[0].p95_ms, again.terms[0].p95_ms);
  EXPECT_EQ(once.events, again.events);
  EXPECT_NE(once.objective, otherwise.objective);
  EXPECT_NEAR(once.objective / otherwise.objective, 1.0, 0.05);
}

TEST(Trial, SchedulingTakesWhatTheOverheadsSay) {
  World world(two(), {{"a", 2}, {"b", 3}});
  const Samples samples(world.app, MeasuredRuns{}, world.costs);
  Overheads costs = Overheads::none();
  costs.timer_latency = ms(0.1);
  costs.run = ms(0.2);
  costs.context_switch = ms(0.3);
  costs.dispatch_timer = ms(0.4);
  costs.dispatch_event = ms(0.5);
  const Schedule schedule =
      on_cores(1, {{.priority = 1, .period = ms(10)}, {.priority = 2, .after = plan::After{SubchainId(0), 1}}});
  Timeline& timeline = world.timeline;
  Trial(world.app, samples)
      .run(schedule, {.horizon = ms(10), .warm_up = Nanos{0}, .overheads = costs, .observer = &timeline});
  EXPECT_EQ(timeline["a"], "0.8-3.3");  // the timer, the controller
  EXPECT_EQ(timeline["b"], "4.1-7.6");
}

TEST(Trial, WhatArrivesFromAnUnscheduledNodeTriggersAtItsEnd) {
  graph::AppSpec spec = graph::spec_of({"imu", "a"}, {"imu a"});
  graph::node(spec, "imu").unscheduled = true;
  graph::node(spec, "imu").period = graph::At<Nanos>{ms(5), {}};
  spec.objective = {graph::response("imu a", 1.0)};
  World world(spec, {{"imu", 1}, {"a", 3}});
  const NodeId imu(std::size_t{0});
  const Figures each = world.run(on_cores(2, {{.core = 1, .after = plan::After{imu, 1}}}), ms(100));
  EXPECT_EQ(world.timeline["a"].substr(0, 16), "6-9 11-14 16-19 ");
  EXPECT_NEAR(each.terms[0].mean_ms, 5.0 + 1.0 + 3.0, 1e-9);
  World again(spec, {{"imu", 1}, {"a", 3}});
  again.run(on_cores(2, {{.core = 1, .after = plan::After{imu, 2}}}), ms(40));
  EXPECT_EQ(again.timeline["a"], "11-14 21-24 31-34");
}

}  // namespace
}  // namespace ctn::trial
