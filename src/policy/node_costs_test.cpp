#include "policy/node_costs.h"

#include <gtest/gtest.h>

#include <random>

#include "config/testing/apps.h"

namespace ctn::policy {
namespace {

using std::chrono::milliseconds;

graph::App app_with_kinds() {
  return parse(R"(
catan: 1
app: one
nodes: { a: { modes: [skip, match] } }
cores: { big: { count: 1, speed: 2 }, little: { count: 2, speed: 0.5 } }
objective: [ { response_time: [a], weight: 1 } ]
)");
}

constexpr std::size_t kBig = 0;
constexpr std::size_t kLittle = 1;

class NodeCostsTest : public ::testing::Test {
 protected:
  std::optional<record::CostChange> run(int count, Nanos cpu, std::size_t kind, std::uint32_t mode = 0) {
    std::optional<record::CostChange> last;
    for (int i = 0; i < count; ++i) {
      const TimePoint end{milliseconds{100} * static_cast<int>(++number)};
      if (auto change = costs.add({NodeId(0), number, end - cpu, end, cpu, mode, true, {}, -1}, 0, kind)) last = change;
    }
    return last;
  }
  double on(std::size_t kind) const {
    model::CostTable table(app.graph, Millis{5});
    costs.put_into(table, 95.0);
    return table.on(app, kind)[NodeId(0)].single_thread().count();
  }

