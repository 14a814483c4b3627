#include "dispatch/subchain_trigger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <deque>
#include <vector>

namespace ctn::dispatch {
namespace {

using std::chrono::milliseconds;

TimePoint at(Nanos offset) { return TimePoint{} + offset; }

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
