#include "policy/step_cost.h"

#include <gtest/gtest.h>

#include <chrono>

#include "trial/trial.h"

namespace ctn::policy {
namespace {

// Half of the steps by a timer, half of them not.
struct Used {
  StepCost cost;
  Nanos cpu{0};
  std::uint64_t each = 0;

  void windows(int count, double factor) {
    const trial::Overheads assumed;
    const Nanos both = assumed.dispatch_timer + assumed.dispatch_event + 2 * assumed.context_switch;
    for (int i = 0; i < count; ++i) {
      cpu += Nanos{static_cast<Nanos::rep>(factor * static_cast<double>(100 * both.count()))};
      each += 100;
      cost.saw(cpu, each, each);
    }
  }
};

TEST(StepCost, IsKnownAfterSomeWindows) {
  Used used;
  used.windows(4, 3.0);
  EXPECT_EQ(used.cost.factor(), 1.0);
  used.windows(1, 3.0);
  EXPECT_NEAR(used.cost.factor(), 3.0, 1e-6);
}

TEST(StepCost, FewStepsSayNothing) {
  StepCost cost;
  for (std::uint64_t steps = 1; steps < 200; ++steps) cost.saw(std::chrono::milliseconds{100}, steps, 0);
  EXPECT_EQ(cost.factor(), 1.0);
}

TEST(StepCost, StepsByATimerAreTakenToBeLonger) {
  const trial::Overheads assumed;
  StepCost timers;
  StepCost events;
  for (std::uint64_t steps = 200; steps <= 2000; steps += 200) {
    const auto times = static_cast<Nanos::rep>(steps);
    timers.saw(times * (assumed.dispatch_timer + assumed.context_switch), steps, 0);
    events.saw(times * (assumed.dispatch_event + assumed.context_switch), 0, steps);
  }
  EXPECT_EQ(timers.factor(), 1.0);
  EXPECT_EQ(events.factor(), 1.0);
}

TEST(StepCost, StaysWhereOnlyNoiseIsSeenAndFollowsWhatLasts) {
  Used used;
  used.windows(5, 2.0);
  used.windows(2, 20.0);
  used.windows(3, 2.2);
  EXPECT_NEAR(used.cost.factor(), 2.0, 1e-6);
  used.windows(5, 3.0);
  EXPECT_NEAR(used.cost.factor(), 3.0, 1e-6);
  used.windows(5, 1.0);
  EXPECT_NEAR(used.cost.factor(), 1.0, 1e-6);
}

}  // namespace
}  // namespace ctn::policy
