#include "baselines/period_program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace ctn::baselines {
namespace {

PeriodTask task(double cost, double burst, std::vector<int> higher) {
  return {cost, burst, std::move(higher), 0.0, 1e4, 0.0};
}

LatencySum sum(std::vector<LatencySum::Part> parts, double asked = 0.0) { return {0.0, asked, std::move(parts)}; }

// One task by itself has no reason to wait: its period is its cost.
TEST(PeriodProgram, ATaskAloneRunsOneRunAfterTheOther) {
  const auto found = solve_periods({{task(3.0, 3.0, {})}, sum({{0, 1.0, 1.0, 0.0}}), {}});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->periods[0], 3.0, 1e-4);
  EXPECT_EQ(found->factor, 1.0);
}

// Two tasks, no rounding up (burst = cost): minimise a / u + b / (1 - u) for the higher at u, whose period is a / u,
// and the lower, whose response time is b / (1 - u) and whose period can be no shorter: with the same weights the sum
// is a / u + 2 b / (1 - u), least where u / (1 - u) = sqrt(a / (2 b)).
TEST(PeriodProgram, TwoTasksShareByTheSquareRootsOfTheirCosts) {
  const auto found =
      solve_periods({{task(2.0, 2.0, {}), task(4.0, 4.0, {0})}, sum({{0, 1.0, 1.0, 0.0}, {1, 1.0, 1.0, 0.0}}), {}});
  ASSERT_TRUE(found);
  const double ratio = std::sqrt(2.0 / 8.0);
  const double u = ratio / (1.0 + ratio);
  EXPECT_NEAR(found->periods[0], 2.0 / u, 1e-3);
  EXPECT_NEAR(found->periods[1], 4.0 / (1.0 - u), 1e-3);
}

TEST(PeriodProgram, CapsAndExactRatesAreKept) {
  PeriodTask capped = task(1.0, 1.0, {});
  capped.min_period = 20.0;
  PeriodTask exact = task(1.0, 2.0, {0});
  exact.exact_period = 10.0;
  const auto found =
      solve_periods({{capped, exact, task(1.0, 3.0, {0, 1})}, sum({{0, 1.0, 0.0, 0.0}, {2, 1.0, 1.0, 0.0}}), {}});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->periods[0], 20.0, 1e-3);
  EXPECT_GE(found->periods[0], 20.0);
  EXPECT_EQ(found->periods[1], 10.0);
  EXPECT_NEAR(found->periods[2], 3.0 / (1.0 - 0.05 - 0.1), 1e-3);
}

TEST(PeriodProgram, NoneWhereExactRatesTakeMoreThanTheCore) {
  PeriodTask a = task(6.0, 6.0, {});
  a.exact_period = 10.0;
  PeriodTask b = task(6.0, 6.0, {0});
  b.exact_period = 10.0;
  EXPECT_FALSE(solve_periods({{a, b}, {}, {}}));
}

// The first may take no more than 3 ms, the least that it can: the second pays.
TEST(PeriodProgram, BoundsThatCanHoldDo) {
  PeriodProgram program{{task(2.0, 2.0, {}), task(4.0, 4.0, {0})},
                        sum({{0, 1.0, 1.0, 0.0}, {1, 1.0, 1.0, 0.0}}),
                        {sum({{0, 1.0, 0.0, 0.0}}, 3.0)}};
  const auto found = solve_periods(program);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->factor, 1.0);
  EXPECT_NEAR(found->periods[0], 3.0, 1e-3);
  EXPECT_NEAR(found->periods[1], 12.0, 1e-2);
}

// 2 / t0 + 4 / t1 = 1 at best, and t0 = 3 f, t1 = 6 f: f = 4 / 3.
TEST(PeriodProgram, BoundsThatCannotHoldGiveWayByTheLeastFactor) {
  PeriodProgram program{{task(2.0, 2.0, {}), task(4.0, 4.0, {0})},
                        sum({{0, 1.0, 1.0, 0.0}, {1, 1.0, 1.0, 0.0}}),
                        {sum({{0, 1.0, 0.0, 0.0}}, 3.0), sum({{1, 1.0, 0.0, 0.0}}, 6.0)}};
  const auto found = solve_periods(program);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->factor, 4.0 / 3.0, 1e-4);
}

// It emits every 50 ms at best, so running more often than that is worth next to nothing.
TEST(PeriodProgram, NoNeedToRunMoreOftenThanItEmits) {
  PeriodProgram program{{task(2.0, 2.0, {}), task(4.0, 4.0, {0})}, sum({{0, 1.0, 0.0, 50.0}, {1, 1.0, 1.0, 0.0}}), {}};
  const auto found = solve_periods(program);
  ASSERT_TRUE(found);
  EXPECT_GT(found->periods[0], 25.0);
  EXPECT_LT(found->periods[1], 4.5);
}

}  // namespace
}  // namespace ctn::baselines
