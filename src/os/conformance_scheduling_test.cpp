// What os.h promises of levels, guardians and CPUs (conformance_test.cpp).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "os/os.h"
#include "os/scheduling_guard.h"
#include "os/testing/conformance_suite.h"

namespace ctn::os::conformance {
namespace {

using namespace std::chrono_literals;

// ---- Levels

TEST_P(OsConformance, OrdinaryNeedsNoPermission) {
  Parked parked(os());
  const Status set = os().set_level(parked.id(), Level::kOrdinary);
  ASSERT_TRUE(set.ok()) << set.error().message();
  const auto level = os().level(parked.id());
  ASSERT_TRUE(level.ok());
  EXPECT_EQ(*level, Level::kOrdinary);
}

TEST_P(RealTimeConformance, EveryLevelIsWhatWasSet) {
  Parked parked(os());
  SchedulingGuard guard(os(), parked.id());
  for (const Level level : {Level::kDispatcher, Level::kBackground, Level::kActive, Level::kUnscheduled, fixed_level(0),
                            fixed_level(kFixedLevels - 1), Level::kOrdinary}) {
    const Status set = os().set_level(parked.id(), level);
    ASSERT_TRUE(set.ok()) << set.error().message();
    const auto found = os().level(parked.id());
    ASSERT_TRUE(found.ok()) << found.error().message();
    EXPECT_EQ(*found, level) << to_string(level);
  }
}

TEST_P(OsConformance, OnlineCpusAreThoseOfTheTopology) {
  const auto online = os().online_cpus();
  ASSERT_TRUE(online.ok()) << online.error().message();
  EXPECT_EQ(*online, os().topology()->online());
}

TEST_P(RealTimeConformance, ALevelMayBeShiftedWithoutAnAnswer) {
  Parked parked(os());
  SchedulingGuard guard(os(), parked.id());
  ASSERT_TRUE(os().set_level(parked.id(), Level::kBackground).ok());
  for (const Level level : {Level::kActive, Level::kOrdinary, Level::kBackground}) {
    os().shift_level(parked.id(), level);
    const auto found = os().level(parked.id());
    ASSERT_TRUE(found.ok()) << found.error().message();
    EXPECT_EQ(*found, level) << to_string(level);
  }
  os().shift_level(gone_thread(), Level::kActive);  // nobody is harmed, and nobody told
}

// os/linux/linux_os_test.cpp has the same of a process that gave the permission up.
TEST_P(ConformanceWithoutPermission, RaisingFailsAndSaysWhatToDo) {
  ASSERT_FALSE(os().real_time_facts().permitted);
  Parked parked(os());
  EXPECT_ENVIRONMENT_ERROR(os().set_level(parked.id(), Level::kActive));
  EXPECT_EQ(os().level(parked.id()).value(), Level::kOrdinary);
}

TEST_P(RealTimeConformance, ThreadOfARaisedThreadStartsOrdinary) {
  std::optional<Level> made;
  const auto maker = os().spawn("maker", [&] {
    SchedulingGuard guard(os(), os().current_thread());
    if (!os().set_level(os().current_thread(), Level::kActive).ok()) return;
    const auto child = os().spawn("child", [&] {
      const auto level = os().level(os().current_thread());
      if (level.ok()) made = *level;
    });
    child->join();
  });
  maker->join();
  EXPECT_EQ(made, Level::kOrdinary);
}

TEST_P(RealTimeConformance, SavedSchedulingComesBack) {
  Parked parked(os());
  const auto before = os().save_scheduling(parked.id());
  ASSERT_TRUE(before.ok()) << before.error().message();
  ASSERT_FALSE(before->affinity.empty());
  {
    SchedulingGuard guard(os(), parked.id());
    ASSERT_TRUE(guard.status().ok());
    ASSERT_TRUE(os().set_level(parked.id(), Level::kUnscheduled).ok());
    ASSERT_TRUE(os().set_affinity(parked.id(), CpuSet{before->affinity.cpus().back()}).ok());
    const SavedScheduling raised = os().save_scheduling(parked.id()).value();
    EXPECT_NE(raised, *before);
    EXPECT_TRUE(os().is_raised(raised));
    EXPECT_FALSE(os().is_raised(*before));
  }
  SavedScheduling after = os().save_scheduling(parked.id()).value();
  if (!before->reset_on_fork) after.reset_on_fork = false;  // not every process may clear it
  EXPECT_EQ(after, *before);
}

TEST_P(OsConformance, AnotherThreadWithTheSameNumberIsNotRestored) {
  Parked parked(os());
  SavedScheduling saved = os().save_scheduling(parked.id()).value();
  const CpuSet first{saved.affinity.cpus().front()};
  ASSERT_TRUE(os().set_affinity(parked.id(), first).ok());
  ++saved.started;
  EXPECT_ENVIRONMENT_ERROR(os().restore_scheduling(saved));
  EXPECT_EQ(os().affinity(parked.id()).value(), first);
  --saved.started;
  EXPECT_TRUE(os().restore_scheduling(saved).ok());
  EXPECT_EQ(os().affinity(parked.id()).value(), saved.affinity);
}

TEST_P(OsConformance, SchedulingGuardRestoresOnce) {
  Parked parked(os());
  const CpuSet before = os().affinity(parked.id()).value();
  const CpuSet first{before.cpus().front()};
  SchedulingGuard guard(os(), parked.id());
  ASSERT_TRUE(os().set_affinity(parked.id(), first).ok());
  EXPECT_TRUE(guard.restore().ok());
  EXPECT_EQ(os().affinity(parked.id()).value(), before);
  ASSERT_TRUE(os().set_affinity(parked.id(), first).ok());
  EXPECT_TRUE(guard.restore().ok());
  EXPECT_EQ(os().affinity(parked.id()).value(), first);
}

TEST_P(OsConformance, GuardOfAThreadThatIsGoneDoesNothing) {
  SchedulingGuard guard(os(), gone_thread());
  EXPECT_FALSE(guard.status().ok());
  EXPECT_TRUE(guard.restore().ok());
}

// ---- Guardians

TEST_P(OsConformance, WhatIsWatchedAndNotForgottenIsRestoredWhenTheGuardianEnds) {
  Parked watched(os());
  Parked forgotten(os());
  const SavedScheduling before = os().save_scheduling(watched.id()).value();
  const CpuSet first{before.affinity.cpus().front()};
  {
    auto guardian = os().start_guardian();
    ASSERT_TRUE(guardian.ok()) << guardian.error().message();
    for (const ThreadId thread : {watched.id(), forgotten.id()}) {
      ASSERT_TRUE((*guardian)->watch(os().save_scheduling(thread).value()));
      ASSERT_TRUE(os().set_affinity(thread, first).ok());
      if (os().real_time_facts().permitted) {
        ASSERT_TRUE(os().set_level(thread, Level::kActive).ok());
      }
    }
    EXPECT_TRUE((*guardian)->ensure_running().ok());
    EXPECT_EQ(os().affinity(watched.id()).value(), first);  // not before its time
    (*guardian)->forget(forgotten.id());
    EXPECT_EQ((*guardian)->replaced(), 0);
  }
  SavedScheduling after = os().save_scheduling(watched.id()).value();
  if (!before.reset_on_fork) after.reset_on_fork = false;  // not every process may clear it
  EXPECT_EQ(after, before);
  EXPECT_EQ(os().affinity(forgotten.id()).value(), first);
}

TEST_P(OsConformance, GuardianKeepsTheLastOfSeveralAndNothingOfWhoIsGone) {
  Parked parked(os());
  const ThreadId gone = gone_thread();
  const SavedScheduling before = os().save_scheduling(parked.id()).value();
  SavedScheduling last = before;
  last.affinity = CpuSet{before.affinity.cpus().back()};
  {
    auto guardian = os().start_guardian();
    ASSERT_TRUE(guardian.ok()) << guardian.error().message();
    for (const ThreadId nobody : {gone, ThreadId{0}, ThreadId{-1}}) {
      SavedScheduling of_nobody = before;
      of_nobody.thread = nobody;
      EXPECT_FALSE((*guardian)->watch(of_nobody)) << static_cast<int>(nobody);
    }
    SavedScheduling of_another = before;
    ++of_another.started;
    EXPECT_FALSE((*guardian)->watch(of_another)) << "another thread with the number";
    (*guardian)->forget(gone);
    for (int i = 0; i < 3000; ++i) ASSERT_TRUE((*guardian)->watch(before));  // takes no room
    ASSERT_TRUE((*guardian)->watch(last));
  }
  EXPECT_EQ(os().affinity(parked.id()).value(), last.affinity);
}

// ---- CPUs

TEST_P(OsConformance, AffinityIsWhatWasSetAndIsInherited) {
  Parked parked(os());
  const CpuSet all = os().affinity(parked.id()).value();
  for (const int cpu : all.cpus()) {
    const Status set = os().set_affinity(parked.id(), CpuSet{cpu});
    ASSERT_TRUE(set.ok()) << set.error().message();
    EXPECT_EQ(os().affinity(parked.id()).value(), CpuSet{cpu});
  }
  ASSERT_TRUE(os().set_affinity(parked.id(), all).ok());

  SchedulingGuard guard(os(), os().current_thread());
  const CpuSet last{all.cpus().back()};
  ASSERT_TRUE(os().set_affinity(os().current_thread(), last).ok());
  Parked child(os());
  EXPECT_EQ(os().affinity(child.id()).value(), last);
}

TEST_P(OsConformance, AffinityThatCannotBeIsRefused) {
  Parked parked(os());
  const CpuSet before = os().affinity(parked.id()).value();
  const Status none = os().set_affinity(parked.id(), CpuSet{});
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().kind(), ErrorKind::kCaller);
  const Status negative = os().set_affinity(parked.id(), CpuSet{-1, 0});
  ASSERT_FALSE(negative.ok());
  EXPECT_EQ(negative.error().kind(), ErrorKind::kCaller);
  EXPECT_ENVIRONMENT_ERROR(os().set_affinity(parked.id(), CpuSet{60000}));
  EXPECT_EQ(os().affinity(parked.id()).value(), before);
  // A part of what was asked is not what was asked.
  EXPECT_ENVIRONMENT_ERROR(os().set_affinity(parked.id(), CpuSet{before.cpus().front(), 60000}));
}

TEST_P(OsConformance, TopologyHoldsTheCpusThatThreadsUse) {
  const auto topology = os().topology();
  ASSERT_TRUE(topology.ok()) << topology.error().message();
  EXPECT_TRUE(std::is_sorted(topology->cpus.begin(), topology->cpus.end(),
                             [](const Cpu& a, const Cpu& b) { return a.number < b.number; }));
  const CpuSet online = topology->online();
  EXPECT_FALSE(online.empty());
  const CpuSet used = os().affinity(os().current_thread()).value();
  EXPECT_THAT(online.cpus(), testing::IsSupersetOf(used.cpus()));
}

}  // namespace
}  // namespace ctn::os::conformance
