#include "runtime/pulse_watch.h"

#include <gtest/gtest.h>

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Nanos kPause = milliseconds{250};

TEST(PulseWatch, CeasesAfterThePauseThatIsNamed) {
  PulseWatch watch;
  TimePoint now{seconds{1}};
  watch.begin(now, 7);
  for (int look = 1; look < 5; ++look) EXPECT_TRUE(watch.lives(now += PulseWatch::kLook, 7, kPause)) << look;
  EXPECT_FALSE(watch.lives(now += PulseWatch::kLook, 7, kPause));
  EXPECT_TRUE(watch.lives(now += PulseWatch::kLook, 8, kPause)) << "it is back";
}

TEST(PulseWatch, LooksTooSoonDoNotCount) {
  PulseWatch watch;
  const TimePoint now{seconds{1}};
  watch.begin(now, 7);
  for (int look = 0; look < 100; ++look) EXPECT_TRUE(watch.lives(now + milliseconds{1}, 7, kPause));
  EXPECT_EQ(watch.next_look(), now + PulseWatch::kLook);
}

TEST(PulseWatch, AMachineThatStoodStillIsNoServerThatDoes) {
  PulseWatch watch;
  TimePoint now{seconds{1}};
  watch.begin(now, 7);
  EXPECT_TRUE(watch.lives(now += seconds{60}, 7, kPause));
  EXPECT_TRUE(watch.lives(now += PulseWatch::kLook, 8, kPause));
}

TEST(PulseWatch, TakesNoNonsense) {
  PulseWatch watch;
  TimePoint now{seconds{1}};
  watch.begin(now, 7);
  EXPECT_TRUE(watch.lives(now += PulseWatch::kLook, 7, Nanos{1})) << "not so fast";
  for (int look = 0; look < 1000; ++look) EXPECT_TRUE(watch.lives(now += PulseWatch::kLook, 7, Nanos{0})) << "no pulse";
  EXPECT_FALSE(watch.lives(now += PulseWatch::kLook, 7, Nanos::max())) << "not for ever";
}

}  // namespace
}  // namespace ctn::runtime
