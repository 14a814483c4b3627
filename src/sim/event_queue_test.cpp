#include "sim/event_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace ctn::sim {
namespace {

TimePoint at(int nanos) { return TimePoint{Nanos{nanos}}; }

TEST(EventQueue, GivesTheEarliestAndOfEqualsTheLowestSource) {
  EventQueue queue(4);
  queue.set(3, at(5));
  queue.set(1, at(7));
  queue.set(2, at(5));
  EXPECT_EQ(queue.next(), at(5));
  EXPECT_EQ(queue.pop(), 2U);
  EXPECT_EQ(queue.pop(), 3U);
  EXPECT_EQ(queue.pop(), 1U);
  EXPECT_EQ(queue.next(), kNever);
}

TEST(EventQueue, TimesCanBeChangedAndTakenBack) {
  EventQueue queue(3);
  queue.set(0, at(1));
  queue.set(1, at(2));
  queue.set(2, at(3));
  queue.set(2, at(0));
  queue.set(0, kNever);
  queue.set(0, kNever);
  EXPECT_EQ(queue.time_of(0), kNever);
  EXPECT_EQ(queue.time_of(2), at(0));
  EXPECT_EQ(queue.pop(), 2U);
  queue.set(1, at(9));
  queue.set(2, at(8));
  EXPECT_EQ(queue.pop(), 2U);
  EXPECT_EQ(queue.pop(), 1U);
}

// Against the obvious way, in a long row of changes that looks random and is not.
TEST(EventQueue, AgreesWithASearch) {
  constexpr std::uint32_t kSources = 37;
  EventQueue queue(kSources);
  std::vector<TimePoint> times(kSources, kNever);
  std::uint64_t state = 1;
  const auto next = [&] { return state = state * 6364136223846793005U + 1442695040888963407U, state >> 33U; };
  for (int step = 0; step < 20'000; ++step) {
    const auto source = static_cast<std::uint32_t>(next() % kSources);
    const std::uint64_t random = next() % 100;
    const TimePoint time = random < 20 ? kNever : at(static_cast<int>(random));
    queue.set(source, time);
    times[source] = time;
    if (random % 3 != 0) continue;
    const auto min = std::min_element(times.begin(), times.end());
    ASSERT_EQ(queue.next(), *min);
    if (*min == kNever) continue;
    ASSERT_EQ(queue.pop(), static_cast<std::uint32_t>(min - times.begin()));
    *min = kNever;
  }
}

}  // namespace
}  // namespace ctn::sim
