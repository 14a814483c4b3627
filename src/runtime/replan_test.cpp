#include "runtime/replan.h"

#include <gtest/gtest.h>

namespace ctn::runtime {
namespace {

using std::chrono::seconds;

plan::Plan plan_with(double period, double execution, std::vector<int> cores = {0}) {
  plan::Plan plan;
  plan.subchains.push_back({.cores = std::move(cores),
                            .period = Millis{period},
                            .execution = Millis{execution},
                            .every = 1,
                            .share = 1.0,
                            .slice = Millis{execution},
                            .threads = 1});
  return plan;
}

TEST(WorthASwap, NotForLessThanTheThreshold) {
  EXPECT_FALSE(worth_a_swap(plan_with(100.0, 90.0), plan_with(101.9, 91.0)));
  EXPECT_FALSE(worth_a_swap(plan_with(100.0, 90.0), plan_with(98.2, 89.0)));
}

TEST(WorthASwap, ForMoreInEitherDirection) {
  EXPECT_TRUE(worth_a_swap(plan_with(100.0, 90.0), plan_with(103.0, 90.0)));
  EXPECT_TRUE(worth_a_swap(plan_with(100.0, 90.0), plan_with(97.0, 90.0)));
  EXPECT_TRUE(worth_a_swap(plan_with(100.0, 90.0), plan_with(100.0, 95.0)));
}

TEST(WorthASwap, ForOtherCores) { EXPECT_TRUE(worth_a_swap(plan_with(100.0, 90.0), plan_with(100.0, 90.0, {1}))); }

TEST(WorthASwap, NotForAZeroThatStaysZero) { EXPECT_FALSE(worth_a_swap(plan_with(1.0, 0.0), plan_with(1.0, 0.0))); }

TEST(PacingOf, GivesAHangTenTimesTheExecutionAndASecondAtLeast) {
  EXPECT_EQ(pacing_of(plan_with(400.0, 300.0).subchains[0]).hang_after, seconds{3});
  EXPECT_EQ(pacing_of(plan_with(10.0, 9.0).subchains[0]).hang_after, seconds{1});
}

TEST(ReplanClock, WaitsForTheBootstrapAndForEveryNode) {
  const TimePoint start{};
  ReplanClock clock(start, {});
  EXPECT_FALSE(clock.due(start + seconds{1}, true));
  EXPECT_FALSE(clock.due(start + seconds{3}, false)) << "a node has not run yet";
  EXPECT_TRUE(clock.due(start + seconds{3}, true));
  EXPECT_TRUE(clock.first());
  clock.made(start + seconds{3});
  EXPECT_FALSE(clock.first());
  EXPECT_FALSE(clock.due(start + seconds{3}, true));
  EXPECT_TRUE(clock.due(start + seconds{4}, true));
}

}  // namespace
}  // namespace ctn::runtime
