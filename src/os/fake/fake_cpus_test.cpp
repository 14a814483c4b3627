// Threads of a FakeOs that compete for CPUs, by the rules in fake_cpus.h.
#include "os/fake/fake_cpus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "os/fake/busy_thread.h"
#include "os/fake/fake_os.h"
#include "os/fake/shared_cpus.h"

namespace ctn::os {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

// --- Levels ---

TEST_F(SharedCpus, AHigherLevelPreemptsAtOnce) {
  burner("low", Level::kBackground, {0}, 1ms, 4ms);
  burner("mid", Level::kActive, {0}, 2ms, 4ms);
  burner("high", Level::kUnscheduled, {0}, 3ms, 1ms);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 low 1-2", "0 mid 2-3", "0 high 3-4", "0 mid 4-7", "0 low 7-10"));
}

TEST_F(SharedCpus, ALowerLevelWaitsForItsTurn) {
  burner("high", Level::kActive, {0}, 1ms, 5ms);
  burner("low", Level::kBackground, {0}, 2ms, 1ms);
  burner("ordinary", Level::kOrdinary, {0}, 2ms, 1ms);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 high 1-6", "0 low 6-7", "0 ordinary 7-8"));
}

TEST_F(SharedCpus, RaisingAWaitingThreadMidBurnHandsItTheCpu) {
  burner("active", Level::kActive, {0}, 1ms, 5ms);
  const ThreadId waiting = burner("waiting", Level::kBackground, {0}, 1ms, 2ms);
  os.sleep_until(at(3ms));
  os.shift_level(waiting, Level::kUnscheduled);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 active 1-3", "0 waiting 3-5", "0 active 5-8"));
}

TEST_F(SharedCpus, LoweringABurningThreadTakesTheCpuFromIt) {
  const ThreadId burning = burner("burning", Level::kActive, {0}, 1ms, 5ms);
  burner("waiting", Level::kBackground, {0}, 1ms, 2ms);
  os.sleep_until(at(3ms));
  os.shift_level(burning, Level::kOrdinary);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 burning 1-3", "0 waiting 3-5", "0 burning 5-8"));
}

TEST_F(SharedCpus, SwappingTwoLevelsInOneInstantSwapsWhoBurns) {
  const ThreadId first = burner("first", Level::kActive, {0}, 1ms, 5ms);
  const ThreadId second = burner("second", Level::kBackground, {0}, 1ms, 5ms);
  os.sleep_until(at(3ms));
  os.shift_level(first, Level::kBackground);
  os.shift_level(second, Level::kActive);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 first 1-3", "0 second 3-8", "0 first 8-11"));
}

TEST_F(SharedCpus, WhoStandsInLineIsReadyAndWhoSleepsIsNot) {
  burner("first", Level::kActive, {0}, 1ms, 4ms);
  const ThreadId low = burner("low", Level::kOrdinary, {0}, 2ms, 2ms);
  os.sleep_until(at(2ms));
  EXPECT_EQ(os.ready_time(low), 0ms);
  os.sleep_until(at(4ms));
  EXPECT_EQ(os.ready_time(low), 2ms);
  EXPECT_EQ(os.thread_name(low), "low");
  os.sleep_until(at(6ms));
  EXPECT_EQ(os.ready_time(low), 3ms) << "it has run since";
  join();
}

// --- The line of equals ---

TEST_F(SharedCpus, EqualsAreServedInTheOrderInWhichTheyCame) {
  burner("third", Level::kActive, {0}, 3ms, 2ms);
  burner("first", Level::kActive, {0}, 1ms, 20ms);
  burner("second", Level::kActive, {0}, 2ms, 2ms);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 first 1-21", "0 second 21-23", "0 third 23-25"));
}

TEST_F(SharedCpus, WhoIsPreemptedStaysFirstOfItsLevel) {
  burner("first", Level::kActive, {0}, 1ms, 4ms);
  burner("second", Level::kActive, {0}, 2ms, 2ms);
  burner("high", Level::kUnscheduled, {0}, 3ms, 1ms);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 first 1-3", "0 high 3-4", "0 first 4-6", "0 second 6-8"));
}

TEST_F(SharedCpus, WhoIsLoweredIsFirstOfItsNewLevel) {  // as sched(7) says, and Linux 6.18 does
  const ThreadId first = burner("first", Level::kActive, {0}, 1ms, 4ms);
  burner("second", Level::kBackground, {0}, 1ms, 2ms);
  os.sleep_until(at(2ms));
  os.shift_level(first, Level::kBackground);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 first 1-2", "0 first 2-5", "0 second 5-7")) << "a stretch has one level";
}

TEST_F(SharedCpus, WhoIsRaisedIsLastOfItsNewLevel) {
  burner("first", Level::kActive, {0}, 1ms, 4ms);
  const ThreadId raised = burner("raised", Level::kBackground, {0}, 1ms, 1ms);
  burner("second", Level::kActive, {0}, 2ms, 2ms);
  os.sleep_until(at(3ms));
  os.shift_level(raised, Level::kActive);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 first 1-5", "0 second 5-7", "0 raised 7-8"));
}

TEST_F(SharedCpus, SettingTheSameLevelKeepsThePlaceInTheLine) {
  const ThreadId first = burner("first", Level::kActive, {0}, 1ms, 4ms);
  const ThreadId second = burner("second", Level::kActive, {0}, 1ms, 1ms);
  burner("third", Level::kActive, {0}, 1ms, 1ms);
  os.sleep_until(at(2ms));
  os.shift_level(first, Level::kActive);
  os.shift_level(second, Level::kActive);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 first 1-5", "0 second 5-6", "0 third 6-7"));
}

TEST_F(SharedCpus, OrdinaryThreadsTakeTurns) {
  burner("one", Level::kOrdinary, {0}, 1ms, 7ms);
  burner("two", Level::kOrdinary, {0}, 2ms, 5ms);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 one 1-4", "0 two 4-7", "0 one 7-10", "0 two 10-12", "0 one 12-13"));
}

TEST_F(SharedCpus, APreemptedSliceGoesOnWhereItWas) {
  burner("one", Level::kOrdinary, {0}, 1ms, 4ms);
  burner("two", Level::kOrdinary, {0}, 1ms, 1ms);
  burner("high", Level::kActive, {0}, 3ms, 5ms);
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 one 1-3", "0 high 3-8", "0 one 8-9", "0 two 9-10", "0 one 10-11"));
}

TEST_F(SharedCpus, ManyShortBurnsAreNoWayAroundTheSlice) {
  const BusyThread busy(os, "busy", {0}, Level::kOrdinary, 500us);
  const BusyThread other(os, "other", {0}, Level::kOrdinary, 1s);
  os.sleep_until(at(60ms));
  EXPECT_TRUE(busy.ready() && other.ready());
  EXPECT_EQ(os.thread_cpu_time(ThreadId{2}).value(), 30ms);
  EXPECT_EQ(os.thread_cpu_time(ThreadId{3}).value(), 30ms);
}

// --- Waking ---

TEST_F(SharedCpus, AWokenThreadGoesOnOnlyWhenItHasItsCpu) {
  std::atomic<std::uint32_t> word{0};
  TimePoint woken{};
  spawn("waiter", Level::kBackground, {0}, [&] {
    EXPECT_EQ(os.wait(word, 0, kNever), WaitResult::kChanged);
    woken = os.now();
  });
  burner("active", Level::kActive, {0}, 1ms, 9ms);
  os.sleep_until(at(3ms));
  word = 1;
  os.wake(word);
  join();
  EXPECT_EQ(woken, at(10ms));
}

TEST_F(SharedCpus, AWokenEqualWaitsBehindWhoBurns) {
  TimePoint woken{};
  spawn("sleeper", Level::kActive, {0}, [&] {
    os.sleep_until(at(3ms));
    woken = os.now();
  });
  burner("active", Level::kActive, {0}, 1ms, 9ms);
  join();
  EXPECT_EQ(woken, at(10ms));
}

TEST_F(SharedCpus, AControllerActsWhileItsCpuIsBusy) {
  burner("active", Level::kUnscheduled, {0}, 1ms, 9ms);
  ASSERT_TRUE(os.set_affinity(ThreadId{1}, {0}).ok());
  os.sleep_until(at(3ms));
  EXPECT_EQ(os.now(), at(3ms));
  os.sleep_until(at(4ms));
  EXPECT_EQ(os.thread_cpu_time(ThreadId{2}).value(), 3ms);
  join();
  EXPECT_EQ(ended["active"], 10ms);
}

TEST_F(SharedCpus, AWaitThatTimesOutReturnsOnceItHasItsCpu) {
  const std::atomic<std::uint32_t> word{0};
  TimePoint returned{};
  spawn("waiter", Level::kBackground, {0}, [&] {
    EXPECT_EQ(os.wait(word, 0, at(2ms)), WaitResult::kTimedOut);
    returned = os.now();
  });
  burner("active", Level::kActive, {0}, 1ms, 4ms);
  join();
  EXPECT_EQ(returned, at(5ms));
}

TEST_F(SharedCpus, AWakeThatComesWhileTheWaiterAwaitsItsCpuCounts) {
  std::atomic<std::uint32_t> word{0};
  WaitResult result = WaitResult::kTimedOut;
  spawn("waiter", Level::kBackground, {0}, [&] { result = os.wait(word, 0, at(2ms)); });
  burner("active", Level::kActive, {0}, 1ms, 4ms);
  os.sleep_until(at(3ms));
  word = 1;
  os.wake(word);
  join();
  EXPECT_EQ(result, WaitResult::kChanged);
}

TEST_F(SharedCpus, AWakeThatChangesNothingCostsTheWaiterNothing) {
  std::atomic<std::uint32_t> word{0};
  TimePoint woken{};
  spawn("waiter", Level::kBackground, {0}, [&] {
    EXPECT_EQ(os.wait(word, 0, kNever), WaitResult::kChanged);
    woken = os.now();
  });
  burner("active", Level::kActive, {0}, 1ms, 4ms);
  os.sleep_until(at(2ms));
  os.wake(word);
  os.sleep_until(at(7ms));
  word = 1;
  os.wake(word);
  join();
  EXPECT_EQ(woken, at(7ms));
}

TEST_F(SharedCpus, AtTheInstantAtWhichABurnEndsAHigherLevelComesFirst) {
  burner("low", Level::kBackground, {0}, 1ms, 2ms);
  burner("high", Level::kActive, {0}, 3ms, 4ms);
  join();
  EXPECT_EQ(ended["low"], 7ms);
  EXPECT_EQ(ended["high"], 7ms);
}

TEST_F(SharedCpus, BurningNothingGivesWayToAHigherLevel) {
  TimePoint before{};
  TimePoint after{};
  spawn("self", Level::kActive, {0}, [&] {
    os.sleep_until(at(2ms));
    os.shift_level(os.current_thread(), Level::kOrdinary);
    before = os.now();
    os.burn(0ns);
    after = os.now();
  });
  burner("other", Level::kBackground, {0}, 2ms, 4ms);
  join();
  EXPECT_EQ(before, at(2ms)) << "the baton is kept";
  EXPECT_EQ(after, at(6ms));
}

TEST_F(SharedCpus, PollingLetsAnEqualRun) {
  std::atomic<std::uint32_t> word{0};
  int polls = 0;
  spawn("poller", Level::kActive, {0}, [&] {
    os.sleep_until(at(1ms));
    while (os.wait(word, 0, os.now()) == WaitResult::kTimedOut && polls < 10) ++polls;
  });
  spawn("setter", Level::kActive, {0}, [&] {
    os.sleep_until(at(1ms));
    word = 1;
  });
  join();
  EXPECT_LT(polls, 10);
}

// --- Accounts, and the end ---

TEST_F(SharedCpus, CpuTimeCountsOnlyWhatAThreadHad) {
  const ThreadId low = burner("low", Level::kBackground, {0}, 1ms, 5ms);
  burner("high", Level::kActive, {0}, 3ms, 4ms);
  const auto had = [&](Nanos time) {
    os.sleep_until(at(time));
    return os.thread_cpu_time(low).value();
  };
  EXPECT_EQ(had(2ms), 1ms);
  EXPECT_EQ(had(4ms), 2ms);
  EXPECT_EQ(had(6ms), 2ms);
  EXPECT_EQ(had(8ms), 3ms);
  join();
  EXPECT_EQ(ended["low"], 10ms);
}

TEST_F(SharedCpus, RestoringSchedulingMidBurnTakesEffect) {
  const ThreadId first = burner("first", Level::kActive, {0}, 1ms, 4ms);
  burner("second", Level::kBackground, {0}, 1ms, 2ms);
  os.sleep_until(at(2ms));
  SavedScheduling saved = os.save_scheduling(first).value();
  saved.policy = static_cast<int>(Level::kOrdinary);
  ASSERT_TRUE(os.restore_scheduling(saved).ok());
  join();
  EXPECT_THAT(stretches(), ElementsAre("0 first 1-2", "0 second 2-4", "0 first 4-7"));
}

TEST_F(SharedCpus, ABusyThreadEndsWithItsScope) {
  {
    const BusyThread busy(os, "busy", {0});
    os.sleep_until(at(10ms) + 300us);
  }
  EXPECT_EQ(os.now(), at(11ms));
}

TEST(FakeCpus, SharingMayEndWhenNobodyElseLives) {
  FakeOs os(fake_topology(1));
  os.share_cpus(true);
  os.spawn("alone", [&] { os.burn(2ms); })->join();
  os.share_cpus(false);
  const auto first = os.spawn("first", [&] { os.burn(10ms); });
  const auto second = os.spawn("second", [&] { os.burn(10ms); });
  first->join();
  second->join();
  EXPECT_EQ(os.now(), at(12ms));
}

class FakeCpusDeathTest : public testing::Test {
 protected:
  FakeCpusDeathTest() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(FakeCpusDeathTest, DeadlockListsTheThreads) {
  EXPECT_DEATH(
      {
        FakeOs os(fake_topology(1));
        os.share_cpus(true);
        const std::atomic<std::uint32_t> word{7};
        const auto waiter = os.spawn("camera", [&] {
          os.burn(3ms);
          os.wait(word, 7, kNever);
        });
        waiter->join();
      },
      "FakeOs at 3.000000 ms: deadlock(.|\n)*'main' \\(ordinary\\) joins thread 2(.|\n)*"
      "'camera' \\(ordinary\\) waits for a word that is 7");
}

TEST_F(FakeCpusDeathTest, PollingAboveWhoShouldActIsALivelock) {
  EXPECT_DEATH(
      {
        FakeOs os(fake_topology(1));
        os.share_cpus(true);
        const auto starved = os.spawn("starved", [&] { os.burn(3ms); });
        os.shift_level(ThreadId{1}, Level::kActive);
        while (true) os.sleep_until(os.now());
      },
      "livelock(.|\n)*'main' \\(active\\) has CPU 0, 0.000000 ms to go(.|\n)*"
      "'starved' \\(ordinary\\) waits for one of CPUs 0, 0.000000 ms to go");
}

TEST_F(FakeCpusDeathTest, SharingBeginsBeforeOtherThreadsDo) {
  EXPECT_DEATH(
      {
        FakeOs os;
        const auto other = os.spawn("other", [&] { os.burn(3ms); });
        os.share_cpus(true);
      },
      "share_cpus was called while other threads live");
}

}  // namespace
}  // namespace ctn::os
