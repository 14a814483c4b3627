// Triggers by outputs of another subchain.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/testing/times.h"
#include "base/ticks.h"
#include "dispatch/subchain_trigger.h"

namespace ctn::dispatch {
namespace {

using std::chrono::milliseconds;

Pacing after_another(int every, Nanos expected = milliseconds{10}) {
  return {.period = expected, .max_in_flight = 1, .after = plan::After{SubchainId{std::size_t{1}}, every}};
}

TEST(FollowingTrigger, ComesWithEachOutputFromThenOn) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(1));
  trigger.hear(at(Nanos{0}), 7, at(Nanos{0}));
  EXPECT_FALSE(trigger.step(at(Nanos{0}), 0).trigger) << "those before do not count";
  trigger.hear(at(milliseconds{6}), 8, at(milliseconds{5}));
  const auto decision = trigger.step(at(milliseconds{6}), 0);
  EXPECT_EQ(decision.trigger, at(milliseconds{5})) << "due when the output came";
  trigger.hear(at(milliseconds{7}), 8, at(milliseconds{5}));
  EXPECT_FALSE(trigger.step(at(milliseconds{7}), 1).trigger);
  trigger.hear(at(milliseconds{9}), 9, at(milliseconds{9}));
  EXPECT_EQ(trigger.step(at(milliseconds{9}), 1).trigger, at(milliseconds{9}));
}

TEST(FollowingTrigger, ComesWithEachSoManyThOutput) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(3));
  std::vector<int> triggered_by;
  for (int output = 0; output <= 10; ++output) {
    trigger.hear(at(milliseconds{output}), static_cast<std::uint64_t>(output), at(milliseconds{output}));
    if (trigger.step(at(milliseconds{output}), trigger.sent()).trigger) triggered_by.push_back(output);
  }
  EXPECT_THAT(triggered_by, testing::ElementsAre(3, 6, 9));
}

TEST(FollowingTrigger, OutputsDuringARunMakeOneTriggerWhenItHasEnded) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(2));
  trigger.hear(at(Nanos{0}), 0, at(Nanos{0}));
  trigger.step(at(Nanos{0}), 0);
  trigger.hear(at(milliseconds{2}), 2, at(milliseconds{2}));
  ASSERT_TRUE(trigger.step(at(milliseconds{2}), 0).trigger);
  for (int output = 3; output <= 7; ++output) {
    trigger.hear(at(milliseconds{output}), static_cast<std::uint64_t>(output), at(milliseconds{output}));
    const auto decision = trigger.step(at(milliseconds{output}), 0);
    EXPECT_FALSE(decision.trigger);
    EXPECT_EQ(decision.ask_on_completion, output >= 4);
  }
  EXPECT_EQ(trigger.step(at(milliseconds{8}), 1).trigger, at(milliseconds{4})) << "due since the first";
  trigger.hear(at(milliseconds{9}), 8, at(milliseconds{9}));
  EXPECT_EQ(trigger.step(at(milliseconds{9}), 2).trigger, at(milliseconds{9})) << "the seventh still counts";
}

TEST(FollowingTrigger, OutputsThatComeTooSoonWait) {
  Pacing pacing = after_another(1);
  pacing.shortest = milliseconds{8};
  SubchainTrigger trigger(at(Nanos{0}), pacing);
  std::vector<int> triggered_at;
  for (int time = 0; time < 30; ++time) {
    trigger.hear(at(milliseconds{time}), static_cast<std::uint64_t>(time / 5), at(milliseconds{time / 5 * 5}));
    const auto decision = trigger.step(at(milliseconds{time}), trigger.sent());
    if (decision.trigger) triggered_at.push_back(time);
    if (time == 11) {
      EXPECT_EQ(decision.ask_at, at(milliseconds{13}));
    }
  }
  EXPECT_THAT(triggered_at, testing::ElementsAre(5, 13, 21, 29));
}

// When triggers are sent until `end`. Outputs come every `apart`; a trigger is sent 20 us after it may, since threads
// take that long to wake, but one is 3 ms late.
std::vector<TimePoint> late_once(Nanos apart, Nanos shortest, TimePoint end) {
  Pacing pacing = after_another(1, apart);
  pacing.shortest = shortest;
  SubchainTrigger trigger(at(Nanos{0}), pacing);
  std::vector<TimePoint> sent;
  const auto step = [&](TimePoint now) {
    trigger.hear(now, static_cast<std::uint64_t>(now.time_since_epoch() / apart), Ticks{at(Nanos{0}), apart}.last(now));
    const auto decision = trigger.step(now, trigger.sent());
    if (decision.trigger) sent.push_back(now);
    return std::min(decision.ask_at, Ticks{at(Nanos{0}), apart}.next(now + Nanos{1}));
  };
  for (TimePoint now = at(Nanos{0}); now < end;) {
    const bool is_late = sent.size() == 10;
    now = step(now) + (is_late ? Nanos{milliseconds{3}} : Nanos{std::chrono::microseconds{20}});
  }
  return sent;
}

