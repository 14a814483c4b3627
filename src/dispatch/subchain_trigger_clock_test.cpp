// Triggers by a clock of others.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "dispatch/subchain_trigger.h"

namespace ctn::dispatch {
namespace {

Pacing to_clock(Nanos period, Nanos phase, TickCount ticks = {}) {
  return {.period = period, .max_in_flight = 1, .phase = phase, .clock = NodeId(std::size_t{3}), .ticks = ticks};
}

// As its newest tick tells of it, which is another one each time; `first`: tick 0.
Ticks told_at(TimePoint now, TimePoint first, Nanos period) {
  const TimePoint tick = Ticks{first, period}.last(now);
  return {tick, period, (tick - first) / period};
}

// When triggers are sent until `end`, with runs that take no time; `clock`: what is known of it at a time.
template <class Clock>
std::vector<TimePoint> triggers_until(SubchainTrigger& trigger, TimePoint begin, TimePoint end, const Clock& clock) {
  std::vector<TimePoint> sent;
  for (TimePoint now = begin; now < end;) {
    if (const std::optional<Ticks> ticks = clock(now)) trigger.align(now, *ticks);
    const SubchainTrigger::Decision decision = trigger.step(now, trigger.sent());
    if (decision.trigger) sent.push_back(now);
    now = std::max(now, decision.ask_at);
  }
  return sent;
}

TimePoint micros(std::int64_t value) { return TimePoint{std::chrono::microseconds{value}}; }

TEST(SubchainTriggerByClock, KeepsItsPhaseToTheTicks) {
  const Pacing pacing = to_clock(std::chrono::milliseconds{10}, std::chrono::milliseconds{4});
  SubchainTrigger trigger(TimePoint{}, pacing);
  const Ticks ticks{micros(3'000), std::chrono::milliseconds{10}};
  const auto sent =
      triggers_until(trigger, TimePoint{}, micros(40'000), [&](TimePoint) { return std::optional(ticks); });
  EXPECT_EQ(sent, (std::vector{micros(7'000), micros(17'000), micros(27'000), micros(37'000)}));
}

TEST(SubchainTriggerByClock, GoesByTheSystemsClockUntilTheOtherIsKnown) {
  const Pacing pacing = to_clock(std::chrono::milliseconds{10}, std::chrono::milliseconds{4});
  SubchainTrigger trigger(TimePoint{}, pacing);
  const Ticks ticks{micros(3'000), std::chrono::milliseconds{10}};
  const auto sent = triggers_until(trigger, TimePoint{}, micros(50'000), [&](TimePoint now) {
    return now < micros(20'000) ? std::nullopt : std::optional(ticks);
  });
  EXPECT_EQ(sent, (std::vector{micros(4'000), micros(14'000), micros(24'000), micros(37'000), micros(47'000)}))
      << "the grid changes once it is asked again, and then no sooner than half a period after the last trigger";
}

TEST(SubchainTriggerByClock, APointThatHasJustPassedOnTheNewGridIsDueAtOnce) {
  SubchainTrigger trigger(TimePoint{}, to_clock(std::chrono::milliseconds{10}, std::chrono::milliseconds{4}));
  const Ticks ticks{micros(3'000), std::chrono::milliseconds{10}};
  const auto known = [&](TimePoint) { return std::optional(ticks); };
  EXPECT_EQ(triggers_until(trigger, TimePoint{}, micros(16'900), known), (std::vector{micros(7'000)}));
  trigger.change_pacing(micros(16'950), to_clock(std::chrono::milliseconds{10}, std::chrono::microseconds{3'900}));
  EXPECT_EQ(triggers_until(trigger, micros(16'950), micros(40'000), known),
            (std::vector{micros(16'950), micros(26'900), micros(36'900)}));
}

// 200 ppm slow: 2 us a period, in a minute more than one period.
TEST(SubchainTriggerByClock, FollowsDrift) {
  const Pacing pacing = to_clock(std::chrono::milliseconds{10}, std::chrono::milliseconds{4});
  SubchainTrigger trigger(TimePoint{}, pacing);
  const Ticks ticks{micros(0), std::chrono::microseconds{10'002}};
  const auto sent =
      triggers_until(trigger, TimePoint{}, micros(60'000'000), [&](TimePoint) { return std::optional(ticks); });
  ASSERT_EQ(sent.size(), 5999U);
  for (const TimePoint at : sent) EXPECT_EQ(at - ticks.last(at), std::chrono::milliseconds{4});
}

// What is known of the clock moves by 300 us: the grid follows in steps of a 250th, 40 us.
TEST(SubchainTriggerByClock, IsCorrectedLittleByLittle) {
  const Pacing pacing = to_clock(std::chrono::milliseconds{10}, Nanos{0});
  SubchainTrigger trigger(TimePoint{}, pacing);
  const auto sent = triggers_until(trigger, TimePoint{}, micros(205'000), [&](TimePoint now) {
    return std::optional(Ticks{micros(now < micros(55'000) ? 0 : -300), std::chrono::milliseconds{10}});
  });
  ASSERT_EQ(sent.size(), 21U);
  for (std::size_t k = 1; k < sent.size(); ++k) {
    EXPECT_GE(sent[k] - sent[k - 1], std::chrono::microseconds{10'000 - 40});
    EXPECT_LE(sent[k] - sent[k - 1], std::chrono::microseconds{10'000});
  }
  EXPECT_EQ(sent[20], micros(199'700));
}

TEST(SubchainTriggerByClock, OfSeveralTicksAPeriodItKeepsToItsOwn) {
  const Pacing pacing = to_clock(std::chrono::milliseconds{30}, std::chrono::milliseconds{12}, {3, 1});
  SubchainTrigger trigger(TimePoint{}, pacing);
  const auto sent = triggers_until(trigger, TimePoint{}, micros(200'000), [](TimePoint now) {
    return std::optional(told_at(now, micros(1'000), std::chrono::milliseconds{10}));
  });
  ASSERT_GE(sent.size(), 6U);
  EXPECT_EQ(sent[0], micros(13'000));
  for (std::size_t k = 1; k < sent.size(); ++k) EXPECT_EQ(sent[k] - sent[k - 1], std::chrono::milliseconds{30});
}

// Three to five ticks: two of them that begin at any time keep their phase to the clock, and so to each other.
TEST(SubchainTriggerByClock, APeriodNeedBeNoWholeNumberOfTicks) {
  const Nanos period = std::chrono::nanoseconds{8'333'333};
  const auto sent_from = [&](TimePoint begin, Nanos phase) {
    SubchainTrigger trigger(begin, to_clock(period, phase, {5, 3}));
    return triggers_until(trigger, begin, micros(300'000), [](TimePoint now) {
      return std::optional(told_at(now, micros(1'000), std::chrono::milliseconds{5}));
    });
  };
  const auto first = sent_from(TimePoint{}, std::chrono::microseconds{200});
  const auto other = sent_from(micros(113'000), std::chrono::microseconds{700});
  ASSERT_GE(other.size(), 20U);
  for (const auto& [sent, phase] : {std::pair(first, 200), std::pair(other, 700)}) {
    for (const TimePoint at : sent) {
      const Nanos past = (at - micros(1'000 + phase)) % Nanos{8'333'333};
      EXPECT_LT(std::min(past, Nanos{8'333'333} - past), std::chrono::microseconds{1}) << "of the same ticks";
    }
  }
}

// Whatever is told of a clock, and whenever: triggers are never closer together than half a period, and the system is
// not asked to step without end.
RC_GTEST_PROP(SubchainTriggerByClockProperty, IsNeverTriggeredTooSoon, ()) {
  const int ticks_each = *rc::gen::inRange(1, 4);
  const Nanos nominal{8'333'333};
  const int parts = *rc::gen::inRange(1, 4);
  const Nanos period = ticks_each * nominal / parts;
  const Pacing pacing = to_clock(period, period / 3, {ticks_each, parts});
  SubchainTrigger trigger(TimePoint{}, pacing);
  std::optional<Ticks> known;
  const auto sent = triggers_until(trigger, TimePoint{}, micros(2'000'000), [&](TimePoint now) {
    if (*rc::gen::inRange(0, 4) == 0) {
      known = Ticks{now - Nanos{*rc::gen::inRange(0, 50'000'000)},
                    nominal + Nanos{*rc::gen::inRange(-160'000, 160'000)}, *rc::gen::inRange(0, 1000)};
    }
    return known;
  });
  RC_ASSERT(sent.size() <= 2'000'000'000U / static_cast<std::size_t>(period.count()) * 2 + 2);
  for (std::size_t k = 1; k < sent.size(); ++k) {
    RC_ASSERT(sent[k] - sent[k - 1] >= pacing.period * 48 / 100);
    RC_ASSERT(sent[k] - sent[k - 1] <= pacing.period * 2);
  }
}

}  // namespace
}  // namespace ctn::dispatch
