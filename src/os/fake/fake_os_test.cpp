#include "os/fake/fake_os.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "base/testing/times.h"

namespace ctn::os {
namespace {

using namespace std::chrono_literals;

TEST(FakeOs, TimeJumpsToTheNextDeadline) {
  FakeOs os;
  EXPECT_EQ(os.now(), at(0ns));
  os.sleep_until(at(1h));
  EXPECT_EQ(os.now(), at(1h));
}

TEST(FakeOs, TheConstructorsThreadIsThreadOne) {
  FakeOs os;
  EXPECT_EQ(os.current_thread(), ThreadId{1});
}

TEST(FakeOs, ThreadsRunByTimeThenLevelThenAge) {
  FakeOs os;
  std::vector<std::string> order;
  const auto sleeper = [&](const char* name, Level level, Nanos wake_up) {
    return os.spawn(name, [&os, &order, name, level, wake_up] {
      ASSERT_TRUE(os.set_level(os.current_thread(), level).ok());
      os.sleep_until(at(wake_up));
      order.emplace_back(name);
    });
  };
  const auto late = sleeper("late", Level::kDispatcher, 3ms);
  const auto old = sleeper("old", Level::kBackground, 2ms);
  const auto young = sleeper("young", Level::kBackground, 2ms);
  const auto high = sleeper("high", Level::kActive, 2ms);
  const auto early = sleeper("early", Level::kOrdinary, 1ms);
  for (const auto* thread : {&late, &old, &young, &high, &early}) (*thread)->join();
  EXPECT_THAT(order, testing::ElementsAre("early", "high", "old", "young", "late"));
  EXPECT_EQ(os.now(), at(3ms));
}

TEST(FakeOs, WokenThreadsRunWhenTheWakerBlocks) {
  FakeOs os;
  std::vector<std::string> order;
  std::atomic<std::uint32_t> word{0};
  const auto waiter = os.spawn("waiter", [&] {
    os.wait(word, 0, kNever);
    order.emplace_back("woken");
  });
  os.sleep_until(at(1ms));
  word = 1;
  os.wake(word);
  order.emplace_back("still here");
  os.sleep_until(at(2ms));
  order.emplace_back("later");
  waiter->join();
  EXPECT_THAT(order, testing::ElementsAre("still here", "woken", "later"));
}

TEST(FakeOs, BurnMovesTimeAndTheOwnClockOnly) {
  FakeOs os;
  Nanos seen_halfway{0};
  const auto worker = os.spawn("worker", [&] { os.burn(10ms); });
  const auto watcher = os.spawn("watcher", [&] {
    os.sleep_until(at(4ms));
    seen_halfway = os.thread_cpu_time(ThreadId{2}).value();
  });
  os.burn(1ms);
  os.sleep_until(at(20ms));
  EXPECT_EQ(os.thread_cpu_time(), 1ms);
  EXPECT_EQ(seen_halfway, 4ms);
}

TEST(FakeOs, BurnsOverlapBecauseCpusAreNotModelled) {
  FakeOs os;
  const auto first = os.spawn("first", [&] { os.burn(10ms); });
  const auto second = os.spawn("second", [&] { os.burn(10ms); });
  first->join();
  second->join();
  EXPECT_EQ(os.now(), at(10ms));
}

TEST(FakeOs, PollingWithAnExpiredDeadlineLetsOthersRun) {
  FakeOs os;
  std::atomic<std::uint32_t> word{0};
  const auto setter = os.spawn("setter", [&] { word = 1; });
  int polls = 0;
  while (os.wait(word, 0, os.now()) == WaitResult::kTimedOut && polls < 10) ++polls;
  EXPECT_LT(polls, 10);
}

// A small program whose every step depends on the order of threads: two runs of it must tell the same story.
std::vector<std::string> story(const std::vector<int>& steps) {
  FakeOs os;
  std::vector<std::string> lines;
  std::atomic<std::uint32_t> turn{0};
  std::vector<std::unique_ptr<Thread>> threads;
  for (std::size_t i = 0; i < 4; ++i) {
    threads.push_back(os.spawn("t" + std::to_string(i), [&, i] {
      for (std::size_t k = i; k < steps.size(); k += 4) {
        const int step = steps[k];
        static_cast<void>(os.set_level(os.current_thread(), static_cast<Level>(step % 5)));
        if (step % 3 == 0) os.burn(Nanos{step});
        if (step % 3 == 1) os.wait(turn, turn.load(), os.now() + Nanos{step});
        if (step % 3 == 2) {
          ++turn;
          os.wake(turn);
          os.sleep_until(os.now() + Nanos{step / 4});
        }
        lines.push_back(std::to_string(os.now().time_since_epoch().count()) + ":" + std::to_string(i));
      }
    }));
  }
  threads.clear();
  return lines;
}

RC_GTEST_PROP(FakeOs, IsDeterministic, ()) {
  const auto steps = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 60));
  RC_ASSERT(story(steps) == story(steps));
}