  const graph::App app = app_with_kinds();
  NodeCosts costs{app, NodeId(0)};
  std::uint64_t number = 0;
};

TEST_F(NodeCostsTest, AKindNotRunOnCostsByItsSpeed) {
  EXPECT_FALSE(costs.measured());
  EXPECT_DOUBLE_EQ(on(kLittle), 10.0) << "as the table had it";
  run(10, milliseconds{3}, kBig);
  EXPECT_TRUE(costs.measured());
  EXPECT_DOUBLE_EQ(on(kBig), 3.0);
  EXPECT_DOUBLE_EQ(on(kLittle), 12.0);
}

TEST_F(NodeCostsTest, AKindRunOnCostsAsMeasuredThere) {
  run(10, milliseconds{3}, kBig);
  run(10, milliseconds{8}, kLittle);
  EXPECT_DOUBLE_EQ(on(kBig), 3.0);
  EXPECT_DOUBLE_EQ(on(kLittle), 8.0);
}

TEST_F(NodeCostsTest, WhatRunsWaitIsTheSameOnAllKindsAndWhateverTheirSpeed) {
  const auto wait = [&](double percentile) {
    model::CostTable table(app.graph, Millis{5});
    costs.put_into(table, percentile);
    return table.on(app, kBig).wait(NodeId(0)) == table.on(app, kLittle).wait(NodeId(0)) ? table.wait(NodeId(0))
                                                                                         : Millis{-1};
  };
  EXPECT_EQ(wait(95.0), Millis{0});
  for (int i = 1; i <= 40; ++i) {
    const TimePoint end{milliseconds{100} * i};
    record::Run run{NodeId(0), static_cast<std::uint64_t>(i), end - milliseconds{9}, end, milliseconds{3}, 0, true, {}};
    run.wait = milliseconds{i % 3 == 0 ? 6 : 2};
    costs.add(run, 0, kLittle);
  }
  EXPECT_EQ(wait(95.0), Millis{6});
  EXPECT_EQ(wait(50.0), Millis{2});
  EXPECT_DOUBLE_EQ(on(kLittle), 3.0);
  costs.rescale(kLittle, 2.0);
  EXPECT_EQ(wait(95.0), Millis{6});
  ASSERT_EQ(costs.runs()[kLittle].size(), 200U);
  EXPECT_EQ(costs.runs()[kLittle].front().cpu, milliseconds{6});
}

TEST_F(NodeCostsTest, TheColdRunsAreForgotten) {
  run(3, milliseconds{90}, kBig);
  EXPECT_DOUBLE_EQ(on(kBig), 90.0) << "better than nothing";
  run(1, milliseconds{20}, kBig);
  EXPECT_DOUBLE_EQ(on(kBig), 20.0);
}

TEST_F(NodeCostsTest, MovingToAnotherKindIsNoChangeOfCosts) {
  EXPECT_FALSE(run(60, milliseconds{3}, kBig));
  EXPECT_FALSE(run(60, milliseconds{12}, kLittle));
  EXPECT_FALSE(run(60, milliseconds{3}, kBig));
}

TEST_F(NodeCostsTest, AChangeIsToldAndFollowedAtOnceOnAllKinds) {
  run(60, milliseconds{12}, kLittle);
  run(60, milliseconds{3}, kBig);
  const std::optional<record::CostChange> change = run(12, milliseconds{6}, kBig);
  ASSERT_TRUE(change);
  EXPECT_EQ(change->node, NodeId(0));
  EXPECT_EQ(change->core_kind, static_cast<int>(kBig));
  EXPECT_EQ(change->before, milliseconds{3});
  EXPECT_EQ(change->after, milliseconds{6});
  EXPECT_LE(change->runs, 12U);
  EXPECT_DOUBLE_EQ(on(kBig), 6.0);
  EXPECT_DOUBLE_EQ(on(kLittle), 24.0);
}

TEST_F(NodeCostsTest, ModesChangeApart) {
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(run(1, milliseconds{2}, kBig, 0));
    EXPECT_FALSE(run(1, milliseconds{10}, kBig, 1));
  }
  std::optional<record::CostChange> change;
  for (int i = 0; i < 20 && !change; ++i) {
    EXPECT_FALSE(run(1, milliseconds{2}, kBig, 0));
    change = run(1, milliseconds{5}, kBig, 1);
  }
  ASSERT_TRUE(change);
  EXPECT_EQ(change->mode, 1U);
  EXPECT_EQ(change->after, milliseconds{5});
}

TEST_F(NodeCostsTest, AnotherClockLimitScalesWhatWasSeenThere) {
  run(20, milliseconds{3}, kBig);
  run(20, milliseconds{8}, kLittle);
  costs.rescale(kBig, 2.0);
  EXPECT_DOUBLE_EQ(on(kBig), 6.0);
  EXPECT_DOUBLE_EQ(on(kLittle), 8.0);
  EXPECT_FALSE(run(60, milliseconds{6}, kBig)) << "as was to be expected";
}

TEST_F(NodeCostsTest, InvalidatedRunsAreForgottenSoon) {
  run(60, milliseconds{3}, kBig);
  costs.invalidate(kBig);
  EXPECT_DOUBLE_EQ(on(kBig), 3.0);
  EXPECT_FALSE(run(5, milliseconds{1}, kBig));
  EXPECT_DOUBLE_EQ(on(kBig), 1.0);
}

// Runs of a node of up to four threads, on cores that are all alike or of two kinds.
class NodeCostsOfThreads : public ::testing::Test {
 protected:
  // Runs that share `cpu` evenly, each with so much on top for sharing it.
  std::optional<record::CostChange> run(int count, int threads, Nanos cpu, Nanos elapsed, std::size_t kind = kBig) {
    std::optional<record::CostChange> last;
    for (int i = 0; i < count; ++i) {
      record::Run run;
      run.node = NodeId(0);
      run.number = ++number;
      run.end = TimePoint{milliseconds{100} * static_cast<int>(number)};
      run.begin = run.end - milliseconds{50};
      run.cpu = cpu;
      run.threads = threads;
      if (threads > 1) run.elapsed = elapsed;
      if (auto change = costs.add(run, 0, kind)) last = change;
    }
    return last;
  }
  double on(int threads, std::size_t kind = kBig) const {
    model::CostTable table(app.graph, Millis{5});
    costs.put_into(table, 95.0);
    return table.on(app, kind)[NodeId(0)].with_threads(threads, 4).count();
  }

