#include "dispatch/slack_account.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>

namespace ctn::dispatch {
namespace {

using std::chrono::microseconds;

TEST(SlackAccount, ADebtIsDueOnceItIsWorthTheSwitches) {
  SlackAccount account;
  account.set_slack(0.2);
  account.charge(microseconds{796});
  EXPECT_EQ(account.debt_due(), Nanos{0});
  account.charge(microseconds{4});
  EXPECT_EQ(account.debt_due(), microseconds{200});
  account.pay(microseconds{150});
  EXPECT_EQ(account.debt_due(), Nanos{0});
  account.charge(microseconds{600});
  EXPECT_EQ(account.debt_due(), microseconds{200});
}

TEST(SlackAccount, WhatIsPaidBeyondTheDebtIsNotKept) {
  SlackAccount account;
  account.set_slack(0.5);
  account.pay(microseconds{1000});
  account.charge(microseconds{300});
  EXPECT_EQ(account.debt_due(), microseconds{300});
}

TEST(SlackAccount, DividesAWaitSoThatNothingIsOwedAtItsEnd) {
  SlackAccount account;
  account.set_slack(0.2);
  EXPECT_EQ(account.busy_part(microseconds{1000}), microseconds{800});
  account.charge(microseconds{2000});
  EXPECT_EQ(account.busy_part(microseconds{1000}), microseconds{400}) << "500 owed, and 100 for these 400";
  EXPECT_EQ(account.busy_part(microseconds{400}), Nanos{0}) << "more is owed than is to be waited";
}

TEST(SlackAccount, DoesNotDivideAShortWait) {
  SlackAccount account;
  account.set_slack(0.2);
  EXPECT_EQ(account.busy_part(microseconds{199}), Nanos{0});
  EXPECT_EQ(account.busy_part(microseconds{200}), microseconds{160});
}

TEST(SlackAccount, WithoutSlackNothingIsOwed) {
  SlackAccount account;
  account.charge(std::chrono::hours{1});
  EXPECT_EQ(account.debt_due(), Nanos{0});
  EXPECT_EQ(account.busy_part(microseconds{500}), microseconds{500});
  EXPECT_EQ(account.busy_part(microseconds{5}), microseconds{5});
}

// Frames that use no more than (1 - slack) T, and wait until F <= T.
RC_GTEST_PROP(SlackAccountProperty, FramesAreNoLongerThanPlannedAndOrdinaryThreadsHaveTheirPart, ()) {
  const Nanos frame = microseconds{*rc::gen::inRange(100, 20000)};
  const Nanos min = frame * *rc::gen::inRange(0, 101) / 100;
  const double slack = *rc::gen::inRange(0, 10) * 0.1;
  SlackAccount account;
  account.set_slack(slack);
  Nanos now{0};
  Nanos ordinary{0};
  for (int frames = 1; frames <= 200; ++frames) {
    const Nanos max = to_nanos(to_millis(frame) * (1.0 - slack));
    const Nanos used = max * *rc::gen::inRange(0, 101) / 100;
    account.charge(used);
    const Nanos wait = std::max(min - used, Nanos{0});
    const Nanos busy = account.busy_part(wait);
    account.charge(busy);
    const Nanos given = std::max(wait - busy, account.debt_due());
    account.pay(given);
    now += used + busy + given;
    ordinary += given;
    RC_ASSERT(now <= frame * frames + kSmallestSlack + Nanos{20 * frames});
    RC_ASSERT(to_millis(ordinary + kSmallestSlack + Nanos{20 * frames}) >= to_millis(now) * slack);
  }
}

}  // namespace
}  // namespace ctn::dispatch
