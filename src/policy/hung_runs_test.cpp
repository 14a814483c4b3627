#include "policy/hung_runs.h"

#include <gtest/gtest.h>

#include <chrono>

#include "config/testing/apps.h"

namespace ctn::policy {
namespace {

using std::chrono::milliseconds;

TEST(HungRuns, OneThatHungDoesNotCountAndASecondInARowDoes) {
  const graph::App app = tracker_app();
  const auto at = [](int ms) { return TimePoint{milliseconds{ms}}; };
  const auto run = [&](int node, int begin, int end) {
    record::Run made;
    made.node = NodeId(static_cast<std::size_t>(node));
    made.begin = at(begin);
    made.end = at(end);
    return made;
  };
  HungRuns runs(app.graph);
  EXPECT_TRUE(runs.counts(run(1, 0, 10)));
  runs.began(SubchainId(0), at(1000));
  EXPECT_TRUE(runs.counts(run(0, 20, 25))) << "it was over by then";
  EXPECT_FALSE(runs.counts(run(1, 25, 3000)));
  EXPECT_TRUE(runs.counts(run(2, 3000, 3005))) << "it began after it";
  EXPECT_TRUE(runs.counts(run(1, 3010, 3020)));
  runs.began(SubchainId(0), at(5000));
  EXPECT_FALSE(runs.counts(run(1, 4000, 7000)));
  runs.began(SubchainId(0), at(8000));
  EXPECT_TRUE(runs.counts(run(1, 7000, 9000))) << "it has become that slow";
}

}  // namespace
}  // namespace ctn::policy