TEST(FakeOs, RecordsLevelsAndAffinities) {
  FakeOs os;
  os.sleep_until(at(5ms));
  ASSERT_TRUE(os.set_level(ThreadId{1}, Level::kActive).ok());
  ASSERT_TRUE(os.set_affinity(ThreadId{1}, CpuSet{1}).ok());
  EXPECT_FALSE(os.set_affinity(ThreadId{1}, CpuSet{9}).ok());
  EXPECT_THAT(os.changes(), testing::ElementsAre(FakeOs::Change{at(5ms), ThreadId{1}, Level::kActive, std::nullopt},
                                                 FakeOs::Change{at(5ms), ThreadId{1}, std::nullopt, CpuSet{1}}));
}

TEST(FakeOs, RefusesLevelsWithoutPermission) {
  FakeOs os;
  RealTimeFacts facts;
  facts.why_not = "ask nicely";
  os.set_real_time_facts(facts);
  const Status set = os.set_level(ThreadId{1}, Level::kActive);
  ASSERT_FALSE(set.ok());
  EXPECT_NE(set.error().message().find("ask nicely"), std::string::npos);
  EXPECT_TRUE(os.set_level(ThreadId{1}, Level::kOrdinary).ok());
}

TEST(FakeOs, PinnedThreadLosesItsAffinityWithItsCpu) {
  FakeOs os(fake_topology(3));
  ASSERT_TRUE(os.set_affinity(ThreadId{1}, CpuSet{1}).ok());
  os.set_cpu_online(1, false);
  EXPECT_EQ(os.topology()->online(), (CpuSet{0, 2}));
  EXPECT_EQ(os.affinity(ThreadId{1}).value(), (CpuSet{0, 2}));
  EXPECT_FALSE(os.set_affinity(ThreadId{1}, CpuSet{1}).ok());
  os.set_cpu_online(1, true);
  EXPECT_EQ(os.affinity(ThreadId{1}).value(), (CpuSet{0, 1, 2}));
}

TEST(FakeOs, ThreadWithAnotherCpuLeftGetsTheFirstBack) {
  FakeOs os(fake_topology(3));
  ASSERT_TRUE(os.set_affinity(ThreadId{1}, CpuSet{0, 1}).ok());
  os.set_cpu_online(1, false);
  EXPECT_EQ(os.affinity(ThreadId{1}).value(), CpuSet{0});
  os.set_cpu_online(1, true);
  EXPECT_EQ(os.affinity(ThreadId{1}).value(), (CpuSet{0, 1}));
}

TEST(FakeOs, RestoringToACpuThatWentAwayAllowsAll) {
  FakeOs os(fake_topology(3));
  ASSERT_TRUE(os.set_affinity(ThreadId{1}, CpuSet{1}).ok());
  const auto saved = os.save_scheduling(ThreadId{1}).value();
  ASSERT_TRUE(os.set_affinity(ThreadId{1}, CpuSet{0}).ok());
  os.set_cpu_online(1, false);
  EXPECT_TRUE(os.restore_scheduling(saved).ok());
  EXPECT_EQ(os.affinity(ThreadId{1}).value(), (CpuSet{0, 2}));
}

