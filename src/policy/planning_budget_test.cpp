#include "policy/planning_budget.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <vector>

#include "base/testing/times.h"

namespace ctn::policy {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Urgency = PlanningBudget::Urgency;

TEST(PlanningBudget, APlanOf120MillisecondsIsMadeEvery24Seconds) {
  PlanningBudget budget;
  EXPECT_TRUE(budget.allows(at(seconds{2}), Urgency::kRoutine));
  budget.spend(at(seconds{2}), milliseconds{120});
  EXPECT_FALSE(budget.allows(at(milliseconds{25'900}), Urgency::kRoutine));
  EXPECT_TRUE(budget.allows(at(seconds{26}), Urgency::kRoutine));
}

TEST(PlanningBudget, APlanOfAMillisecondIsMadeWheneverItIsDue) {
  PlanningBudget budget;
  for (int second = 1; second < 100; ++second) {
    ASSERT_TRUE(budget.allows(at(seconds{second}), Urgency::kRoutine)) << second;
    budget.spend(at(seconds{second}), milliseconds{1});
  }
  EXPECT_EQ(budget.spent(), milliseconds{99});
  EXPECT_EQ(budget.plans(), 99U);
}

TEST(PlanningBudget, AChangeNeedNotWaitForThePlanBefore) {
  PlanningBudget budget;
  budget.spend(at(seconds{2}), milliseconds{120});
  EXPECT_TRUE(budget.allows(at(seconds{3}), Urgency::kChange));
  budget.spend(at(seconds{3}), milliseconds{120});
  EXPECT_FALSE(budget.allows(at(seconds{4}), Urgency::kChange)) << "but for the one before that";
  EXPECT_TRUE(budget.allows(at(seconds{27}), Urgency::kChange));
}

TEST(PlanningBudget, WhatCannotWaitIsPaidBackAfterwards) {
  PlanningBudget budget;
  for (int i = 0; i < 5; ++i) budget.spend(at(seconds{1}), milliseconds{10});
  EXPECT_FALSE(budget.allows(at(milliseconds{8'900}), Urgency::kChange));
  EXPECT_TRUE(budget.allows(at(seconds{9}), Urgency::kChange));
  EXPECT_FALSE(budget.allows(at(milliseconds{10'900}), Urgency::kRoutine));
  EXPECT_TRUE(budget.allows(at(seconds{11}), Urgency::kRoutine));
}

TEST(PlanningBudget, ASearchUsesWhatIsSavedAtOnceAndNoMoreInAnyMinute) {
  PlanningBudget budget(kSavedForSearch);
  Nanos first_second{0};
  Nanos first_minute{0};
  for (Nanos now{0}; now < seconds{60}; now += milliseconds{50}) {
    if (!budget.allows(at(now), Urgency::kRoutine)) continue;
    budget.spend(at(now), milliseconds{10});
    first_minute += milliseconds{10};
    if (now < seconds{1}) first_second += milliseconds{10};
  }
  EXPECT_GE(first_second, kSavedForSearch);
  EXPECT_LE(first_minute, kPlanningShare * seconds{60} + milliseconds{10});
  // A minute later it is saved again, and no more than that.
  Nanos later{0};
  while (budget.allows(at(seconds{200}), Urgency::kRoutine)) {
    budget.spend(at(seconds{200}), milliseconds{10});
    later += milliseconds{10};
  }
  EXPECT_EQ(later, kSavedForSearch + milliseconds{10});
}

struct Spent {
  TimePoint at;
  Nanos cpu;
};

// Whatever is asked for when: between any two instants no more is used than the share of the time and two plans.
RC_GTEST_PROP(PlanningBudget, UsesItsShareAndTwoPlansAtMost, ()) {
  PlanningBudget budget;
  std::vector<Spent> spent;
  Nanos most_expensive{0};
  TimePoint now{};
  const int asked = *rc::gen::inRange(1, 200);
  for (int i = 0; i < asked; ++i) {
    now += milliseconds{*rc::gen::inRange(0, 3000)};
    const Urgency urgency = *rc::gen::element(Urgency::kRoutine, Urgency::kChange);
    if (!budget.allows(now, urgency)) continue;
    const Nanos cpu{*rc::gen::inRange(0, 50'000'000)};
    budget.spend(now, cpu);
    spent.push_back({now, cpu});
    most_expensive = std::max(most_expensive, cpu);
  }
  for (std::size_t from = 0; from < spent.size(); ++from) {
    Nanos used{0};
    for (std::size_t to = from; to < spent.size(); ++to) {
      used += spent[to].cpu;
      const double share = kPlanningShare * static_cast<double>((spent[to].at - spent[from].at).count());
      RC_ASSERT(static_cast<double>(used.count()) <=
                share + 2.0 * static_cast<double>(most_expensive.count()) + 1000.0);
    }
  }
}

// As much as possible is made of it: a loop that always asks uses all of the share.
RC_GTEST_PROP(PlanningBudget, LeavesNothingUnused, ()) {
  PlanningBudget budget;
  const Nanos cpu{*rc::gen::inRange(5'000'000, 50'000'000)};
  TimePoint now{};
  for (; now < at(seconds{1000}); now += milliseconds{50}) {
    if (budget.allows(now, Urgency::kRoutine)) budget.spend(now, cpu);
  }
  const auto max = kPlanningShare * static_cast<double>(now.time_since_epoch().count());
  RC_ASSERT(static_cast<double>(budget.spent().count()) >= 0.95 * max);
}

}  // namespace
}  // namespace ctn::policy
