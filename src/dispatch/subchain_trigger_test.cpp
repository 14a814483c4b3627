#include "dispatch/subchain_trigger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

#include "base/testing/times.h"

namespace ctn::dispatch {
namespace {

using std::chrono::milliseconds;

// Runs the state machine in virtual time. Every run ends `durations[k]` after its trigger (the last repeats); runs end
// in order.
struct Driver {
  explicit Driver(const Pacing& pacing, std::vector<Nanos> run_durations)
      : trigger(at(Nanos{0}), pacing), durations(std::move(run_durations)) {}

  void run_until(TimePoint end) {
    while (now <= end) {
      const SubchainTrigger::Decision decision = trigger.step(now, completed);
      hangs += decision.hang_began ? 1 : 0;
      recoveries += decision.hang_ended ? 1 : 0;
      if (decision.trigger) {
        due.push_back(*decision.trigger);
        sent.push_back(now);
        const std::size_t index = std::min(sent.size(), durations.size()) - 1;
        const TimePoint ends = std::max(now + durations[index], ending.empty() ? now : ending.back());
        ending.push_back(ends);
        max_under_way = std::max(max_under_way, ending.size());
        continue;
      }
      TimePoint next = decision.ask_at;
      if (!ending.empty()) next = std::min(next, std::max(now, ending.front()));
      const bool run_ends_now = !ending.empty() && ending.front() <= now;
      ASSERT_TRUE(next > now || run_ends_now) << "the state machine asks for the present again and again";
      now = next;
      while (!ending.empty() && ending.front() <= now) {
        ending.pop_front();
        ++completed;
      }
    }
  }

