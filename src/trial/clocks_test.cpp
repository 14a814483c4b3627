// Trials by hand: nodes that give or take something at the ticks of a clock of their own.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "trial/testing/world.h"

namespace ctn::trial {
namespace {

graph::AppSpec shown() {
  graph::AppSpec spec = graph::spec_of({"sensor", "a", "display"}, {"sensor a display"});
  for (const char* name : {"sensor", "display"}) graph::node(spec, name).external = true;
  graph::node(spec, "display").period = graph::At<Nanos>{ms(10), {}};
  spec.objective = {graph::response("a display", 1.0), graph::response("a", 1.0)};
  return spec;
}

TEST(TrialClocks, WhatIsDoneByATickCountsAtTheTick) {
  World world(shown(), {{"a", 2}});
  const std::vector<Ticks> clocks{{}, {}, {TimePoint{} + ms(7), ms(10)}};
  const Figures figures = world.run(on_cores(1, {{.period = ms(10), .phase = ms(1)}}), ms(100), clocks);
  EXPECT_NEAR(figures.terms[0].mean_ms, 16.0, 1e-9) << "of 1 until 17";
  EXPECT_NEAR(figures.terms[1].mean_ms, 12.0, 1e-9) << "of 1 until 13";
  const Figures in_time = world.run(on_cores(1, {{.period = ms(10), .phase = ms(5)}}), ms(100), clocks);
  EXPECT_NEAR(in_time.terms[0].mean_ms, 12.0, 1e-9);
}

TEST(TrialClocks, OfOutputsThatEndAtOneTickTheNewestCounts) {
  World world(shown(), {{"a", 1}});
  const std::vector<Ticks> clocks{{}, {}, {TimePoint{}, ms(10)}};
  const Figures figures = world.run(on_cores(1, {{.period = ms(5)}}), ms(100), clocks);
  EXPECT_NEAR(figures.terms[0].mean_ms, 15.0, 1e-9) << "of 5, 15, 25, until 20, 30, ...";
  EXPECT_EQ(figures.terms[0].count, 8U);
}

TEST(TrialClocks, WhatComesDoesSoAtTicks) {
  graph::AppSpec spec = shown();
  graph::node(spec, "sensor").period = graph::At<Nanos>{ms(20), {}};
  spec.objective = {graph::response("sensor a", 1.0), graph::response("a", 1.0)};
  World world(spec, {{"a", 2}});
  const std::vector<Ticks> clocks{{TimePoint{} + ms(1), ms(20)}, {}, {}};
  const Figures figures = world.run(on_cores(1, {{.period = ms(5), .phase = ms(3)}}), ms(200), clocks);
  EXPECT_NEAR(figures.terms[0].mean_ms, 24.0, 1e-9) << "of 1 until 25: the first run that has it";
  EXPECT_NEAR(figures.terms[1].mean_ms, 7.0, 1e-9);
}

// No schedule keeps a phase to a clock of others: whatever its own phase is, it comes to the same.
TEST(TrialClocks, UnlessToldTheySlideThroughAllPhases) {
  World world(shown(), {{"a", 2}});
  for (const double phase : {0.0, 3.0, 7.9}) {
    const Figures figures = world.run(on_cores(1, {{.period = ms(10), .phase = ms(phase)}}), ms(10'000));
    EXPECT_NEAR(figures.terms[0].mean_ms, 2.0 + 10.0 + 5.0, 0.05) << phase;
    EXPECT_NEAR(figures.terms[0].p95_ms, 2.0 + 10.0 + 9.5, 0.05) << phase;
  }
}

// Its grid slides with the clock.
TEST(TrialClocks, WhoKeepsAPhaseToAClockIsDoneJustBeforeTheTick) {
  World world(shown(), {{"a", 2}});
  Place place{.period = ms(10), .phase = ms(7)};
  place.clock = NodeId(std::size_t{2});
  const Figures figures = world.run(on_cores(1, {place}), ms(10'000));
  EXPECT_NEAR(figures.terms[0].mean_ms, 3.0 + 10.0, 0.05);
  EXPECT_NEAR(figures.terms[0].p95_ms, 3.0 + 10.0, 0.05);
  place.period = ms(20);
  World slower(shown(), {{"a", 2}});
  EXPECT_NEAR(slower.run(on_cores(1, {place}), ms(10'000)).terms[0].mean_ms, 3.0 + 20.0, 0.05);
}

}  // namespace
}  // namespace ctn::trial