TEST(FollowingTrigger, ALateOneCatchesUpWithOutputsThatComeAsOftenAsItMay) {
  const Nanos apart = std::chrono::microseconds{5'006};
  const std::vector<TimePoint> sent = late_once(apart, milliseconds{5}, at(std::chrono::seconds{1}));
  ASSERT_GT(sent.size(), 190U);
  for (std::size_t k = 1; k < sent.size(); ++k) {
    EXPECT_GE(sent[k] - sent[k - 1], milliseconds{5} * 4 / 5);
    if (k < 15) continue;
    const Nanos late = sent[k] - Ticks{at(Nanos{0}), apart}.last(sent[k]);
    EXPECT_LE(late, std::chrono::microseconds{100}) << k;
  }
}

TEST(FollowingTrigger, ALateOneIsTriggeredNoMoreOftenOnAverageThanItMay) {
  const std::vector<TimePoint> sent = late_once(milliseconds{2}, milliseconds{5}, at(std::chrono::seconds{2}));
  ASSERT_GT(sent.size(), 390U);
  for (std::size_t k = 1; k < sent.size(); ++k) {
    EXPECT_GE(sent[k] - sent[k - 1], milliseconds{5} * 4 / 5);
    // From the first one on, which has come at once.
    EXPECT_GE(sent[k] - sent.front(), milliseconds{5} * static_cast<Nanos::rep>(k) - std::chrono::microseconds{100});
  }
}

// A leader that is triggered just as often as its follower may be, and of which one run takes 15 ms.
TEST(FollowingTrigger, ALateOutputDoesNotMakeTheNextTriggersLate) {
  Pacing pacing = after_another(1, milliseconds{20});
  pacing.shortest = milliseconds{20};
  SubchainTrigger trigger(at(Nanos{0}), pacing);
  trigger.hear(at(Nanos{0}), 0, at(Nanos{0}));
  std::vector<int> late;
  std::uint64_t outputs = 0;
  TimePoint newest{};
  for (int time = 1; time < 300; ++time) {
    if (time % 20 == (time / 20 == 5 ? 18 : 3)) {
      ++outputs;
      newest = at(milliseconds{time});
    }
    trigger.hear(at(milliseconds{time}), outputs, newest);
    if (trigger.step(at(milliseconds{time}), trigger.sent()).trigger) late.push_back(time % 20 - 3);
  }
  EXPECT_THAT(late, testing::ElementsAre(0, 0, 0, 0, 0, 15, 11, 7, 3, 0, 0, 0, 0, 0, 0));
}

// In half-open windows; however late it is told of outputs, and however long its runs take.
RC_GTEST_PROP(FollowingTriggerProperty, IsTriggeredOnceMoreThanItsPeriodSaysAtMost, ()) {
  const Nanos shortest = std::chrono::microseconds{*rc::gen::inRange(500, 8000)};
  Pacing pacing = after_another(1);
  pacing.shortest = shortest;
  SubchainTrigger trigger(at(Nanos{0}), pacing);
  std::vector<TimePoint> sent;
  TimePoint now{};
  TimePoint ends{};
  std::uint64_t outputs = 0;
  for (int k = 0; k < 200; ++k) {
    trigger.hear(now, outputs, now);
    if (trigger.step(now, ends <= now ? trigger.sent() : trigger.sent() - 1).trigger) {
      sent.push_back(now);
      ends = now + std::chrono::microseconds{*rc::gen::element(0, 100, 12'000)};
    }
    now += std::chrono::microseconds{*rc::gen::element(100, 300, 1000, 20'000)};
    outputs += static_cast<std::uint64_t>(*rc::gen::inRange(0, 3));
  }
  for (std::size_t first = 0; first < sent.size(); ++first) {
    for (std::size_t last = first + 1; last < sent.size(); ++last) {
      RC_ASSERT(sent[last] - sent[first] >= static_cast<Nanos::rep>(last - first - 1) * shortest);
    }
    if (first > 0) RC_ASSERT(sent[first] - sent[first - 1] >= plan::held_apart(shortest));
  }
}

TEST(FollowingTrigger, ALeaderThatHasGivenNothingYetDoesNotSilenceIt) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(1, milliseconds{200}));
  trigger.hear(at(Nanos{0}), 0, at(Nanos{0}));
  EXPECT_EQ(trigger.step(at(Nanos{0}), 0).ask_at, at(milliseconds{1000})) << "not ten periods";
  EXPECT_TRUE(trigger.step(at(milliseconds{1000}), 0).trigger);
  EXPECT_EQ(trigger.step(at(milliseconds{1001}), 1).ask_at, at(milliseconds{1200})) << "then every period";
  trigger.hear(at(milliseconds{1050}), 1, at(milliseconds{1050}));
  EXPECT_TRUE(trigger.step(at(milliseconds{1050}), 1).trigger);
  EXPECT_EQ(trigger.step(at(milliseconds{1051}), 2).ask_at, at(milliseconds{3050})) << "it has given something";
  SubchainTrigger runs(at(Nanos{0}), after_another(1, milliseconds{200}));
  runs.hear(at(Nanos{0}), 0, at(Nanos{0}), 0);
  runs.step(at(Nanos{0}), 0);
  runs.hear(at(milliseconds{1000}), 0, at(Nanos{0}), 9);
  EXPECT_TRUE(runs.step(at(milliseconds{1000}), 0).trigger);
  EXPECT_EQ(runs.step(at(milliseconds{1001}), 1).ask_at, at(milliseconds{1200})) << "the same of one that runs";
  SubchainTrigger seldom(at(Nanos{0}), after_another(1, milliseconds{3000}));
  seldom.hear(at(Nanos{0}), 0, at(Nanos{0}));
  EXPECT_EQ(seldom.step(at(Nanos{0}), 0).ask_at, at(milliseconds{3000})) << "one period";
}

TEST(FollowingTrigger, ASilentLeaderDoesNotSilenceIt) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(1, milliseconds{200}));
  trigger.hear(at(Nanos{0}), 5, at(Nanos{0}));
  EXPECT_EQ(trigger.step(at(Nanos{0}), 0).ask_at, at(milliseconds{2000})) << "ten periods";
  EXPECT_EQ(trigger.step(at(milliseconds{2000}), 0).trigger, at(milliseconds{2000}));
  const auto decision = trigger.step(at(milliseconds{2001}), 1);
  EXPECT_FALSE(decision.trigger);
  EXPECT_EQ(decision.ask_at, at(milliseconds{2200})) << "then every period";
  EXPECT_TRUE(trigger.step(at(milliseconds{2200}), 1).trigger);
  trigger.hear(at(milliseconds{2300}), 6, at(milliseconds{2300}));
  EXPECT_TRUE(trigger.step(at(milliseconds{2300}), 2).trigger) << "until there are outputs again";
  EXPECT_EQ(trigger.step(at(milliseconds{2301}), 3).ask_at, at(milliseconds{4300}));
  EXPECT_EQ(silence_limit(after_another(1, milliseconds{10})), milliseconds{1000}) << "and a second at least";
}

// A mapper that gives a map only when there are new keyframes, and there are none before the robot has got a path: ten
// periods of a second would be a robot that stands.
TEST(FollowingTrigger, ALeaderThatRunsAndGivesNothingHoldsItUpForTwoPeriods) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(4, milliseconds{1000}));
  trigger.hear(at(Nanos{0}), 1, at(Nanos{0}), 7);
  EXPECT_EQ(trigger.step(at(Nanos{0}), 0).ask_at, at(milliseconds{2000})) << "to see whether the leader has run";
  trigger.hear(at(milliseconds{2000}), 1, at(Nanos{0}), 11);
  EXPECT_EQ(trigger.step(at(milliseconds{2000}), 0).trigger, at(milliseconds{2000}));
  EXPECT_EQ(trigger.step(at(milliseconds{2001}), 1).ask_at, at(milliseconds{3000})) << "then every period";
  trigger.hear(at(milliseconds{3000}), 1, at(Nanos{0}), 12);
  EXPECT_TRUE(trigger.step(at(milliseconds{3000}), 1).trigger);
  trigger.hear(at(milliseconds{3100}), 5, at(milliseconds{3100}), 17);
  EXPECT_TRUE(trigger.step(at(milliseconds{3100}), 2).trigger);
  EXPECT_EQ(trigger.step(at(milliseconds{3101}), 3).ask_at, at(milliseconds{5100})) << "outputs again";
}

