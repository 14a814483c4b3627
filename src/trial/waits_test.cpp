// Trials by hand: runs that wait for something, what has the core meanwhile, and what it comes to.
#include <gtest/gtest.h>

#include <string>

#include "trial/testing/world.h"

namespace ctn::trial {
namespace {

using std::chrono::milliseconds;

TEST(TrialWaits, ARunThatWaitsGivesItsCoreAway) {
  World world(two(), {{"a", 2}, {"b", 6}});
  world.wait("a", 4);
  const Figures figures =
      world.run(on_cores(1, {{.priority = 2, .period = ms(20)}, {.priority = 1, .period = ms(20)}}), ms(40));
  EXPECT_EQ(world.timeline["a"], "0-6 20-26");
  EXPECT_EQ(world.timeline["b"], "1-8 21-28");
  EXPECT_NEAR(figures.busy[0], 0.4, 1e-9) << "waits are no load";
}

TEST(TrialWaits, ARunThatHasWaitedQueuesBehindThoseAboveIt) {
  World world(two(), {{"a", 2}, {"b", 6}});
  world.wait("a", 4);
  world.run(on_cores(1, {{.priority = 1, .period = ms(20)}, {.priority = 2, .period = ms(20), .phase = ms(3)}}),
            ms(20));
  EXPECT_EQ(world.timeline["a"], "0-10");
  EXPECT_EQ(world.timeline["b"], "3-9");
}

TEST(TrialWaits, AWaitUsesNoBudget) {
  const auto b_with_budget_of_a = [](double budget) {
    World world(two(), {{"a", 4}, {"b", 6}});
    world.wait("a", 4);
    world.run(on_cores(1, {{.priority = 2, .period = ms(40), .budget = ms(budget)},
                           {.priority = 1, .period = ms(40), .phase = ms(5)}}),
              ms(40));
    return world.timeline["b"];
  };
  EXPECT_EQ(b_with_budget_of_a(4), "5-13") << "a comes back at 6, and has 2 left";
  EXPECT_EQ(b_with_budget_of_a(3), "5-12.05") << "a is demoted at 7.05";
}

TEST(TrialWaits, WhatIsTriggeredWhileARunWaitsWaitsForItsEnd) {
  World world(two(), {{"a", 2}, {"b", 1}});
  world.wait("a", 10);
  world.run(on_cores(2, {{.core = 0, .period = ms(8)}, {.core = 1, .period = ms(100)}}), ms(30));
  EXPECT_EQ(world.timeline["a"], "0-12 12-24");
}

TEST(TrialWaits, InFramesOthersHaveTheCoreWhileARunWaits) {
  World world(two(), {{"a", 4}, {"b", 4}});
  world.wait("a", 4);
  Schedule schedule = on_cores(1, {{.form = Form::kFrames}, {.form = Form::kFrames}});
  dispatch::SharedCoreSchedule frames;
  frames.slots = {{.subchain = SubchainId(0), .slice = ms(3), .every = 1, .rank = 0, .may_steal = false},
                  {.subchain = SubchainId(1), .slice = ms(4), .every = 1, .rank = 1, .may_steal = false}};
  schedule.frames = {frames};
  world.run(schedule, ms(25));
  // The run of a comes back at 6, in the slot of b, and ends in its own of the next frame: at 7.
  EXPECT_EQ(world.timeline["a"], "0-9 13-22");
  EXPECT_EQ(world.timeline["b"], "3-7 9-13 16-20");
}

TEST(TrialWaits, InAPipelineOtherNodesHaveTheCoreMeanwhile) {
  graph::AppSpec spec = two();
  spec.subchains = {graph::subchain("ab", "a b")};
  World world(spec, {{"a", 2}, {"b", 6}});
  world.wait("a", 4);
  Schedule schedule = on_cores(2, {{.form = Form::kPipeline}});
  schedule.pipelines = {{SubchainId(0), {0, 1}, 1, dispatch::pacing_of_owned(Millis{6}, Millis{12}, Nanos{0})}};
  const Figures figures = world.run(schedule, ms(30));
  EXPECT_EQ(world.timeline["a"], "0-6 6-12 12-18 18-24 24-30");
  EXPECT_EQ(world.timeline["b"], "6-12 12-18 18-24 24-30");
  EXPECT_NEAR(figures.busy[0] + figures.busy[1], (5 * 2 + 4 * 6) / 30.0, 1e-9);
}

TEST(TrialWaits, OfSeveralThreadsTheFirstWaits) {
  graph::AppSpec spec = two();
  spec.subchains = {graph::subchain("ab", "a b")};
  graph::node(spec, "b").max_threads = graph::At<int>{2, {}};
  World world(spec, {{"a", 4}, {"b", 6}});
  world.wait("b", 4);
  Schedule schedule = on_cores(2, {{.form = Form::kPipeline}});
  schedule.pipelines = {{SubchainId(0), {0, 1}, 2, dispatch::pacing_of_owned(Millis{20}, Millis{11}, Nanos{0})}};
  world.run(schedule, ms(20));
  EXPECT_EQ(world.timeline["b"], "4-11");
}

TEST(TrialWaits, AnUnscheduledNodeThatWaitsGivesItsCoreAway) {
  graph::AppSpec spec = two();
  graph::node(spec, "a").unscheduled = true;
  graph::node(spec, "a").period = graph::At<Nanos>{milliseconds{10}, {}};
  World world(spec, {{"a", 1}, {"b", 8}});
  world.wait("a", 4);
  world.run(on_cores(1, {{.period = ms(20), .phase = ms(8)}}), ms(20));
  EXPECT_EQ(world.timeline["a"], "10-15");
  EXPECT_EQ(world.timeline["b"], "8-17");
}

}  // namespace
}  // namespace ctn::trial
