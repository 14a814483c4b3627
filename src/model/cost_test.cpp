#include "model/cost.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::model {
namespace {

TEST(CostProfile, OfModesIsTheWeightedSum) {
  const CostProfile profile = CostProfile::of_modes({{"skip", 0.8, Millis{1.0}}, {"match", 0.2, Millis{9.0}}});
  EXPECT_DOUBLE_EQ(profile.single_thread().count(), 2.6);
}

TEST(CostProfile, TakesTheLargestMeasuredNumberOfThreadsThatFits) {
  const CostProfile profile = CostProfile::of_threads({{1, Millis{10}}, {2, Millis{6}}, {4, Millis{4}}});
  EXPECT_EQ(profile.single_thread(), Millis{10});
  EXPECT_EQ(profile.with_threads(1, 8), Millis{10});
  EXPECT_EQ(profile.with_threads(2, 8), Millis{6});
  EXPECT_EQ(profile.with_threads(3, 8), Millis{6});
  EXPECT_EQ(profile.with_threads(4, 8), Millis{4});
  EXPECT_EQ(profile.with_threads(100, 8), Millis{4});
}

TEST(CostProfile, GoesByWhatWasMeasuredAndElseByPerfectScaling) {
  const CostProfile profile = CostProfile::constant(Millis{12}).with_measured({{2, Millis{9}}, {4, Millis{7}}});
  EXPECT_EQ(profile.single_thread(), Millis{12});
  EXPECT_EQ(profile.with_threads(1, 6), Millis{12});
  EXPECT_EQ(profile.with_threads(2, 6), Millis{9});
  EXPECT_EQ(profile.with_threads(3, 6), Millis{4}) << "never run";
  EXPECT_EQ(profile.with_threads(4, 6), Millis{7});
  EXPECT_EQ(profile.with_threads(8, 6), Millis{2}) << "no more than six";
  EXPECT_EQ(profile.with_threads(8, 4), Millis{7});
  EXPECT_EQ(profile.threads_used(3), 3);
  EXPECT_EQ(profile.max_useful_threads(6), 6);
  EXPECT_EQ(profile.times(2.0).with_threads(2, 6), Millis{18});
}

TEST(CostProfile, WhatIsAssumedIsSoOnAnyNumberOfThreads) {
  const CostProfile profile = CostProfile::assumed(Millis{5});
  EXPECT_EQ(profile.with_threads(8, 8), Millis{5});
  EXPECT_EQ(profile.max_useful_threads(8), 1);
  EXPECT_EQ(profile.times(0.5).with_threads(2, 8), Millis{2.5});
}

TEST(CostProfile, ItemsOfABatchAddToEachModeAndToThreadsInProportion) {
  const CostProfile modes =
      CostProfile::of_modes({{"skip", 0.75, Millis{1}}, {"match", 0.25, Millis{9}}}).with_per_item(Millis{0.5});
  EXPECT_EQ(modes.single_thread(), Millis{3}) << "without any";
  EXPECT_EQ(modes.with_items(4).single_thread(), Millis{5});
  EXPECT_EQ(modes.with_items(4).modes()[0].cost, Millis{3});
  EXPECT_EQ(modes.with_items(4).per_item(), Millis{0});
  EXPECT_EQ(modes.times(2.0).with_items(1).single_thread(), Millis{7});

  const CostProfile threads = CostProfile::of_threads({{1, Millis{10}}, {2, Millis{6}}}).with_per_item(Millis{1});
  EXPECT_EQ(threads.with_items(5).with_threads(1, 2), Millis{15});
  EXPECT_EQ(threads.with_items(5).with_threads(2, 2), Millis{9});
}

RC_GTEST_PROP(CostProfile, DividesByThreadsThatItHasNoMeasurementFor, ()) {
  const int cost = *rc::gen::inRange(0, 1'000'000);
  const int q = *rc::gen::inRange(1, 100);
  const int max_threads = *rc::gen::inRange(1, 100);
  const CostProfile profile = CostProfile::constant(Millis{cost * 1e-3});
  RC_ASSERT(profile.with_threads(q, max_threads) == profile.single_thread() / std::min(q, max_threads));
}

TEST(CostTable, ChargesAllButExternalNodes) {
  graph::AppSpec spec = graph::spec_of({"imu", "a", "b", "motor"}, {"imu a b motor"});
  node(spec, "imu").unscheduled = true;
  node(spec, "imu").period = graph::At<Nanos>{std::chrono::milliseconds{5}, {}};
  node(spec, "motor").external = true;
  spec.subchains.push_back(graph::subchain("s", "a b"));
  spec.objective.push_back(graph::response("a b motor", 1.0));
  const auto app = graph::build_app(spec);
  ASSERT_TRUE(app.ok()) << app.error().message();

  CostTable costs(app->graph, Millis{5});
  EXPECT_EQ(costs[*app->graph.find_node("imu")].single_thread(), Millis{5});
  EXPECT_EQ(costs[*app->graph.find_node("motor")].single_thread(), Millis{0});
  EXPECT_EQ(costs.subchain_total(app->graph, SubchainId{0}), Millis{10});

  costs.set(*app->graph.find_node("b"), CostProfile::constant(Millis{2}));
  EXPECT_EQ(costs.subchain_total(app->graph, SubchainId{0}), Millis{7});
}

}  // namespace
}  // namespace ctn::model