  SubchainTrigger trigger;
  std::vector<Nanos> durations;
  TimePoint now{};
  std::uint64_t completed = 0;
  std::deque<TimePoint> ending;
  std::vector<TimePoint> due;
  std::vector<TimePoint> sent;
  std::size_t max_under_way = 0;
  int hangs = 0;
  int recoveries = 0;
};

TEST(PacingOfOwned, OneCoreNeverOverlaps) {
  // On one core L = sum c and p = L / (1 - slack), so L < p.
  EXPECT_EQ(pacing_of_owned(Millis{88.0}, Millis{83.0}, Nanos{0}).max_in_flight, 1);
  EXPECT_EQ(pacing_of_owned(Millis{83.0}, Millis{83.0}, Nanos{0}).max_in_flight, 1);
}

TEST(PacingOfOwned, OverlapsAsManyRunsAsARunIsPeriodsLong) {
  EXPECT_EQ(pacing_of_owned(Millis{61.0}, Millis{83.0}, Nanos{0}).max_in_flight, 2);
  EXPECT_EQ(pacing_of_owned(Millis{20.0}, Millis{83.0}, Nanos{0}).max_in_flight, 5);
  EXPECT_EQ(pacing_of_owned(Millis{10.0}, Millis{0.0}, Nanos{0}).max_in_flight, 1);
}

TEST(PacingOfOwned, NodesThatCostNothingDoNotSpin) {
  EXPECT_EQ(pacing_of_owned(Millis{0.0}, Millis{0.0}, Nanos{0}).period, kShortestPeriod);
  EXPECT_EQ(pacing_of_owned(Millis{0.0}, Millis{0.0}, Nanos{0}).max_in_flight, 1);
}

TEST(SubchainTrigger, KeepsToTheGridWhileRunsAreShort) {
  Driver driver({milliseconds{10}, 1, Nanos{0}}, {milliseconds{9}});
  driver.run_until(at(milliseconds{50}));
  ASSERT_EQ(driver.sent.size(), 6U);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(driver.sent[k], at(milliseconds{10} * k));
}

TEST(SubchainTrigger, DelaysTheNextRunInsteadOfOverlappingIt) {
  Driver driver({milliseconds{10}, 1, Nanos{0}}, {milliseconds{13}, milliseconds{5}});
  driver.run_until(at(milliseconds{30}));
  ASSERT_EQ(driver.sent.size(), 4U);
  EXPECT_EQ(driver.sent[1], at(milliseconds{13})) << "as soon as the long run has ended";
  EXPECT_EQ(driver.sent[2], at(milliseconds{20})) << "back on the grid";
  EXPECT_EQ(driver.max_under_way, 1U);
}

TEST(SubchainTrigger, RestartsTheGridWhenAWholePeriodLate) {
  Driver driver({milliseconds{10}, 1, Nanos{0}}, {milliseconds{34}, milliseconds{5}});
  driver.run_until(at(milliseconds{50}));
  ASSERT_GE(driver.sent.size(), 3U);
  EXPECT_EQ(driver.sent[1], at(milliseconds{34}));
  EXPECT_EQ(driver.sent[2], at(milliseconds{44})) << "missed triggers are not made up for";
}

TEST(SubchainTrigger, UngatedTriggersWhateverTheRunsDo) {
  Driver driver({milliseconds{10}, 0, Nanos{0}}, {milliseconds{95}});
  driver.run_until(at(milliseconds{40}));
  EXPECT_EQ(driver.sent.size(), 5U);
}

TEST(SubchainTrigger, ReportsAHangOnceAndItsEndOnce) {
  Driver driver({milliseconds{10}, 1, milliseconds{100}}, {milliseconds{250}, milliseconds{5}});
  driver.run_until(at(milliseconds{90}));
  EXPECT_EQ(driver.hangs, 0);
  driver.run_until(at(milliseconds{200}));
  EXPECT_EQ(driver.hangs, 1);
  EXPECT_EQ(driver.recoveries, 0);
  driver.run_until(at(milliseconds{400}));
  EXPECT_EQ(driver.hangs, 1);
  EXPECT_EQ(driver.recoveries, 1);
  EXPECT_GT(driver.sent.size(), 10U) << "triggers resume";
}

TEST(SubchainTrigger, AnIdleSubchainNeverHangs) {
  Driver driver({milliseconds{500}, 1, milliseconds{100}}, {milliseconds{1}});
  driver.run_until(at(milliseconds{5000}));
  EXPECT_EQ(driver.hangs, 0);
}

// The process was stopped while a run was under way: it had no chance to see its end.
TEST(SubchainTrigger, WatchesRunsAgainAfterAStandstill) {
  SubchainTrigger trigger(at(Nanos{0}), {milliseconds{10}, 1, milliseconds{500}});
  ASSERT_TRUE(trigger.step(at(Nanos{0}), 0).trigger);
  const SubchainTrigger::Decision late = trigger.step(at(milliseconds{1000}), 0);
  EXPECT_FALSE(late.hang_began);
  EXPECT_EQ(late.ask_at, at(milliseconds{1500}));
  EXPECT_TRUE(trigger.step(at(milliseconds{1500}), 0).hang_began) << "one that does hang is found";
}

TEST(SubchainTrigger, ChangedPacingCountsFromTheLastTrigger) {
  SubchainTrigger trigger(at(Nanos{0}), {milliseconds{100}, 1, Nanos{0}});
  ASSERT_TRUE(trigger.step(at(Nanos{0}), 0).trigger);
  trigger.change_pacing(at(milliseconds{20}), {milliseconds{50}, 1, Nanos{0}});
  EXPECT_EQ(trigger.step(at(milliseconds{20}), 1).ask_at, at(milliseconds{50}));
  trigger.change_pacing(at(milliseconds{30}), {milliseconds{10}, 1, Nanos{0}});
  EXPECT_TRUE(trigger.step(at(milliseconds{30}), 1).trigger) << "that has passed: now";
}

// Its period is how long it may take at worst.
TEST(SubchainTrigger, AnElasticOneIsNotSilentForAPeriodWhereItsPacingChanges) {
  Pacing pacing{.period = milliseconds{600}, .max_in_flight = 1, .after_completion = milliseconds{4}};
  SubchainTrigger trigger(at(Nanos{0}), pacing);
  ASSERT_TRUE(trigger.step(at(Nanos{0}), 0).trigger);
  ASSERT_EQ(trigger.step(at(milliseconds{10}), 1).ask_at, at(milliseconds{14}));
  pacing.period = milliseconds{700};
  trigger.change_pacing(at(milliseconds{12}), pacing);
  EXPECT_EQ(trigger.step(at(milliseconds{12}), 1).ask_at, at(milliseconds{14}));
  pacing.after_completion = milliseconds{7};
  trigger.change_pacing(at(milliseconds{13}), pacing);
  EXPECT_EQ(trigger.step(at(milliseconds{13}), 1).ask_at, at(milliseconds{17}));
  pacing.after_completion = milliseconds{1};
  trigger.change_pacing(at(milliseconds{15}), pacing);
  ASSERT_TRUE(trigger.step(at(milliseconds{15}), 1).trigger) << "that has passed: now";
  trigger.change_pacing(at(milliseconds{16}), pacing);
  EXPECT_FALSE(trigger.step(at(milliseconds{16}), 1).trigger) << "a run is under way";
  EXPECT_EQ(trigger.step(at(milliseconds{30}), 2).ask_at, at(milliseconds{31}));
  trigger.change_pacing(at(milliseconds{30}), {milliseconds{50}, 1, Nanos{0}});
  EXPECT_EQ(trigger.step(at(milliseconds{30}), 2).ask_at, at(milliseconds{65})) << "by period, from the last trigger";
  EXPECT_EQ(first_due(pacing, at(milliseconds{31}), at(milliseconds{15})), at(milliseconds{31}))
      << "nor where another controller takes it over";
}

TEST(SubchainTrigger, APipelineIsPacedByItsOutput) {
  // Planned: a run a 20 ms, each 30 ms long. Two triggers after a run has ended come 2 x 20 - 30 ms later.
  const Pacing pacing = elastic_pacing_of_owned(Millis{20}, Millis{30}, Nanos{0}, milliseconds{12});
  ASSERT_EQ(pacing.max_in_flight, 2);
  ASSERT_EQ(pacing.after_completion, milliseconds{10});
  SubchainTrigger trigger(at(Nanos{0}), pacing);
  ASSERT_TRUE(trigger.step(at(milliseconds{0}), 0).trigger);
  ASSERT_TRUE(trigger.step(at(milliseconds{20}), 0).trigger) << "a period later, for nothing has ended";
  const auto decision = trigger.step(at(milliseconds{24}), 1);
  EXPECT_FALSE(decision.trigger);
  EXPECT_EQ(decision.ask_at, at(milliseconds{34})) << "the run was short, so it goes faster";
  EXPECT_TRUE(decision.ask_on_completion);
  ASSERT_TRUE(trigger.step(at(milliseconds{34}), 1).trigger);
  EXPECT_EQ(trigger.step(at(milliseconds{35}), 2).ask_at, at(milliseconds{46})) << "but not below the shortest period";
}

TEST(SubchainTrigger, OnOneCoreAnElasticRunIsFollowedByItsIdleTime) {
  const Pacing pacing = elastic_pacing_of_owned(Millis{40}, Millis{30}, Nanos{0}, Nanos{0});
  ASSERT_EQ(pacing.max_in_flight, 1);
  Driver driver(pacing, {milliseconds{20}, milliseconds{50}, milliseconds{30}});
  driver.run_until(at(milliseconds{150}));
  EXPECT_THAT(driver.sent, testing::ElementsAre(at(milliseconds{0}), at(milliseconds{30}), at(milliseconds{90}),
                                                at(milliseconds{130})))
      << "10 ms after each run's end, however long it was";
}

// --- By phase ---

Pacing phased(Nanos period, Nanos phase) { return {.period = period, .max_in_flight = 1, .phase = phase}; }

TEST(PhasedTrigger, ComesAtItsPhaseOfTheClockWheneverItBegins) {
  for (const int begin : {0, 3, 4, 13}) {
    SubchainTrigger trigger(at(milliseconds{begin}), phased(milliseconds{10}, milliseconds{4}));
    const TimePoint first = at(milliseconds{begin <= 4 ? 4 : 14});
    if (first > at(milliseconds{begin})) {
      const auto decision = trigger.step(at(milliseconds{begin}), 0);
      EXPECT_FALSE(decision.trigger);
      EXPECT_EQ(decision.ask_at, first);
    }
    const auto decision = trigger.step(first, 0);
    EXPECT_EQ(decision.trigger, first);
    EXPECT_EQ(trigger.step(first + milliseconds{1}, 1).ask_at, first + milliseconds{10});
  }
}

TEST(PhasedTrigger, ALateOneDoesNotShiftTheGrid) {
  SubchainTrigger trigger(at(Nanos{0}), phased(milliseconds{10}, milliseconds{4}));
  EXPECT_EQ(trigger.step(at(milliseconds{9}), 0).trigger, at(milliseconds{4}));
  EXPECT_EQ(trigger.step(at(milliseconds{10}), 1).ask_at, at(milliseconds{14}));
}

TEST(PhasedTrigger, WhatCameDueDuringARunIsMadeUpForByOneTrigger) {
  Driver driver(phased(milliseconds{10}, milliseconds{0}), {milliseconds{34}, milliseconds{13}, milliseconds{2}});
  driver.run_until(at(milliseconds{70}));
  EXPECT_THAT(driver.sent, testing::ElementsAre(at(milliseconds{0}), at(milliseconds{34}), at(milliseconds{47}),
                                                at(milliseconds{50}), at(milliseconds{60}), at(milliseconds{70})));
  EXPECT_THAT(driver.due, testing::ElementsAre(at(milliseconds{0}), at(milliseconds{10}), at(milliseconds{40}),
                                               at(milliseconds{50}), at(milliseconds{60}), at(milliseconds{70})))
      << "due since the first of them";
}

TEST(PhasedTrigger, AChangedGridHoldsFromItsPointNearestToAPeriodOn) {
  const auto next_after_change = [](Nanos period, Nanos phase, Nanos when) {
    SubchainTrigger trigger(at(Nanos{0}), phased(milliseconds{10}, Nanos{0}));
    EXPECT_TRUE(trigger.step(at(Nanos{0}), 0).trigger);
    trigger.change_pacing(at(when), phased(period, phase));
    return trigger.step(at(when), 1).ask_at;
  };
  EXPECT_EQ(next_after_change(milliseconds{10}, milliseconds{0}, milliseconds{3}), at(milliseconds{10}));
  EXPECT_EQ(next_after_change(milliseconds{10}, milliseconds{5}, milliseconds{3}), at(milliseconds{5}));
  EXPECT_EQ(next_after_change(milliseconds{10}, milliseconds{4}, milliseconds{3}), at(milliseconds{14}));
  EXPECT_EQ(next_after_change(milliseconds{10}, milliseconds{6}, milliseconds{7}), at(milliseconds{16})) << "is past";
  EXPECT_EQ(next_after_change(milliseconds{40}, milliseconds{0}, milliseconds{3}), at(milliseconds{40}));
}

TEST(PhasedTrigger, APointThatHasJustPassedOnTheNewGridIsDueAtOnce) {
  SubchainTrigger trigger(at(Nanos{0}), phased(milliseconds{10}, Nanos{0}));
  ASSERT_TRUE(trigger.step(at(Nanos{0}), 0).trigger);
  const TimePoint now = at(std::chrono::microseconds{9'900});
  trigger.change_pacing(now, phased(milliseconds{10}, std::chrono::microseconds{9'600}));
  EXPECT_EQ(trigger.step(now, 1).trigger, at(std::chrono::microseconds{9'600}));
  EXPECT_EQ(trigger.step(now, 2).ask_at, at(std::chrono::microseconds{19'600}));
}

TEST(PhasedTrigger, WhatIsOwedIsNotForgottenInAChange) {
  SubchainTrigger trigger(at(Nanos{0}), phased(milliseconds{10}, Nanos{0}));
  ASSERT_TRUE(trigger.step(at(Nanos{0}), 0).trigger);
  ASSERT_TRUE(trigger.step(at(milliseconds{10}), 0).ask_on_completion);
  trigger.change_pacing(at(milliseconds{12}), phased(milliseconds{10}, milliseconds{5}));
  EXPECT_TRUE(trigger.step(at(milliseconds{12}), 0).ask_on_completion);
  EXPECT_EQ(trigger.step(at(milliseconds{13}), 1).trigger, at(milliseconds{10}));
  EXPECT_EQ(trigger.step(at(milliseconds{14}), 2).ask_at, at(milliseconds{15}));
}

TEST(PhasedTrigger, WhoComesFromAnotherControllerKeepsItsDistance) {
  const Pacing pacing = phased(milliseconds{10}, milliseconds{4});
  EXPECT_EQ(first_due(pacing, at(milliseconds{21}), at(milliseconds{20})), at(milliseconds{34}));
  EXPECT_EQ(first_due(pacing, at(milliseconds{21}), at(milliseconds{19})), at(milliseconds{24}));
  EXPECT_EQ(first_due(pacing, at(milliseconds{95}), at(milliseconds{19})), at(milliseconds{104}));
  EXPECT_EQ(first_due(pacing, at(milliseconds{1}), std::nullopt), at(milliseconds{4}));
}

// --- The budget of a run ---

Pacing limited(Nanos budget) { return {.period = milliseconds{100}, .max_in_flight = 1, .budget = budget}; }

TEST(Budget, IsLookedAtWhenItCouldBeUsedUpAndNotBefore) {
  SubchainTrigger trigger(at(Nanos{0}), limited(milliseconds{10}));
  EXPECT_EQ(trigger.step(at(Nanos{0}), 0).ask_at, at(milliseconds{10}));
  EXPECT_FALSE(trigger.wants_cpu_time(at(milliseconds{9}), 0));
  ASSERT_TRUE(trigger.wants_cpu_time(at(milliseconds{10}), 0));
  trigger.used(at(milliseconds{10}), milliseconds{4});
  auto decision = trigger.step(at(milliseconds{10}), 0);
  EXPECT_FALSE(decision.demote);
  EXPECT_EQ(decision.ask_at, at(milliseconds{16})) << "the rest";
  ASSERT_TRUE(trigger.wants_cpu_time(at(milliseconds{16}), 0));
  trigger.used(at(milliseconds{16}), milliseconds{10});
  decision = trigger.step(at(milliseconds{16}), 0);
  EXPECT_FALSE(decision.demote) << "not more than its budget";
  EXPECT_EQ(decision.ask_at, at(milliseconds{16}) + kBudgetGrain);
  trigger.used(decision.ask_at, milliseconds{10} + kBudgetGrain);
  decision = trigger.step(decision.ask_at, 0);
  EXPECT_TRUE(decision.demote);
  EXPECT_TRUE(trigger.demoted());
  EXPECT_EQ(decision.ask_at, at(milliseconds{100})) << "nothing more to look at";
}

// Looks are above all levels: those at a run that waits come out of the time of what it waits for.
TEST(Budget, ARunThatDoesNotGetOnIsLookedAtLessAndLessOften) {
  const Nanos used = milliseconds{10} - microseconds{5};
  SubchainTrigger trigger(at(Nanos{0}), limited(milliseconds{10}));
  TimePoint now = trigger.step(at(Nanos{0}), 0).ask_at;
  const auto look = [&](Nanos cpu) {
    trigger.used(now, cpu);
    const auto decision = trigger.step(now, 0);
    EXPECT_FALSE(decision.demote);
    const Nanos until = decision.ask_at - now;
    now = decision.ask_at;
    return until;
  };
  EXPECT_EQ(look(used), microseconds{50});
  EXPECT_EQ(look(used), microseconds{100});
  EXPECT_EQ(look(used), microseconds{200});
  EXPECT_EQ(look(used), microseconds{400});
  EXPECT_EQ(look(used), microseconds{800});
  EXPECT_EQ(look(used), milliseconds{1}) << "it would be noticed no later when it goes on for so long";
  EXPECT_EQ(look(used), milliseconds{1});
  EXPECT_EQ(look(used + microseconds{1}), microseconds{50}) << "it gets on";
}

TEST(Budget, AShortOneIsLookedAtWithinAnEighthOfIt) {
  SubchainTrigger trigger(at(Nanos{0}), limited(milliseconds{2}));
  TimePoint now = trigger.step(at(Nanos{0}), 0).ask_at;
  for (int looks = 0; looks < 10; ++looks) {
    trigger.used(now, milliseconds{2});
    const auto decision = trigger.step(now, 0);
    EXPECT_LE(decision.ask_at - now, microseconds{250});
    now = decision.ask_at;
  }
  EXPECT_EQ(longest_budget_grain(microseconds{80}), kBudgetGrain);
}

TEST(Budget, ARunThatEndedInTimeIsNotLookedAt) {
  SubchainTrigger trigger(at(Nanos{0}), limited(milliseconds{10}));
  trigger.step(at(Nanos{0}), 0);
  EXPECT_FALSE(trigger.wants_cpu_time(at(milliseconds{10}), 1));
  EXPECT_EQ(trigger.step(at(milliseconds{10}), 1).ask_at, at(milliseconds{100}));
}

TEST(Budget, ADemotedSubchainIsRestoredWithItsNextTrigger) {
  SubchainTrigger trigger(at(Nanos{0}), limited(milliseconds{10}));
  trigger.step(at(Nanos{0}), 0);
  trigger.used(at(milliseconds{10}), milliseconds{11});
  ASSERT_TRUE(trigger.step(at(milliseconds{10}), 0).demote);
  const auto ended = trigger.step(at(milliseconds{30}), 1);
  EXPECT_FALSE(ended.restore);
  EXPECT_TRUE(trigger.demoted());
  const auto next = trigger.step(at(milliseconds{100}), 1);
  EXPECT_TRUE(next.trigger);
  EXPECT_TRUE(next.restore);
  EXPECT_FALSE(trigger.demoted());
  EXPECT_EQ(next.ask_at, at(milliseconds{110})) << "the next run has a budget of its own";
}

// A run of 40 ms, with 10 ms every 100 ms: promised to those below it is just that.
TEST(Budget, ARunThatGoesOnHasItAgainWheneverATriggerIsDue) {
  SubchainTrigger trigger(at(Nanos{0}), limited(milliseconds{10}));
  trigger.step(at(Nanos{0}), 0);
  for (int period = 0; period < 3; ++period) {
    const Nanos due = milliseconds{100 * period};
    const TimePoint spent = at(due + milliseconds{15});
    ASSERT_TRUE(trigger.wants_cpu_time(spent, 0));
    trigger.used(spent, milliseconds{11 * (period + 1)});
    const auto demoted = trigger.step(spent, 0);
    EXPECT_TRUE(demoted.demote);
    const TimePoint next = at(due + milliseconds{100});
    EXPECT_EQ(demoted.ask_at, next);
    EXPECT_FALSE(trigger.wants_cpu_time(next - Nanos{1}, 0));
    ASSERT_TRUE(trigger.wants_cpu_time(next, 0));
    trigger.used(next, milliseconds{11 * (period + 1)});
    const auto restored = trigger.step(next, 0);
    EXPECT_TRUE(restored.restore);
    EXPECT_FALSE(restored.trigger);
    EXPECT_FALSE(restored.demote);
    EXPECT_EQ(restored.ask_at, next + milliseconds{10});
  }
  const auto ended = trigger.step(at(milliseconds{305}), 1);
  EXPECT_FALSE(ended.trigger) << "it had a budget in place of one";
  EXPECT_EQ(ended.ask_at, at(milliseconds{400}));
}

TEST(Budget, WhoIsDemotedAfterItsNextTriggerWasDueWaitsForTheOneAfter) {
  SubchainTrigger trigger(at(Nanos{0}), limited(milliseconds{10}));
  trigger.step(at(Nanos{0}), 0);
  trigger.used(at(milliseconds{120}), milliseconds{11});
  const auto demoted = trigger.step(at(milliseconds{120}), 0);
  EXPECT_TRUE(demoted.demote);
  EXPECT_EQ(demoted.ask_at, at(milliseconds{200}));
  EXPECT_FALSE(trigger.step(at(milliseconds{150}), 1).trigger) << "that would be a budget at once";
  EXPECT_TRUE(trigger.step(at(milliseconds{200}), 1).trigger);
}

TEST(Budget, ARunThatHangsIsNotDemotedAndOneThatIsDemotedMayHang) {
  Pacing pacing = limited(milliseconds{10});
  pacing.hang_after = milliseconds{50};
  SubchainTrigger trigger(at(Nanos{0}), pacing);
  trigger.step(at(Nanos{0}), 0);
  trigger.used(at(milliseconds{10}), milliseconds{11});
  ASSERT_TRUE(trigger.step(at(milliseconds{10}), 0).demote);
  EXPECT_TRUE(trigger.step(at(milliseconds{50}), 0).hang_began);
  EXPECT_FALSE(trigger.wants_cpu_time(at(milliseconds{60}), 0));
  const auto ended = trigger.step(at(milliseconds{70}), 1);
  EXPECT_TRUE(ended.hang_ended);
  EXPECT_FALSE(trigger.demoted()) << "the end of a hang restores the level";
}

TEST(Budget, ANewOneHoldsForTheRunUnderWay) {
  SubchainTrigger trigger(at(Nanos{0}), limited(milliseconds{10}));
  trigger.step(at(Nanos{0}), 0);
  trigger.change_pacing(at(milliseconds{3}), limited(milliseconds{2}));
  ASSERT_TRUE(trigger.wants_cpu_time(at(milliseconds{3}), 0));
  trigger.used(at(milliseconds{3}), milliseconds{3});
  EXPECT_TRUE(trigger.step(at(milliseconds{3}), 0).demote);
  trigger.change_pacing(at(milliseconds{4}), limited(Nanos{0}));
  EXPECT_FALSE(trigger.demoted()) << "without a budget nobody is";
}

RC_GTEST_PROP(PhasedTriggerProperty, KeepsToItsGridWhateverTheRunsTake, ()) {
  const Nanos period = milliseconds{*rc::gen::inRange(1, 50)};
  const Nanos phase = *rc::gen::inRange<Nanos::rep>(0, period.count()) * Nanos{1};
  std::vector<Nanos> durations;
  for (const int ms : *rc::gen::nonEmpty(rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 120)))) {
    durations.emplace_back(milliseconds{ms});
  }
  Driver driver(phased(period, phase), durations);
  driver.run_until(at(milliseconds{2000}));
  RC_ASSERT(driver.max_under_way <= 1U);
  for (std::size_t k = 0; k < driver.sent.size(); ++k) {
    RC_ASSERT((driver.due[k].time_since_epoch() - phase) % period == Nanos{0});
    RC_ASSERT(driver.sent[k] >= driver.due[k]);
    if (k == 0) continue;
    RC_ASSERT(driver.due[k] > driver.sent[k - 1]);  // one trigger for all that came due before
    // At its due time, or as soon as the run before has ended.
    const TimePoint ended = driver.sent[k - 1] + durations[std::min(k, durations.size()) - 1];
    RC_ASSERT(driver.sent[k] == std::max(driver.due[k], ended));
    // No point of the grid is left out.
    RC_ASSERT(driver.due[k] - driver.sent[k - 1] <= period);
  }
}

RC_GTEST_PROP(BudgetProperty, DemotedOnceMoreIsUsedAndNeverBefore, ()) {
  const Nanos budget = std::chrono::microseconds{*rc::gen::inRange(100, 5000)};
  SubchainTrigger trigger(at(Nanos{0}), {.period = std::chrono::seconds{10}, .max_in_flight = 1, .budget = budget});
  TimePoint now{};
  Nanos used{0};
  int looks = 0;
  int pre_emptions = 0;
  Nanos waited{0};  // since it got on last
  Nanos over{0};    // that it may use beyond its budget, for so long it had waited
  auto decision = trigger.step(now, 0);
  while (!decision.demote) {
    const Nanos asked = decision.ask_at - now;
    RC_ASSERT(asked > Nanos{0});
    // It runs for some of the time until then, all of it where nobody pre-empts it.
    const bool pre_empted = *rc::gen::arbitrary<bool>() && pre_emptions < 50;
    pre_emptions += pre_empted ? 1 : 0;
    const Nanos got = pre_empted ? asked * *rc::gen::inRange(0, 3) / 5 : asked;
    used += got;
    if (got > Nanos{0}) over = std::exchange(waited, Nanos{0});
    if (got == Nanos{0}) waited += asked;
    now = decision.ask_at;
    RC_ASSERT(trigger.wants_cpu_time(now, 0));
    trigger.used(now, used);
    decision = trigger.step(now, 0);
    RC_ASSERT(decision.demote == (used > budget));
    ++looks;
  }
  RC_ASSERT(used <= budget + kBudgetGrain + over);
  RC_ASSERT(used <= budget + longest_budget_grain(budget));
  RC_ASSERT(looks <= pre_emptions + 2);
}

Pacing arbitrary_pacing() {
  if (*rc::gen::arbitrary<bool>()) {
    const Millis period(*rc::gen::inRange(1, 50));
    return elastic_pacing_of_owned(period, Millis(*rc::gen::inRange(0, 150)), Nanos{0}, Nanos{0});
  }
  return {.period = milliseconds{*rc::gen::inRange(1, 50)},
          .max_in_flight = *rc::gen::inRange(0, 4),
          .hang_after = milliseconds{*rc::gen::inRange(0, 200)}};
}

std::vector<Nanos> arbitrary_durations() {
  std::vector<Nanos> durations;
  for (const int ms : *rc::gen::nonEmpty(rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 120)))) {
    durations.emplace_back(milliseconds{ms});
  }
  return durations;
}

RC_GTEST_PROP(SubchainTriggerProperty, NeverMoreRunsUnderWayThanTheLimit, ()) {
  const Pacing pacing = arbitrary_pacing();
  Driver driver(pacing, arbitrary_durations());
  driver.run_until(at(milliseconds{2000}));
  if (pacing.max_in_flight > 0) {
    RC_ASSERT(driver.max_under_way <= static_cast<std::size_t>(pacing.max_in_flight));
  }
}

RC_GTEST_PROP(SubchainTriggerProperty, NeverTriggersBeforeItIsDueNorTwiceForOneDueTime, ()) {
  Driver driver(arbitrary_pacing(), arbitrary_durations());
  driver.run_until(at(milliseconds{2000}));
  for (std::size_t k = 0; k < driver.sent.size(); ++k) {
    RC_ASSERT(driver.sent[k] >= driver.due[k]);
    if (k > 0) RC_ASSERT(driver.due[k] > driver.due[k - 1]);
  }
}

// Nor does one with another budget, or that may take longer where its own output says when triggers are due.
RC_GTEST_PROP(SubchainTriggerProperty, APacingThatSaysTheSameChangesNothing, ()) {
  Pacing pacing = arbitrary_pacing();
  const bool overlaps = pacing.after_completion > Nanos{0} && pacing.max_in_flight > 1;
  RC_PRE(!overlaps);
  if (*rc::gen::arbitrary<bool>() && pacing.after_completion == Nanos{0}) pacing.phase = milliseconds{3};
  const std::vector<Nanos> durations = arbitrary_durations();
  Driver undisturbed(pacing, durations);
  undisturbed.run_until(at(milliseconds{2000}));
  Driver disturbed(pacing, durations);
  for (int change = 0; change < 20; ++change) {
    const TimePoint when = disturbed.now + milliseconds{*rc::gen::inRange(1, 90)};
    disturbed.run_until(when);
    if (pacing.after_completion > Nanos{0}) pacing.period += milliseconds{*rc::gen::inRange(0, 50)};
    disturbed.trigger.change_pacing(std::min(disturbed.now, when), pacing);
  }
  disturbed.run_until(at(milliseconds{2000}));
  const std::size_t both = std::min(disturbed.sent.size(), undisturbed.sent.size());
  RC_ASSERT(both > 0U);
  disturbed.sent.resize(both);
  undisturbed.sent.resize(both);
  RC_ASSERT(disturbed.sent == undisturbed.sent);
}

RC_GTEST_PROP(SubchainTriggerProperty, NeverIdlesLongerThanAPeriodPastACompletion, ()) {
  const Pacing pacing = arbitrary_pacing();
  const std::vector<Nanos> durations = arbitrary_durations();
  Driver driver(pacing, durations);
  driver.run_until(at(milliseconds{2000}));
  const Nanos longest = *std::max_element(durations.begin(), durations.end());
  for (std::size_t k = 1; k < driver.sent.size(); ++k) {
    RC_ASSERT(driver.sent[k] - driver.sent[k - 1] <= std::max(pacing.period, longest) + pacing.period);
  }
}

}  // namespace
}  // namespace ctn::dispatch
