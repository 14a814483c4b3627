#include "os/fake/faulty_os.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "os/fake/fake_os.h"

namespace ctn::os {
namespace {

using namespace std::chrono_literals;

constexpr ThreadId kMain{1};

class FaultyOsTest : public testing::Test {
 protected:
  FakeOs inner_;
  FaultyOs os_{inner_};
};

TEST_F(FaultyOsTest, FailsAsOftenAsOrderedThenPasses) {
  os_.fail_next(Call::kSetLevel, 2);
  os_.fail_next(Call::kSetLevel, 1, Error::environment("third", "none"));
  EXPECT_FALSE(os_.set_level(kMain, Level::kActive).ok());
  EXPECT_FALSE(os_.set_level(kMain, Level::kActive).ok());
  EXPECT_EQ(os_.level(kMain).value(), Level::kOrdinary);
  const Status third = os_.set_level(kMain, Level::kActive);
  ASSERT_FALSE(third.ok());
  EXPECT_NE(third.error().message().find("third"), std::string::npos);
  EXPECT_TRUE(os_.set_level(kMain, Level::kActive).ok());
  EXPECT_EQ(inner_.level(kMain).value(), Level::kActive);
}

TEST_F(FaultyOsTest, EveryCallThatCanFailDoes) {
  const auto saved = os_.save_scheduling(kMain).value();
  for (const Call call : {Call::kThreadCpuTime, Call::kThreads, Call::kSetLevel, Call::kLevel, Call::kSetAffinity,
                          Call::kAffinity, Call::kSaveScheduling, Call::kRestoreScheduling, Call::kTopology}) {
    os_.fail_next(call, 1);
  }
  for (const bool works : {false, true}) {
    EXPECT_EQ(os_.thread_cpu_time(kMain).ok(), works);
    EXPECT_EQ(os_.threads(os_.current_process()).ok(), works);
    EXPECT_EQ(os_.set_level(kMain, Level::kOrdinary).ok(), works);
    EXPECT_EQ(os_.level(kMain).ok(), works);
    EXPECT_EQ(os_.set_affinity(kMain, CpuSet{0}).ok(), works);
    EXPECT_EQ(os_.affinity(kMain).ok(), works);
    EXPECT_EQ(os_.save_scheduling(kMain).ok(), works);
    EXPECT_EQ(os_.restore_scheduling(saved).ok(), works);
    EXPECT_EQ(os_.topology().ok(), works);
  }
}

TEST_F(FaultyOsTest, WhatDoesNotTakeIsFoundByReadingBack) {
  os_.ignore_next(Call::kSetLevel, 2);
  const Status set = os_.set_level(kMain, Level::kActive);
  ASSERT_FALSE(set.ok());
  EXPECT_NE(set.error().message().find("it is ordinary"), std::string::npos);
  EXPECT_TRUE(os_.set_level(kMain, Level::kOrdinary).ok());  // asked is what is
  os_.ignore_next(Call::kSetAffinity, 1);
  EXPECT_FALSE(os_.set_affinity(kMain, CpuSet{1}).ok());
  EXPECT_EQ(os_.affinity(kMain).value(), (CpuSet{0, 1}));
}

TEST_F(FaultyOsTest, GuardiansFailOnOrder) {
  os_.fail_next(Call::kStartGuardian, 1);
  EXPECT_FALSE(os_.start_guardian().ok());
  const auto guardian = os_.start_guardian().value();
  const auto saved = os_.save_scheduling(kMain).value();
  os_.fail_next(Call::kWatch, 1);
  os_.fail_next(Call::kEnsureRunning, 1);
  EXPECT_FALSE(guardian->watch(saved));
  EXPECT_TRUE(guardian->watch(saved));
  EXPECT_FALSE(guardian->ensure_running().ok());
  EXPECT_TRUE(guardian->ensure_running().ok());
  os_.lose_thread(kMain);
  EXPECT_FALSE(guardian->watch(saved));
}

TEST_F(FaultyOsTest, IsLateOnOrder) {
  os_.delay_next(Call::kSleepUntil, 1, 5ms);
  os_.sleep_until(TimePoint{10ms});
  EXPECT_EQ(os_.now(), TimePoint{15ms});
  os_.sleep_until(TimePoint{20ms});
  EXPECT_EQ(os_.now(), TimePoint{20ms});
  os_.delay_next(Call::kWait, 1, 5ms);
  const std::atomic<std::uint32_t> word{0};
  EXPECT_EQ(os_.wait(word, 0, TimePoint{30ms}), WaitResult::kTimedOut);
  EXPECT_EQ(os_.now(), TimePoint{35ms});
}

TEST_F(FaultyOsTest, LostThreadIsGone) {
  os_.lose_thread(kMain);
  EXPECT_FALSE(os_.thread_cpu_time(kMain).ok());
  EXPECT_FALSE(os_.ready_time(kMain));
  EXPECT_EQ(os_.thread_name(kMain), "");
  EXPECT_FALSE(os_.set_level(kMain, Level::kOrdinary).ok());
  EXPECT_FALSE(os_.save_scheduling(kMain).ok());
  EXPECT_TRUE(os_.threads(os_.current_process()).value().empty());
}

TEST_F(FaultyOsTest, LostCpuIsOfflineAndRefused) {
  os_.lose_cpu(1);
  EXPECT_EQ(os_.topology().value().online(), CpuSet{0});
  EXPECT_FALSE(os_.set_affinity(kMain, CpuSet{0, 1}).ok());
  EXPECT_TRUE(os_.set_affinity(kMain, CpuSet{0}).ok());
}

}  // namespace
}  // namespace ctn::os
