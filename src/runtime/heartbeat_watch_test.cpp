#include "runtime/heartbeat_watch.h"

#include <gtest/gtest.h>

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Nanos kPause = milliseconds{250};

TEST(HeartbeatWatch, AServerCountsAsStoppedOnceItsHeartbeatHasPausedForTheGivenTime) {
  HeartbeatWatch watch;
  TimePoint now{seconds{1}};
  watch.begin(now, 7);
  for (int check = 1; check < 5; ++check)
    EXPECT_TRUE(watch.alive(now += HeartbeatWatch::kCheckPeriod, 7, kPause)) << check;
  EXPECT_FALSE(watch.alive(now += HeartbeatWatch::kCheckPeriod, 7, kPause));
  EXPECT_TRUE(watch.alive(now += HeartbeatWatch::kCheckPeriod, 8, kPause)) << "it is back";
}

// Guards: a stopped server was taken for a running one, was dialled, and kept its program waiting for an answer.
TEST(HeartbeatWatch, AStoppedServerCountsAsRunningOnlyWhenItsHeartbeatGoesOn) {
  HeartbeatWatch watch;
  TimePoint now{seconds{1}};
  watch.begin(now, 7);
  while (watch.alive(now += HeartbeatWatch::kCheckPeriod, 7, kPause)) continue;
  for (int check = 0; check < 100; ++check) {
    EXPECT_FALSE(watch.alive(now += milliseconds{1}, 7, kPause)) << "between two checks, too";
    EXPECT_LE(watch.next_check(), now + HeartbeatWatch::kResumeCheckPeriod);
  }
  EXPECT_TRUE(watch.alive(now += milliseconds{1}, 8, kPause)) << "seen at once";
  EXPECT_TRUE(watch.alive(now += milliseconds{1}, 8, kPause));
}

TEST(HeartbeatWatch, ChecksBeforeTheNextIsDueDoNotCount) {
  HeartbeatWatch watch;
  const TimePoint now{seconds{1}};
  watch.begin(now, 7);
  for (int check = 0; check < 100; ++check) EXPECT_TRUE(watch.alive(now + milliseconds{1}, 7, kPause));
  EXPECT_EQ(watch.next_check(), now + HeartbeatWatch::kCheckPeriod);
}

TEST(HeartbeatWatch, APauseOfTheWholeMachineIsNotTakenForAStoppedServer) {
  HeartbeatWatch watch;
  TimePoint now{seconds{1}};
  watch.begin(now, 7);
  EXPECT_TRUE(watch.alive(now += seconds{60}, 7, kPause));
  EXPECT_TRUE(watch.alive(now += HeartbeatWatch::kCheckPeriod, 8, kPause));
}

TEST(HeartbeatWatch, TheGapThatAServerAsksForIsKeptWithinLimits) {
  HeartbeatWatch watch;
  TimePoint now{seconds{1}};
  watch.begin(now, 7);
  EXPECT_TRUE(watch.alive(now += HeartbeatWatch::kCheckPeriod, 7, Nanos{1})) << "a single missed beat is not enough";
  for (int check = 0; check < 1000; ++check)
    EXPECT_TRUE(watch.alive(now += HeartbeatWatch::kCheckPeriod, 7, Nanos{0})) << "0: it has no heartbeat";
  EXPECT_FALSE(watch.alive(now += HeartbeatWatch::kCheckPeriod, 7, Nanos::max())) << "ten seconds at most";
}

}  // namespace
}  // namespace ctn::runtime
