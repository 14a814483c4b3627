#include "trial/timers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace ctn::trial {
namespace {

TimePoint at(int nanos) { return TimePoint{} + Nanos{nanos}; }

TEST(Timers, NothingIsDueAtFirst) { EXPECT_EQ(Timers(5).next(), kNever); }

TEST(Timers, OfSeveralAtOneTimeTheLowestNumberComesFirst) {
  Timers timers(6);
  timers.set(4, at(3));
  timers.set(1, at(3));
  timers.set(5, at(3));
  EXPECT_EQ(timers.next_source(), 1U);
  timers.set(1, kNever);
  EXPECT_EQ(timers.next_source(), 4U);
}

// Beside a search through all of them.
TEST(Timers, TheEarliestComesFirstWhateverIsSet) {
  std::mt19937 random(1);
  for (const std::size_t sources : {1U, 2U, 3U, 8U, 13U}) {
    Timers timers(sources);
    std::vector<TimePoint> times(sources, kNever);
    for (int step = 0; step < 2000; ++step) {
      const std::size_t source = random() % sources;
      times[source] = random() % 5 == 0 ? kNever : at(static_cast<int>(random() % 20));
      timers.set(static_cast<Timers::Source>(source), times[source]);
      const auto earliest = std::min_element(times.begin(), times.end());
      ASSERT_EQ(timers.next(), *earliest);
      if (*earliest == kNever) continue;
      ASSERT_EQ(timers.next_source(), static_cast<std::size_t>(earliest - times.begin()));
    }
  }
}

}  // namespace
}  // namespace ctn::trial
