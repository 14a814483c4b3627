// Trials by hand: nodes that need input, and are triggered without.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "trial/testing/world.h"

namespace ctn::trial {
namespace {

// As two(), but that b needs input.
graph::AppSpec reader() {
  graph::AppSpec spec = two();
  graph::node(spec, "b").needs_input = true;
  return spec;
}

// Outputs of a at 2, 12, 22; b is due every 4 ms, and what was due meanwhile is made up for by one trigger.
TEST(TrialInputs, ARunThatIsTriggeredWithoutNewsWaitsForSome) {
  World world(reader(), {{"a", 2}, {"b", 3}});
  const Figures figures = world.run(on_cores(2, {{.core = 0, .period = ms(10)}, {.core = 1, .period = ms(4)}}), ms(31));
  EXPECT_EQ(world.timeline["b"], "2-5 12-15 22-25");
  EXPECT_NEAR(figures.subchains[1].period_ms, 10.0, 1e-9);
  EXPECT_NEAR(figures.busy[1], 9.0 / 31.0, 1e-9) << "who waits uses nothing";
}

TEST(TrialInputs, NewsThatHasComeIsTakenAtOnce) {
  World world(reader(), {{"a", 2}, {"b", 3}});
  world.run(on_cores(2, {{.core = 0, .period = ms(5)}, {.core = 1, .period = ms(10), .phase = ms(4)}}), ms(30));
  EXPECT_EQ(world.timeline["b"], "4-7 14-17 24-27");
}

TEST(TrialInputs, OutputsThatAreLeftOutAreNoNews) {
  World world(reader(), {{"a", 2}, {"b", 3}});
  world.runs_per_output("a", 2.0);
  world.run(on_cores(2, {{.core = 0, .period = ms(5)}, {.core = 1, .period = ms(4)}}), ms(30));
  EXPECT_EQ(world.timeline.emitted("a"), "x.x.x.");
  EXPECT_EQ(world.timeline["b"], "2-5 12-15 22-25");
}

// The sensor's clock ticks at 1, 21, 41.
TEST(TrialInputs, ATickOfAnExternalClockIsNews) {
  graph::AppSpec spec = graph::spec_of({"sensor", "a"}, {"sensor a"});
  graph::node(spec, "sensor").external = true;
  graph::node(spec, "sensor").period = graph::At<Nanos>{ms(20), {}};
  graph::node(spec, "a").needs_input = true;
  spec.objective = {graph::response("sensor a", 1.0)};
  World world(spec, {{"a", 2}});
  const std::vector<Ticks> clocks{{TimePoint{} + ms(1), ms(20)}, {}};
  world.run(on_cores(1, {{.period = ms(5), .phase = ms(3)}}), ms(50), clocks);
  EXPECT_EQ(world.timeline["a"], "3-5 21-23 41-43");
}

// What it may get from an external node without a clock, or from nobody, may have come at any time.
TEST(TrialInputs, WhoseInputIsNotKnownIsNotHeldBack) {
  graph::AppSpec spec = graph::spec_of({"sensor", "a", "b"}, {"sensor a"});
  graph::node(spec, "sensor").external = true;
  for (const char* name : {"a", "b"}) graph::node(spec, name).needs_input = true;
  spec.objective = {graph::response("a", 1.0), graph::response("b", 1.0)};
  World world(spec, {{"a", 2}, {"b", 2}});
  world.run(on_cores(2, {{.core = 0, .period = ms(10)}, {.core = 1, .period = ms(10)}}), ms(25));
  EXPECT_EQ(world.timeline["a"], "0-2 10-12 20-22");
  EXPECT_EQ(world.timeline["b"], "0-2 10-12 20-22");
}

// b, above c on its core and in an exclusive group with it, waits for a until 8.
TEST(TrialInputs, WhoWaitsKeepsNeitherItsCoreNorItsGroup) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "c"}, {"a b"});
  graph::node(spec, "b").needs_input = true;
  spec.exclusive = {{{"one", {}}, graph::split("b c")}};
  spec.objective = {graph::response("a b", 1.0), graph::response("c", 1.0)};
  World world(spec, {{"a", 8}, {"b", 2}, {"c", 4}});
  world.run(on_cores(2, {{.core = 1, .period = ms(20)},
                         {.core = 0, .priority = 2, .period = ms(20)},
                         {.core = 0, .priority = 1, .period = ms(20)}}),
            ms(35));
  EXPECT_EQ(world.timeline["b"], "8-10 28-30");
  EXPECT_EQ(world.timeline["c"], "0-4 20-24");
}

// In the middle of a run nothing is asked for: it waits for a device.
TEST(TrialInputs, ARunThatHasBegunGoesOnWithoutNews) {
  World world(reader(), {{"a", 2}, {"b", 2}});
  world.wait("b", 4);
  world.run(on_cores(2, {{.core = 0, .period = ms(10)}, {.core = 1, .period = ms(5)}}), ms(29));
  EXPECT_EQ(world.timeline["b"], "2-8 12-18 22-28");
}

TEST(TrialInputs, APipelineWaitsToo) {
  graph::AppSpec spec = reader();
  World world(spec, {{"a", 2}, {"b", 3}});
  Schedule schedule = on_cores(3, {{.core = 2, .period = ms(10)}, {.form = Form::kPipeline, .core = 0}});
  schedule.pipelines = {{SubchainId(1), {0, 1}, 1, dispatch::pacing_of_owned(Millis{4}, Millis{3}, Nanos{0})}};
  world.run(schedule, ms(29));
  EXPECT_EQ(world.timeline["b"], "2-5 12-15 22-25");
}

// a is triggered by b's output, and b waits for a's.
TEST(TrialInputs, WhatWaitsForItselfNeverRunsAndHasNoSamples) {
  World world(reader(), {{"a", 2}, {"b", 3}});
  const Figures figures = world.run(
      on_cores(1, {{.priority = 2, .after = plan::After{SubchainId(1), 1}}, {.priority = 1, .period = ms(10)}}),
      ms(1000));
  EXPECT_EQ(world.timeline["a"], "");
  EXPECT_EQ(world.timeline["b"], "");
  EXPECT_FALSE(figures.enough);
  EXPECT_GE(figures.objective, 1000.0) << "as bad as the whole time";
}

}  // namespace
}  // namespace ctn::trial