// As often as each other, so no more than one of the leader's runs ends between two triggers.
TEST(FollowingTrigger, ALeaderThatRunsOnceAPeriodAndGivesNothingIsFollowedEveryPeriod) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(1, milliseconds{10}));
  std::vector<int> triggered_at;
  for (int time = 0; time <= 1040; time += 10) {
    trigger.hear(at(milliseconds{time}), 5, at(Nanos{0}), static_cast<std::uint64_t>(5 + time / 10));
    if (trigger.step(at(milliseconds{time}), trigger.sent()).trigger) triggered_at.push_back(time);
  }
  EXPECT_THAT(triggered_at, testing::ElementsAre(1000, 1010, 1020, 1030, 1040));
}

// Neither has what is promised to those below it, which the leader of a follower above them waits for too.
TEST(FollowingTrigger, ALeaderThatDoesNotRunHoldsItUpForTenPeriods) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(1, milliseconds{1000}));
  trigger.hear(at(Nanos{0}), 5, at(Nanos{0}), 5);
  trigger.step(at(Nanos{0}), 0);
  for (int second = 2; second < 10; ++second) {
    // The end of the run whose output came before may be seen after that.
    trigger.hear(at(milliseconds{1000 * second}), 5, at(Nanos{0}), 6);
    const auto decision = trigger.step(at(milliseconds{1000 * second}), 0);
    EXPECT_FALSE(decision.trigger) << second;
    EXPECT_EQ(decision.ask_at, at(milliseconds{1000 * second + 125})) << "it looks eight times a period";
  }
  trigger.hear(at(milliseconds{10000}), 5, at(Nanos{0}), 6);
  EXPECT_TRUE(trigger.step(at(milliseconds{10000}), 0).trigger);
  EXPECT_EQ(trigger.step(at(milliseconds{10001}), 1).ask_at, at(milliseconds{11000})) << "then every period";
}

