#include "runtime/wake_budget.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace ctn::runtime {
namespace {

using namespace std::chrono_literals;

TEST(WakeBudget, IgnoresWakesOnceABurstIsUsedUp) {
  WakeBudget budget;
  const TimePoint now{1s};
  for (int wake = 0; wake < WakeBudget::kBurst; ++wake) EXPECT_TRUE(budget.take(now));
  EXPECT_FALSE(budget.take(now));
  EXPECT_EQ(budget.ignored_wakes(), 1U);
  EXPECT_TRUE(budget.take(now + WakeBudget::kRefill));
  EXPECT_FALSE(budget.take(now + WakeBudget::kRefill));
}

TEST(WakeBudget, TimersCostNothing) {
  WakeBudget budget;
  for (int wake = 0; wake < 10 * WakeBudget::kBurst; ++wake) {
    EXPECT_TRUE(budget.take(TimePoint{1s}));
    budget.refund();
  }
}

RC_GTEST_PROP(WakeBudgetProperty, NeverLetsMoreThroughThanItEarns, ()) {
  const auto steps = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 300));
  WakeBudget budget;
  const TimePoint start{1s};
  TimePoint now = start;
  std::int64_t taken = 0;
  for (const int step : steps) {
    now += step * 1us;
    if (budget.take(now)) ++taken;
  }
  RC_ASSERT(taken <= WakeBudget::kBurst + (now - start) / WakeBudget::kRefill + 1);
}

}  // namespace
}  // namespace ctn::runtime
