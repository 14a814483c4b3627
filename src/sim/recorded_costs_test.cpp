#include "sim/recorded_costs.h"

#include <gtest/gtest.h>

#include <set>

#include "config/testing/apps.h"

namespace ctn::sim {
namespace {

using std::chrono::milliseconds;

class RecordedCostsTest : public ::testing::Test {
 protected:
  RecordedCosts costs(RecordedCosts::Order order, std::uint64_t seed = 1, Nanos overhead = Nanos{0}) const {
    auto runs = std::make_shared<RecordedRuns>();
    runs->by_node.resize(app.graph.nodes().size());
    for (int i = 1; i <= 4; ++i) {
      runs->by_node[0].push_back({milliseconds{i}, static_cast<std::uint32_t>(i % 2), milliseconds{10 * i}});
    }
    return {app, runs, order, seed, overhead};
  }
  static Nanos cpu(RecordedCosts& costs, std::uint64_t number, int threads = 1) {
    return costs.draw(NodeId(0), number, Nanos{0}, threads, 0).cpu;
  }

  const graph::App app = tracker_app();
};

TEST_F(RecordedCostsTest, TheNthRunCostsWhatTheNthDidAndThenFromTheBeginning) {
  RecordedCosts replayed = costs(RecordedCosts::Order::kAsRecorded);
  EXPECT_EQ(cpu(replayed, 1), milliseconds{1});
  EXPECT_EQ(cpu(replayed, 4), milliseconds{4});
  EXPECT_EQ(cpu(replayed, 6), milliseconds{2});
  EXPECT_EQ(replayed.draw(NodeId(0), 3, Nanos{0}, 1, 0).mode, 1U);
  EXPECT_EQ(cpu(replayed, 4, 2), milliseconds{2}) << "two threads share the work";
}

TEST_F(RecordedCostsTest, ARunWaitsWhatItDidThere) {
  RecordedCosts replayed = costs(RecordedCosts::Order::kAsRecorded, 1, std::chrono::microseconds{100});
  EXPECT_EQ(replayed.draw(NodeId(0), 3, Nanos{0}, 2, 0).wait, milliseconds{30});
}

TEST_F(RecordedCostsTest, WhatTheMachineAddsIsNotCountedTwice) {
  RecordedCosts replayed = costs(RecordedCosts::Order::kAsRecorded, 1, std::chrono::microseconds{100});
  EXPECT_EQ(cpu(replayed, 1), std::chrono::microseconds{900});
}

TEST_F(RecordedCostsTest, DrawsDependOnSeedAndRunAlone) {
  RecordedCosts one = costs(RecordedCosts::Order::kDrawn, 1);
  RecordedCosts same = costs(RecordedCosts::Order::kDrawn, 1);
  RecordedCosts other = costs(RecordedCosts::Order::kDrawn, 2);
  std::set<Nanos> seen;
  int different = 0;
  for (std::uint64_t number = 1; number <= 100; ++number) {
    EXPECT_EQ(cpu(one, number), cpu(same, number));
    seen.insert(cpu(one, number));
    different += cpu(one, number) != cpu(other, number) ? 1 : 0;
  }
  EXPECT_EQ(seen.size(), 4U);
  EXPECT_GT(different, 50);
}

}  // namespace
}  // namespace ctn::sim
