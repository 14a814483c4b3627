#include "policy/step_cost.h"

#include <gtest/gtest.h>

#include <chrono>

namespace ctn::policy {
namespace {

using std::chrono::microseconds;

struct Used {
  StepCost cost;
  Nanos cpu{0};
  std::uint64_t steps = 0;

  void window(Nanos each) {
    cpu += 200 * each;
    cost.saw(cpu, steps += 200);
  }
  void windows(int count, Nanos each) {
    for (int i = 0; i < count; ++i) window(each);
  }
};

TEST(StepCost, IsKnownAfterSomeWindows) {
  Used used;
  used.windows(4, microseconds{40});
  EXPECT_EQ(used.cost.value(), Nanos{0});
  used.window(microseconds{40});
  EXPECT_EQ(used.cost.value(), microseconds{40});
}

TEST(StepCost, FewStepsSayNothing) {
  StepCost cost;
  for (std::uint64_t steps = 1; steps < 200; ++steps) cost.saw(microseconds{100}, steps);
  EXPECT_EQ(cost.value(), Nanos{0});
}

TEST(StepCost, StaysWhereOnlyNoiseIsSeenAndFollowsWhatLasts) {
  Used used;
  used.windows(5, microseconds{40});
  used.windows(2, microseconds{400});
  used.windows(3, microseconds{45});
  EXPECT_EQ(used.cost.value(), microseconds{40});
  used.windows(5, microseconds{60});
  EXPECT_EQ(used.cost.value(), microseconds{60});
  used.windows(5, microseconds{20});
  EXPECT_EQ(used.cost.value(), microseconds{20});
}

}  // namespace
}  // namespace ctn::policy