// It gives nothing twice, and then does not run: what is below the follower, and the leader too, is under way.
TEST(FollowingTrigger, ALeaderThatNoLongerRunsAfterGivingNothingHoldsItUpAgain) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(1, milliseconds{1000}));
  trigger.hear(at(Nanos{0}), 5, at(Nanos{0}), 5);
  trigger.step(at(Nanos{0}), 0);
  trigger.hear(at(milliseconds{2000}), 5, at(Nanos{0}), 7);
  ASSERT_TRUE(trigger.step(at(milliseconds{2000}), 0).trigger);
  for (int second = 3; second < 12; ++second) {
    trigger.hear(at(milliseconds{1000 * second}), 5, at(Nanos{0}), 7);
    EXPECT_FALSE(trigger.step(at(milliseconds{1000 * second}), 1).trigger) << second;
  }
  trigger.hear(at(milliseconds{12000}), 5, at(Nanos{0}), 7);
  EXPECT_TRUE(trigger.step(at(milliseconds{12000}), 1).trigger);
}

TEST(FollowingTrigger, ALeaderThatRunsOftenAndGivesSeldomIsWaitedForForASecond) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(1, milliseconds{20}));
  for (int time = 0; time < 900; time += 20) {
    trigger.hear(at(milliseconds{time}), 5, at(Nanos{0}), static_cast<std::uint64_t>(5 + time / 20));
    EXPECT_FALSE(trigger.step(at(milliseconds{time}), 0).trigger);
  }
}

// Plans that lead it by one and by another, each for less than a leader may be silent.
TEST(FollowingTrigger, AChangeOfLeadersDoesNotPutItOff) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(1, milliseconds{200}));
  std::vector<int> triggered_at;
  for (int time = 0; time <= 2400; time += 100) {
    if (time % 500 == 0) {
      Pacing other = after_another(1, milliseconds{200});
      other.after->leader = SubchainId{static_cast<std::size_t>(1 + time / 500 % 2)};
      trigger.change_pacing(at(milliseconds{time}), other);
    }
    trigger.hear(at(milliseconds{time}), 5, at(Nanos{0}));
    if (trigger.step(at(milliseconds{time}), trigger.sent()).trigger) triggered_at.push_back(time);
  }
  EXPECT_THAT(triggered_at, testing::ElementsAre(2000, 2200, 2400));
}