  const graph::App app = parse(R"(
catan: 1
app: one
nodes: { a: { max_threads: 4 } }
cores: { big: { count: 4, speed: 2 }, little: { count: 4, speed: 0.5 } }
objective: [ { response_time: [a], weight: 1 } ]
)");
  NodeCosts costs{app, NodeId(0)};
  std::uint64_t number = 0;
};

TEST_F(NodeCostsOfThreads, OfNumbersThatHaveNotRunScalingIsAssumed) {
  run(20, 1, milliseconds{12}, {});
  EXPECT_DOUBLE_EQ(on(1), 12.0);
  EXPECT_DOUBLE_EQ(on(2), 6.0);
  EXPECT_DOUBLE_EQ(on(4), 3.0);
}

TEST_F(NodeCostsOfThreads, WhatRunsTakeOnSeveralIsAsMeasuredAndLeavesTheirCostOnOneAlone) {
  run(20, 1, milliseconds{12}, {});
  EXPECT_FALSE(run(60, 2, milliseconds{18}, milliseconds{9})) << "that they use more CPU time is no change";
  EXPECT_DOUBLE_EQ(on(1), 12.0);
  EXPECT_DOUBLE_EQ(on(2), 9.0);
  EXPECT_DOUBLE_EQ(on(3), 4.0) << "has not run";
  EXPECT_EQ(costs.count(), 77U) << "but for the cold ones";
  const std::vector<std::vector<model::RunTime>> known = costs.runs();
  for (const model::RunTime& each : known[kBig]) EXPECT_EQ(each.cpu, milliseconds{12});
}

TEST_F(NodeCostsOfThreads, TheFirstRunsOnAnotherNumberTellNothing) {
  run(20, 1, milliseconds{12}, {});
  run(3, 2, milliseconds{40}, milliseconds{30});
  run(4, 2, milliseconds{14}, milliseconds{7});
  EXPECT_DOUBLE_EQ(on(2), 6.0);
  run(1, 2, milliseconds{14}, milliseconds{7});
  EXPECT_DOUBLE_EQ(on(2), 7.0) << "without the cold ones";
}

TEST_F(NodeCostsOfThreads, CpuTimeOfSeveralStandsForOneUntilThereIsOne) {
  run(20, 4, milliseconds{20}, milliseconds{6});
  EXPECT_DOUBLE_EQ(on(1), 20.0);
  EXPECT_DOUBLE_EQ(on(4), 6.0);
  EXPECT_DOUBLE_EQ(on(2), 10.0);
  run(1, 1, milliseconds{12}, {});
  EXPECT_DOUBLE_EQ(on(1), 12.0);
  EXPECT_DOUBLE_EQ(on(4), 6.0);
  EXPECT_DOUBLE_EQ(on(2), 6.0);
}

TEST_F(NodeCostsOfThreads, AChangeScalesWhatIsKnownOfOtherNumbers) {
  run(60, 1, milliseconds{12}, {});
  run(60, 2, milliseconds{16}, milliseconds{8});
  const std::optional<record::CostChange> change = run(12, 2, milliseconds{32}, milliseconds{16});
  ASSERT_TRUE(change);
  EXPECT_EQ(change->before, milliseconds{16});
  EXPECT_EQ(change->after, milliseconds{32});
  EXPECT_DOUBLE_EQ(on(2), 16.0) << "at once";
  EXPECT_DOUBLE_EQ(on(1), 24.0);
  EXPECT_FALSE(run(60, 1, milliseconds{24}, {})) << "as was to be expected";
  ASSERT_TRUE(run(12, 1, milliseconds{12}, {}));
  EXPECT_DOUBLE_EQ(on(1), 12.0);
  EXPECT_DOUBLE_EQ(on(2), 8.0);
}

// Others that want the cores make runs longer, and their work no more.
TEST_F(NodeCostsOfThreads, LongerRunsOfTheSameCpuTimeAreNoChange) {
  run(60, 1, milliseconds{12}, {});
  run(60, 2, milliseconds{16}, milliseconds{8});
  EXPECT_FALSE(run(60, 2, milliseconds{16}, milliseconds{14}));
  EXPECT_DOUBLE_EQ(on(2), 14.0) << "but what they take";
  EXPECT_DOUBLE_EQ(on(1), 12.0);
}

TEST_F(NodeCostsOfThreads, AnotherClockLimitScalesThemAll) {
  run(20, 1, milliseconds{12}, {});
  run(20, 2, milliseconds{16}, milliseconds{8});
  costs.rescale(kBig, 2.0);
  EXPECT_DOUBLE_EQ(on(1), 24.0);
  EXPECT_DOUBLE_EQ(on(2), 16.0);
  costs.rescale(kLittle, 3.0);
  EXPECT_DOUBLE_EQ(on(2), 16.0);
}

TEST_F(NodeCostsOfThreads, OnAnotherKindTheyScaleAsWhereItWasMeasured) {
  run(20, 1, milliseconds{12}, {}, kBig);
  run(20, 2, milliseconds{16}, milliseconds{9}, kBig);
  EXPECT_DOUBLE_EQ(on(2, kLittle), 36.0) << "by speed";
  run(20, 1, milliseconds{40}, {}, kLittle);
  EXPECT_DOUBLE_EQ(on(2, kLittle), 30.0);
  EXPECT_DOUBLE_EQ(on(4, kLittle), 10.0) << "which it has run on nowhere";
}

// A queue node whose runs cost 2 ms and 0.5 ms an item, with some noise.
class NodeCostsOfBatches : public ::testing::Test {
 protected:
  std::optional<record::CostChange> run(int count, int min, int max, double fixed = 2.0, double per_item = 0.5) {
    std::optional<record::CostChange> last;
    for (int i = 0; i < count; ++i) {
      const int items = std::uniform_int_distribution(min, max)(random);
      const double noise = std::uniform_real_distribution(0.9, 1.1)(random);
      record::Run run;
      run.node = NodeId(0);
      run.number = ++number;
      run.end = TimePoint{milliseconds{100} * static_cast<int>(number)};
      run.cpu = to_nanos(Millis{fixed * noise + per_item * items});
      if (auto change = costs.add(run, static_cast<std::size_t>(items), 0)) last = change;
    }
    return last;
  }
  model::CostProfile cost(double percentile) const {
    model::CostTable table(app.graph, Millis{9});
    costs.put_into(table, percentile);
    return table[NodeId(0)];
  }

