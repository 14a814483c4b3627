#include "model/workload.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <vector>

#include "base/statistics.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::model {
namespace {

using std::chrono::seconds;

constexpr std::uint64_t kSeed = 7;
constexpr NodeId kNode{0};
constexpr std::uint64_t kRuns = 20'000;

graph::App app_with(int max_threads = 1) {
  graph::AppSpec spec = graph::spec_of({"a", "b"}, {"a b"});
  node(spec, "a").max_threads = graph::At<int>{max_threads, {}};
  spec.objective.push_back(graph::response("a b", 1.0));
  return *graph::build_app(spec);
}

Workload workload(NodeWork work, int max_threads = 1) {
  Workload load(app_with(max_threads).graph);
  load.set(kNode, std::move(work));
  return load;
}

NodeWork spread(double typical, double cost) {
  NodeWork work = NodeWork::constant(Millis{cost});
  work.typical = {Millis{typical}};
  return work;
}

double drawn_ms(const Workload& load, std::uint64_t number, Nanos since_start = Nanos{0}) {
  return to_millis(load.draw(kSeed, kNode, number, since_start).cpu).count();
}

std::vector<double> sample(const Workload& load) {
  std::vector<double> all;
  for (std::uint64_t number = 1; number <= kRuns; ++number) all.push_back(drawn_ms(load, number));
  std::sort(all.begin(), all.end());
  return all;
}

TEST(Workload, IsConstantWhereNoTypicalCostIsGiven) {
  const Workload load = workload(NodeWork::constant(Millis{1.25}));
  for (std::uint64_t number = 1; number < 100; ++number) {
    EXPECT_EQ(load.draw(kSeed, kNode, number, seconds{9}), (RunDraw{0, Nanos{1'250'000}}));
  }
}

TEST(Workload, WaitsAsLongOnEveryCoreAndAtAnyTime) {
  Workload load = workload(spread(2, 4));
  load.set_wait(kNode, {Millis{3}, std::nullopt});
  for (std::uint64_t number = 1; number < 100; ++number) {
    EXPECT_EQ(load.draw(kSeed, kNode, number, seconds{number}).wait, Nanos{3'000'000});
  }
  EXPECT_EQ(load.costs(app_with().graph).wait(kNode), Millis{3});
  EXPECT_EQ(load.costs(app_with().graph)[kNode].single_thread(), Millis{4});

  graph::App two_kinds = app_with();
  two_kinds.core_kinds = {{"fast", 1, 2.0}, {"slow", 1, 0.5}};
  EXPECT_EQ(load.on(two_kinds, 1).draw(kSeed, kNode, 1, Nanos{0}).wait, Nanos{3'000'000});
}

TEST(Workload, AWaitThatVariesDoesSoByItself) {
  Workload load = workload(spread(2, 4));
  const Workload without = load;
  load.set_wait(kNode, {Millis{6}, Millis{3}});
  std::vector<double> waits;
  std::uint64_t together = 0;
  for (std::uint64_t number = 1; number <= kRuns; ++number) {
    const RunDraw draw = load.draw(kSeed, kNode, number, Nanos{0});
    EXPECT_EQ(draw.cpu, without.draw(kSeed, kNode, number, Nanos{0}).cpu);
    waits.push_back(to_millis(draw.wait).count());
    together += (draw.cpu > Nanos{2'000'000}) == (draw.wait > Nanos{3'000'000}) ? 1 : 0;
  }
  std::sort(waits.begin(), waits.end());
  EXPECT_NEAR(percentile_of_sorted(waits, 50), 3.0, 0.1);
  EXPECT_NEAR(percentile_of_sorted(waits, 95), 6.0, 0.2);
  EXPECT_NEAR(static_cast<double>(together) / static_cast<double>(kRuns), 0.5, 0.02) << "independent of the cost";
}

TEST(Workload, HasTheTypicalCostAsMedianAndTheCostAs95thPercentile) {
  const std::vector<double> all = sample(workload(spread(0.8, 1.2)));
  EXPECT_NEAR(percentile_of_sorted(all, 50.0), 0.8, 0.008);
  EXPECT_NEAR(percentile_of_sorted(all, 95.0), 1.2, 0.012);
  // Log-normal: as far below the median as above it, by ratio.
  EXPECT_NEAR(percentile_of_sorted(all, 5.0), 0.8 * 0.8 / 1.2, 0.012);
}

TEST(Workload, DrawsModesByTheirProbability) {
  NodeWork work;
  work.cost = CostProfile::of_modes({{"skip", 0.8, Millis{1}}, {"never", 0.0, Millis{5}}, {"match", 0.2, Millis{9}}});
  work.typical = {std::nullopt, std::nullopt, Millis{6}};
  const Workload load = workload(work);
  std::vector<double> match;
  for (std::uint64_t number = 1; number <= kRuns; ++number) {
    const RunDraw draw = load.draw(kSeed, kNode, number, Nanos{0});
    ASSERT_NE(draw.mode, 1U);
    if (draw.mode == 2) match.push_back(to_millis(draw.cpu).count());
    if (draw.mode == 0) {
      ASSERT_EQ(draw.cpu, Nanos{1'000'000});
    }
  }
  EXPECT_NEAR(static_cast<double>(match.size()) / kRuns, 0.2, 0.012);
  std::sort(match.begin(), match.end());
  EXPECT_NEAR(percentile_of_sorted(match, 50.0), 6.0, 0.15);
  EXPECT_NEAR(percentile_of_sorted(match, 95.0), 9.0, 0.3);
}

TEST(Workload, GrowsLinearlyFromTheStart) {
  NodeWork work = spread(1.0, 2.0);
  work.growth = 0.005;
  const Workload load = workload(work);
  for (const int after : {0, 10, 100, 400}) {
    EXPECT_NEAR(drawn_ms(load, 5, seconds{after}), drawn_ms(load, 5) * (1.0 + 0.005 * after), 2e-6);
  }
}

TEST(Workload, SpikesNowAndThen) {
  NodeWork work = NodeWork::constant(Millis{1});
  work.spikes = {0.01, Millis{5}};
  const std::vector<double> all = sample(workload(work));
  EXPECT_EQ(all.front(), 1.0);
  EXPECT_EQ(all.back(), 6.0);
  const auto spikes = std::count(all.begin(), all.end(), 6.0);
  EXPECT_GT(spikes, 140);  // 200 expected, standard deviation 14
  EXPECT_LT(spikes, 260);
}

TEST(Workload, TakesLessTimeWithMoreThreads) {
  NodeWork work;
  work.cost = CostProfile::of_threads({{1, Millis{10}}, {2, Millis{6}}});
  work.typical = {Millis{5}};
  const Workload load = workload(work, 2);
  for (std::uint64_t number = 1; number < 50; ++number) {
    const auto ms = [&](int threads) {
      return to_millis(load.draw(kSeed, kNode, number, Nanos{0}, threads).cpu).count();
    };
    EXPECT_NEAR(ms(2), 0.6 * ms(1), 1e-5);
    EXPECT_EQ(ms(8), ms(2)) << "more than the node can use";
  }
  const Workload unmeasured = workload(NodeWork::constant(Millis{10}), 4);
  EXPECT_EQ(unmeasured.draw(kSeed, kNode, 1, Nanos{0}, 3).cpu, to_nanos(Millis{10.0 / 3.0}));
}

TEST(Workload, ItemsOfABatchCostTheSameInEachRun) {
  NodeWork work = spread(1.0, 2.0);
  work.cost = work.cost.with_per_item(Millis{0.5});
  work.growth = 0.1;
  const Workload load = workload(work, 2);
  for (std::uint64_t number = 1; number < 50; ++number) {
    const RunDraw draw = load.draw(kSeed, kNode, number, Nanos{0});
    EXPECT_EQ(draw.cpu_with(0), draw.cpu);
    EXPECT_EQ(draw.cpu_with(4) - draw.cpu, Nanos{2'000'000});
    EXPECT_EQ(load.draw(kSeed, kNode, number, Nanos{0}, 2).per_item, Nanos{250'000}) << "of each thread";
    EXPECT_EQ(load.draw(kSeed, kNode, number, seconds{10}).per_item, Nanos{1'000'000}) << "grown";
  }
  EXPECT_EQ(load.costs(app_with().graph)[kNode].per_item(), Millis{0.5});
  EXPECT_EQ(load.draw(kSeed, kNode, 1, Nanos{0}).cpu_with(1'000'000'000'000), to_nanos(kLongestRun));
}

TEST(Workload, IsSlowerOnSlowCores) {
  graph::AppSpec spec = graph::spec_of({"a"}, {});
  spec.core_kinds = {{{"big", {}}, {1, {}}, {1.0, {}}}, {{"little", {}}, {1, {}}, {0.5, {}}}};
  spec.objective.push_back(graph::response("a", 1.0));
  const graph::App app = *graph::build_app(spec);
  Workload load(app.graph);
  NodeWork work = spread(1.0, 2.0);
  work.spikes = {1.0, Millis{3}};
  load.set(kNode, work);
  EXPECT_EQ(load.on(app, 0)[kNode], work);
  EXPECT_EQ(load.on(app, 1)[kNode], work.times(2.0));
  EXPECT_NEAR(drawn_ms(load.on(app, 1), 3), 2.0 * drawn_ms(load, 3), 3e-6);
  load.set_on(kNode, 1, NodeWork::constant(Millis{7}));
  EXPECT_EQ(drawn_ms(load.on(app, 1), 3), 7.0);
  EXPECT_EQ(load.costs(app.graph).on(app, 1)[kNode].single_thread(), Millis{7});
}

// What was drawn once is drawn always: runs of two machines, or of two versions, can be laid side by side.
TEST(Workload, DrawsTheSameNumbersEverywhere) {
  const Workload load = workload(spread(0.8, 1.2));
  std::vector<Nanos::rep> drawn;
  for (std::uint64_t number = 1; number <= 4; ++number) {
    drawn.push_back(load.draw(kSeed, kNode, number, Nanos{0}).cpu.count());
  }
  EXPECT_EQ(drawn, (std::vector<Nanos::rep>{726664, 1047168, 820757, 690428}));
}

TEST(Workload, SeedsNodesAndRunsDrawApart) {
  Workload load = workload(spread(0.8, 1.2));
  const NodeId other{1};
  load.set(other, spread(0.8, 1.2));
  const Nanos one = load.draw(1, kNode, 1, Nanos{0}).cpu;
  EXPECT_NE(one, load.draw(2, kNode, 1, Nanos{0}).cpu);
  EXPECT_NE(one, load.draw(1, other, 1, Nanos{0}).cpu);
  EXPECT_NE(one, load.draw(1, kNode, 2, Nanos{0}).cpu);
}

RC_GTEST_PROP(Workload, DrawsAreFiniteAndNoneNegative, (std::uint64_t seed, std::uint64_t number)) {
  const double cost = *rc::gen::inRange(1, 1'000'000'000) * 1e-3;
  NodeWork work = spread(std::max(1e-6, cost * (*rc::gen::inRange(1, 1001) / 1e3)), cost);
  work.growth = *rc::gen::inRange(0, 11) * 1.0;
  work.spikes = {*rc::gen::inRange(0, 101) / 100.0, Millis{static_cast<double>(*rc::gen::inRange(0, 1'000'000))}};
  const Workload load = workload(work);
  const Nanos at = seconds{*rc::gen::inRange(0, 1'000'000)};
  const RunDraw draw = load.draw(seed, kNode, number, at);
  RC_ASSERT(draw.cpu >= Nanos{0} && draw.cpu <= to_nanos(kLongestRun));
  RC_ASSERT(draw == load.draw(seed, kNode, number, at));
  RC_ASSERT(load.draw(seed, kNode, number, at + seconds{1}).cpu >= draw.cpu);
}

}  // namespace
}  // namespace ctn::model