TEST(FakeOs, AThreadWithTheNumberOfAnotherIsAnother) {
  FakeOs os;
  const SavedScheduling before = os.save_scheduling(ThreadId{1}).value();
  os.reuse_number(ThreadId{1});
  EXPECT_FALSE(before.same_thread(os.save_scheduling(ThreadId{1}).value()));
  ASSERT_TRUE(os.set_affinity(ThreadId{1}, CpuSet{1}).ok());
  EXPECT_FALSE(os.restore_scheduling(before).ok());
  EXPECT_EQ(os.affinity(ThreadId{1}).value(), CpuSet{1});
}

TEST(FakeOs, GuardianRestoresWhatIsWatchedWhenTheProcessIsKilled) {
  FakeOs os;
  const ThreadId self = os.current_thread();
  const SavedScheduling before = os.save_scheduling(self).value();
  const auto guardian = os.start_guardian().value();
  ASSERT_TRUE(guardian->watch(before));
  ASSERT_TRUE(os.set_level(self, Level::kActive).ok());
  EXPECT_THAT(os.watched(), testing::ElementsAre(self));
  os.restore_watched();
  EXPECT_EQ(os.level(self).value(), Level::kOrdinary);
  EXPECT_THAT(os.watched(), testing::IsEmpty());
  guardian->forget(self);  // was not watched any more
  ASSERT_TRUE(guardian->watch(before));
  guardian->forget(self);
  EXPECT_THAT(os.guardian_calls(), testing::ElementsAre(FakeOs::GuardianCall{at(0ns), self, before},
                                                        FakeOs::GuardianCall{at(0ns), self, before},
                                                        FakeOs::GuardianCall{at(0ns), self, std::nullopt}));
}

TEST(FakeOs, GuardianThatIsEndedIsReplaced) {
  FakeOs os;
  const ThreadId self = os.current_thread();
  const auto guardian = os.start_guardian().value();
  ASSERT_TRUE(guardian->watch(os.save_scheduling(self).value()));
  ASSERT_TRUE(os.set_level(self, Level::kActive).ok());
  os.end_guardian();
  os.restore_watched();
  EXPECT_EQ(os.level(self).value(), Level::kActive);
  EXPECT_EQ(guardian->replaced(), 0);
  ASSERT_TRUE(guardian->ensure_running().ok());
  EXPECT_EQ(guardian->replaced(), 1);
  os.restore_watched();
  EXPECT_EQ(os.level(self).value(), Level::kOrdinary);
}

TEST(FakeOs, AGuardianHasOnlySoMuchRoom) {
  FakeOs os;
  os.set_guardian_capacity(0);
  const ThreadId self = os.current_thread();
  const auto guardian = os.start_guardian().value();
  EXPECT_FALSE(guardian->watch(os.save_scheduling(self).value()));
}

class FakeOsDeathTest : public testing::Test {
 protected:
  FakeOsDeathTest() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(FakeOsDeathTest, DeadlockListsTheThreads) {
  EXPECT_DEATH(
      {
        FakeOs os;
        const std::atomic<std::uint32_t> word{7};
        const auto waiter = os.spawn("camera", [&] { os.wait(word, 7, kNever); });
        os.sleep_until(at(3ms));
        waiter->join();
      },
      "FakeOs at 3.000000 ms: deadlock(.|\n)*thread 1 'main' \\(ordinary\\) joins thread 2(.|\n)*"
      "thread 2 'camera' \\(ordinary\\) waits for a word that is 7");
}

TEST_F(FakeOsDeathTest, LivelockIsNoHang) {
  EXPECT_DEATH(
      {
        FakeOs os;
        while (true) os.sleep_until(os.now());
      },
      "livelock");
}

TEST_F(FakeOsDeathTest, StrangersMayNotWait) {
  EXPECT_DEATH(
      {
        FakeOs os;
        std::thread([&] { os.sleep_until(at(1ms)); }).join();
      },
      "sleep_until was called from a thread that spawn\\(\\) did not make");
}

}  // namespace
}  // namespace ctn::os