  const graph::App app = parse(R"(
catan: 1
app: one
nodes: { a: { input: queue } }
objective: [ { response_time: [a], weight: 1 } ]
)");
  NodeCosts costs{app, NodeId(0)};
  std::uint64_t number = 0;
  std::mt19937_64 random{1};
};

TEST_F(NodeCostsOfBatches, BothPartsAreEstimated) {
  EXPECT_FALSE(run(200, 1, 5));
  EXPECT_NEAR(cost(50.0).per_item().count(), 0.5, 0.02);
  EXPECT_NEAR(cost(50.0).single_thread().count(), 2.0, 0.08);
  EXPECT_NEAR(cost(95.0).single_thread().count(), 2.2, 0.08) << "the noise is of the fixed part";
  const std::vector<std::vector<model::RunTime>> known = costs.runs();
  for (const model::RunTime& each : known[0]) EXPECT_NEAR(to_millis(each.cpu).count(), 2.0, 0.3);
}

TEST_F(NodeCostsOfBatches, BatchesThatAreAllAlikeAreOnePart) {
  EXPECT_FALSE(run(200, 4, 4));
  EXPECT_EQ(cost(50.0).per_item(), Millis{0});
  EXPECT_NEAR(cost(50.0).single_thread().count(), 4.0, 0.1);
}

// A plan has made the node's period longer, before it was known what an item costs.
TEST_F(NodeCostsOfBatches, LargerBatchesAreNoLastingChange) {
  run(100, 2, 2);
  EXPECT_FALSE(run(100, 8, 8));
  EXPECT_NEAR(cost(50.0).per_item().count(), 0.5, 0.03);
  EXPECT_NEAR(cost(50.0).single_thread().count(), 2.0, 0.25);
  EXPECT_FALSE(run(100, 20, 20)) << "as was to be expected";
}

TEST_F(NodeCostsOfBatches, ALastingChangeIsToldWhateverTheBatches) {
  run(200, 1, 5);
  const std::optional<record::CostChange> change = run(40, 1, 5, 4.0);
  ASSERT_TRUE(change);
  EXPECT_NEAR(to_millis(change->before).count(), 2.2, 0.1);
  EXPECT_NEAR(to_millis(change->after).count(), 4.4, 0.2);
  run(200, 1, 5, 4.0);
  EXPECT_NEAR(cost(50.0).single_thread().count(), 4.0, 0.2);
  EXPECT_NEAR(cost(50.0).per_item().count(), 0.5, 0.05);
}

TEST_F(NodeCostsOfBatches, AnotherClockLimitScalesBothParts) {
  run(200, 1, 5);
  const model::CostProfile before = cost(95.0);
  costs.rescale(0, 2.0);
  EXPECT_NEAR(cost(95.0).per_item() / before.per_item(), 2.0, 1e-6);
  EXPECT_NEAR(cost(95.0).single_thread() / before.single_thread(), 2.0, 1e-3);
}

}  // namespace
}  // namespace ctn::policy
