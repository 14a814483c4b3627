// Threads of a FakeOs that compete for more than one CPU: which goes where, and what moves them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "os/fake/fake_os.h"
#include "os/fake/shared_cpus.h"

namespace ctn::os {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

class SeveralSharedCpus : public SharedCpus {};

TEST_F(SeveralSharedCpus, ThreeEqualsOnTwoCpus) {
  burner("one", Level::kActive, {0, 1}, 1ms, 4ms);
  burner("two", Level::kActive, {0, 1}, 1ms, 2ms);
  burner("three", Level::kActive, {0, 1}, 1ms, 3ms);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 one 1-5", "1 two 1-3", "1 three 3-6"));
}

TEST_F(SeveralSharedCpus, ThreeOrdinaryThreadsShareTwoCpusEvenly) {
  for (const char* name : {"one", "two", "three"}) burner(name, Level::kOrdinary, {0, 1}, 1ms, 60ms);
  os.sleep_until(at(37ms));
  for (int id = 2; id <= 4; ++id) EXPECT_EQ(os.thread_cpu_time(ThreadId{id}).value(), 24ms);
  join();
}

TEST_F(SeveralSharedCpus, TheLowestLevelIsPreemptedAndOfThoseWhoCameLast) {
  burner("early", Level::kBackground, {0}, 1ms, 9ms);
  burner("active", Level::kActive, {1}, 1ms, 9ms);
  burner("late", Level::kBackground, {2}, 2ms, 9ms);
  burner("high", Level::kUnscheduled, {0, 1, 2}, 3ms, 2ms);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 early 1-10", "1 active 1-10", "2 late 2-3", "2 high 3-5", "2 late 5-13"));
}

TEST_F(SeveralSharedCpus, WhoIsPutOutTakesAFreeCpuOrPreemptsInItsTurn) {
  burner("ordinary", Level::kOrdinary, {1, 2}, 1ms, 4ms);
  burner("low", Level::kBackground, {0, 1}, 2ms, 4ms);
  burner("high", Level::kActive, {0}, 3ms, 4ms);
  join();
  EXPECT_THAT(stretches(), ElementsAre("1 ordinary 1-3", "0 low 2-3", "0 high 3-7", "1 low 3-6", "2 ordinary 3-5"));
}

TEST_F(SeveralSharedCpus, AThreadComesBackToTheCpuItHadLast) {
  spawn("worker", Level::kActive, {0, 1}, [&] {
    os.sleep_until(at(1ms));
    os.burn(1ms);
    os.sleep_until(at(9ms));
    os.burn(1ms);
  });
  burner("pinned", Level::kActive, {0}, 1ms, 2ms);
  const auto worker = ThreadId{2};
  os.sleep_until(Nanos{500us} + TimePoint{});
  ASSERT_TRUE(os.set_affinity(worker, {1}).ok());
  os.sleep_until(at(5ms));
  ASSERT_TRUE(os.set_affinity(worker, {0, 1}).ok());
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 pinned 1-3", "1 worker 1-2", "1 worker 9-10"));
}

TEST_F(SeveralSharedCpus, MovingABurningThreadFreesItsCpuAndQueuesItAtTheOther) {
  const ThreadId moved = burner("moved", Level::kActive, {0}, 1ms, 5ms);
  burner("left", Level::kActive, {0}, 2ms, 2ms);
  burner("there", Level::kActive, {1}, 2ms, 4ms);
  burner("behind", Level::kActive, {1}, 2ms, 1ms);
  os.sleep_until(at(3ms));
  ASSERT_TRUE(os.set_affinity(moved, {1}).ok());
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 moved 1-3", "1 there 2-6", "0 left 3-5", "1 behind 6-7", "1 moved 7-10"));
}

TEST_F(SeveralSharedCpus, WideningTheAffinityOfABurningThreadChangesNothing) {
  const ThreadId first = burner("first", Level::kActive, {0}, 1ms, 4ms);
  burner("second", Level::kActive, {0}, 1ms, 1ms);
  os.sleep_until(at(2ms));
  ASSERT_TRUE(os.set_affinity(first, {0, 1}).ok());
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 first 1-5", "0 second 5-6"));
}

TEST_F(SeveralSharedCpus, MovingAWaitingThreadToAFreeCpuStartsIt) {
  burner("first", Level::kActive, {0}, 1ms, 4ms);
  const ThreadId second = burner("second", Level::kActive, {0}, 1ms, 2ms);
  os.sleep_until(at(2ms));
  ASSERT_TRUE(os.set_affinity(second, {1}).ok());
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 first 1-5", "1 second 2-4"));
}

TEST_F(SeveralSharedCpus, ACpuThatGoesOfflineMidBurnSendsItsThreadElsewhere) {
  burner("stays", Level::kActive, {1}, 1ms, 4ms);
  burner("flees", Level::kActive, {0, 1}, 1ms, 6ms);
  os.sleep_until(at(3ms));
  os.set_cpu_online(0, false);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 flees 1-3", "1 stays 1-5", "1 flees 5-9"));
}

TEST_F(SeveralSharedCpus, APinnedThreadLosesItsCpuAndBurnsOnAnyOther) {
  burner("pinned", Level::kActive, {0}, 1ms, 6ms);
  burner("ordinary", Level::kOrdinary, {1, 2}, 1ms, 6ms);
  os.sleep_until(at(3ms));
  os.set_cpu_online(0, false);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 pinned 1-3", "1 ordinary 1-7", "2 pinned 3-7"));
}

TEST_F(SeveralSharedCpus, ACpuThatComesBackIsUsedAtOnce) {
  os.set_cpu_online(1, false);
  burner("first", Level::kActive, {0}, 1ms, 4ms);
  spawn("second", Level::kActive, {0}, [&] {
    EXPECT_FALSE(os.set_affinity(os.current_thread(), {0, 1}).ok());
    os.sleep_until(at(1ms));
    os.burn(4ms);
  });
  os.sleep_until(at(2ms));
  os.set_cpu_online(1, true);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 first 1-5", "1 second 2-6"));
}

}  // namespace
}  // namespace ctn::os