TEST(FollowingTrigger, AFloodOfOutputsDoesNotTriggerItMoreOftenThanItMay) {
  Pacing pacing = after_another(1);
  pacing.shortest = milliseconds{4};
  SubchainTrigger trigger(at(Nanos{0}), pacing);
  trigger.hear(at(Nanos{0}), 0, at(Nanos{0}));
  trigger.step(at(Nanos{0}), 0);
  trigger.hear(at(milliseconds{1}), 1, at(milliseconds{1}));
  ASSERT_TRUE(trigger.step(at(milliseconds{1}), 0).trigger);
  trigger.hear(at(milliseconds{2}), 2, at(milliseconds{2}));
  const auto decision = trigger.step(at(milliseconds{2}), 1);
  EXPECT_FALSE(decision.trigger);
  EXPECT_EQ(decision.ask_at, at(milliseconds{5}));
  trigger.hear(at(milliseconds{5}), 900, at(milliseconds{5}));
  EXPECT_EQ(trigger.step(at(milliseconds{5}), 1).trigger, at(milliseconds{2})) << "due since it came";
  pacing.shortest = Nanos{0};
  trigger.change_pacing(at(milliseconds{6}), pacing);
  trigger.hear(at(milliseconds{6}), 901, at(milliseconds{6}));
  ASSERT_TRUE(trigger.step(at(milliseconds{6}), 2).trigger);
  trigger.hear(at(milliseconds{6}), 902, at(milliseconds{6}));
  EXPECT_EQ(trigger.step(at(milliseconds{6}), 3).ask_at, at(milliseconds{6}) + kShortestPeriod);
}

TEST(FollowingTrigger, ACountThatGoesBackBeginsAnew) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(1));
  trigger.hear(at(Nanos{0}), 100, at(Nanos{0}));
  trigger.hear(at(milliseconds{1}), 3, at(milliseconds{1}));
  EXPECT_FALSE(trigger.step(at(milliseconds{1}), 0).trigger);
  trigger.hear(at(milliseconds{2}), 4, at(std::chrono::hours{24}));
  EXPECT_EQ(trigger.step(at(milliseconds{2}), 0).trigger, at(milliseconds{2})) << "never due in the future";
}

TEST(FollowingTrigger, AnotherLeadersOutputsCountFromTheChangeOn) {
  SubchainTrigger trigger(at(Nanos{0}), after_another(1));
  trigger.hear(at(Nanos{0}), 5, at(Nanos{0}));
  trigger.hear(at(milliseconds{1}), 6, at(milliseconds{1}));
  Pacing other = after_another(1);
  other.after->leader = SubchainId{std::size_t{2}};
  trigger.change_pacing(at(milliseconds{2}), other);
  trigger.hear(at(milliseconds{2}), 900, at(milliseconds{1}));
  EXPECT_FALSE(trigger.step(at(milliseconds{2}), 0).trigger);
  trigger.hear(at(milliseconds{3}), 901, at(milliseconds{3}));
  EXPECT_TRUE(trigger.step(at(milliseconds{3}), 0).trigger);
}

RC_GTEST_PROP(FollowingTriggerProperty, ATriggerForEachSoManyOutputsOrOneForThoseOfARun, ()) {
  const int every = *rc::gen::inRange(1, 4);
  SubchainTrigger trigger(at(Nanos{0}), after_another(every));
  auto outputs = static_cast<std::uint64_t>(every);
  std::uint64_t owed_from = outputs;  // outputs up to here are answered
  trigger.hear(at(Nanos{0}), outputs, at(Nanos{0}));
  trigger.step(at(Nanos{0}), 0);
  TimePoint now{};
  TimePoint ends{};
  bool owed = false;
  for (int k = 0; k < 100; ++k) {
    now += milliseconds{*rc::gen::inRange(1, 8)};
    outputs += static_cast<std::uint64_t>(*rc::gen::inRange(0, 3));
    const bool free = ends <= now;
    trigger.hear(now, outputs, now);
    const auto decision = trigger.step(now, free ? trigger.sent() : trigger.sent() - 1);
    if (outputs - owed_from >= static_cast<std::uint64_t>(every)) {
      owed = true;
      owed_from = outputs - outputs % static_cast<std::uint64_t>(every);
    }
    RC_ASSERT(decision.trigger.has_value() == (owed && free));
    if (!decision.trigger) continue;
    owed = false;
    ends = now + milliseconds{*rc::gen::inRange(0, 30)};
  }
}

}  // namespace
}  // namespace ctn::dispatch
