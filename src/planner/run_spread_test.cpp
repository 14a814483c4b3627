#include "planner/run_spread.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "model/workload.h"

namespace ctn::planner {
namespace {

using ::testing::DoubleNear;
using ::testing::Each;

constexpr double kRounding = 1e-9;

// Half of them are so much shorter than the mean, half so much longer.
RunSpread halves(double apart_from_mean) {
  std::vector<double> runs(RunSpread::kParts, 10.0 - apart_from_mean);
  std::fill(runs.begin() + RunSpread::kParts / 2, runs.end(), 10.0 + apart_from_mean);
  return RunSpread(std::move(runs));
}

TEST(RunSpread, PartsAreToTheMeanFromTheShortestOn) {
  std::vector<double> runs(2 * RunSpread::kParts);
  std::iota(runs.rbegin(), runs.rend(), 1.0);  // the longest first
  const RunSpread spread(std::move(runs));
  for (std::size_t part = 0; part < RunSpread::kParts; ++part) {
    EXPECT_NEAR(spread.parts()[part], -15.0 + 2.0 * static_cast<double>(part), kRounding) << part;
  }
}

// Two nodes in a row, of which the second takes 1 ms or 7.
TEST(RunSpread, IsOfWhatTheNodesOfARunDrawTogether) {
  graph::AppSpec spec = graph::spec_of({"a", "b"}, {"a b"});
  spec.subchains = {graph::subchain("ab", "a b")};
  spec.objective = {graph::response("a b", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  model::Workload work(app.graph);
  work.set(NodeId(0), model::NodeWork::constant(Millis{3.0}));
  model::NodeWork now_and_then = model::NodeWork::constant(Millis{1.0});
  now_and_then.spikes = model::Spikes{0.25, Millis{6.0}};
  work.set(NodeId(1), now_and_then);
  const trial::Samples samples(app, work, Nanos{0}, 1);
  const RunSpread spread = RunSpread::of(app.graph.subchain(SubchainId(0)), samples, 0);
  EXPECT_NEAR(spread.parts().front(), -1.5, 0.4) << "of a mean of 5.5 ms";
  EXPECT_NEAR(spread.parts().back() - spread.parts().front(), 6.0, kRounding);
  EXPECT_NEAR(std::accumulate(spread.parts().begin(), spread.parts().end(), 0.0), 0.0, kRounding);

  work.set(NodeId(1), model::NodeWork::constant(Millis{1.0}));
  const trial::Samples constant(app, work, Nanos{0}, 1);
  EXPECT_THAT(RunSpread::of(app.graph.subchain(SubchainId(0)), constant, 0).parts(), Each(DoubleNear(0.0, kRounding)));
}

TEST(RunSpread, OfTheTriggersDuringARunOneIsMadeUpFor) {
  const RunSpread even = halves(0.0);
  EXPECT_EQ(even.lost_triggers({.mean = 10.0}, 10.0), 0.0);
  EXPECT_EQ(even.lost_triggers({.mean = 15.0}, 10.0), 0.0);
  EXPECT_NEAR(even.lost_triggers({.mean = 35.0}, 10.0), 2.0, kRounding);
}

TEST(RunSpread, OnlyLongRunsLoseTriggers) {
  // As long as the triggers are apart, on average: half of the runs take 2 ms, half take 18.
  EXPECT_NEAR(halves(8.0).lost_triggers({.mean = 10.0}, 10.0), (1.8 - 1.5) / 2.0, kRounding);
  EXPECT_EQ(halves(4.0).lost_triggers({.mean = 10.0}, 10.0), 0.0);
}

TEST(RunSpread, WhatPreemptsARunAndWhatItWaitsForMakeItLonger) {
  const RunSpread spread = halves(8.0);
  EXPECT_NEAR(spread.lost_triggers({.mean = 10.0, .stretch = 1.5}, 10.0), (2.7 - 1.5) / 2.0, kRounding);
  EXPECT_NEAR(spread.lost_triggers({.mean = 10.0, .waits = 5.0}, 10.0), (2.3 - 1.5) / 2.0, kRounding);
}

TEST(RunSpread, MoreThanOneInputIsOfNoUse) {
  EXPECT_EQ(RunSpread::part_with_input(0.25), 0.25);
  EXPECT_EQ(RunSpread::part_with_input(3.0), 1.0);
  EXPECT_GT(RunSpread::part_with_input(0.0), 0.0) << "a period over it is long, and no infinity";
}

// An input each 10 ms; a run begins 2 ms after the one before.
TEST(RunSpread, WhatComesDuringLongRunsMakesUpForNoneDuringShortOnes) {
  const auto items = [](double more) { return (2.0 + 10.0 + more) / 10.0; };
  EXPECT_NEAR(halves(0.0).part_with_input(items), 1.0, 1e-6);
  EXPECT_NEAR(halves(8.0).part_with_input(items), (0.4 + 1.0) / 2.0, 1e-6) << "in 4 ms or in 20";
  EXPECT_GT(halves(0.0).part_with_input([](double) { return 0.0; }), 0.0);
}

}  // namespace
}  // namespace ctn::planner
