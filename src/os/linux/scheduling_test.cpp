// Scheduling against a kernel that a test plays: refusals and lies that a real one shows too seldom.
#include "os/linux/scheduling.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <cerrno>

#include "os/linux/privilege.h"
#include "os/linux/testing/fabricated_tree.h"

namespace ctn::os {
namespace {

constexpr pid_t kNumber = 42;
constexpr ThreadId kThread{kNumber};

// One thread, CPUs 0 to `last_cpu`. Behaves as Linux does to a privileged process, until told otherwise.
class PlayedKernel : public KernelCalls {
 public:
  int set_policy(pid_t thread, const SchedulingPolicy& wanted) override {
    if (thread != kNumber) return ESRCH;
    if (wanted.priority > limit) return EPERM;
    if (!may_raise && (wanted.policy == SCHED_FIFO || (policy.reset_on_fork && !wanted.reset_on_fork))) return EPERM;
    if (!ignores) policy = wanted;
    return 0;
  }
  int look_at_policy(pid_t thread, SchedulingPolicy& found) override {
    found = policy;
    if (torn_looks > 0) {
      --torn_looks;
      found.priority = policy.priority > 0 ? 0 : 10;
    }
    return thread == kNumber ? 0 : ESRCH;
  }
  int set_nice(pid_t, int wanted) override {
    if (!may_raise && wanted < nice) return EACCES;
    nice = wanted;
    return 0;
  }
  int get_nice(pid_t, int& found) override {
    found = nice;
    return 0;
  }
  int set_affinity(pid_t thread, const CpuMask& wanted) override {
    if (thread != kNumber) return ESRCH;
    std::vector<int> there = to_cpu_set(wanted).cpus();
    std::erase_if(there, [&](int cpu) { return cpu > last_cpu; });
    if (there.empty()) return EINVAL;
    if (!ignores) cpus = CpuSet(there);
    return 0;
  }
  int get_affinity(pid_t thread, CpuMask& found) override {
    found = to_mask(cpus);
    return thread == kNumber ? 0 : ESRCH;
  }

  SchedulingPolicy policy;
  int nice = 0;
  CpuSet cpus{0, 1, 2, 3};
  int last_cpu = 3;
  bool may_raise = true;
  int limit = 99;  // of real-time priorities
  bool ignores = false;
  int torn_looks = 0;  // of two moments, so many times
};

class LinuxScheduling : public testing::Test {
 protected:
  LinuxScheduling() {
    tree_.write("sys/devices/system/cpu/online", "0-3\n").write("proc/self/status", "CapEff:\t0\n");
    began_at("1000");
  }
  // When the thread began, as /proc has it: the 22nd field.
  void began_at(const std::string& time) {
    tree_.write("proc/42/stat", "42 (thread) S 1 1 1 0 -1 0 0 0 0 0 0 0 0 0 20 0 1 0 " + time + " 0\n");
  }

  FabricatedTree tree_;
  PlayedKernel kernel_;
  Scheduling scheduling_{tree_.roots(), kernel_};
};

TEST(CpuMasks, HoldEveryCpuThatLinuxCanHave) {
  const int last = static_cast<int>(kMaxCpus) - 1;
  EXPECT_EQ(to_cpu_set(to_mask(CpuSet{0, 63, 64, last})), (CpuSet{0, 63, 64, last}));
  EXPECT_EQ(to_mask(CpuSet{last + 1}), CpuMask{});
  EXPECT_EQ(to_cpu_set(all_cpus()).size(), kMaxCpus);
}

TEST_F(LinuxScheduling, LevelsAreFifoPrioritiesThatChildrenDoNotInherit) {
  ASSERT_TRUE(scheduling_.set_level(kThread, Level::kBackground).ok());
  EXPECT_EQ(kernel_.policy, (SchedulingPolicy{SCHED_FIFO, 1, true}));
  ASSERT_TRUE(scheduling_.set_level(kThread, Level::kDispatcher).ok());
  EXPECT_EQ(kernel_.policy, (SchedulingPolicy{SCHED_FIFO, 4, true}));
  ASSERT_TRUE(scheduling_.set_level(kThread, Level::kOrdinary).ok());
  EXPECT_EQ(kernel_.policy, (SchedulingPolicy{SCHED_OTHER, 0, true}));
}

TEST_F(LinuxScheduling, LevelThatDoesNotTakeIsAnError) {
  kernel_.ignores = true;
  const Status set = scheduling_.set_level(kThread, Level::kActive);
  ASSERT_FALSE(set.ok());
  EXPECT_EQ(set.error().kind(), ErrorKind::kEnvironment);
  EXPECT_THAT(set.error().message(), testing::HasSubstr("took SCHED_FIFO 2 but the thread is SCHED_OTHER"));
}

TEST_F(LinuxScheduling, RefusalSaysHowToBePermitted) {
  kernel_.may_raise = false;
  const Status set = scheduling_.set_level(kThread, Level::kActive);
  ASSERT_FALSE(set.ok());
  EXPECT_THAT(set.error().message(), testing::AllOf(testing::HasSubstr("set level active for thread 42: not permitted"),
                                                    testing::HasSubstr("setcap"), testing::HasSubstr("rtprio")));
}

// Guards: plans with many fixed priorities failed where the limit was enough for those with few.
TEST_F(LinuxScheduling, ALimitBelowTheHighestLevelIsNoPermission) {
  kernel_.limit = kHighestPriority;
  EXPECT_TRUE(scheduling_.try_levels(kThread).ok());
  kernel_.limit = kHighestPriority - 1;
  const Status permitted = scheduling_.try_levels(kThread);
  ASSERT_FALSE(permitted.ok());
  EXPECT_THAT(permitted.error().message(), testing::HasSubstr("rtprio 70"));
  EXPECT_EQ(kernel_.policy.policy, SCHED_OTHER);
}

TEST_F(LinuxScheduling, APolicyAndAPriorityOfTwoMomentsAreReadAgain) {
  kernel_.policy = {SCHED_FIFO, 2, true};
  kernel_.torn_looks = 3;
  const auto saved = scheduling_.save(kThread);
  ASSERT_TRUE(saved) << saved.error().message();
  EXPECT_EQ(saved->policy, SCHED_FIFO);
  EXPECT_EQ(saved->priority, 2);

  kernel_.torn_looks = 1'000'000;
  EXPECT_FALSE(scheduling_.save(kThread)) << "what could not be given back is not saved";
}

TEST_F(LinuxScheduling, AThreadIsRaisedIfItIsAtALevelAboveOrdinaryAsCatanSetsIt) {
  const auto raised = [&] { return Scheduling::is_raised(scheduling_.save(kThread).value()); };
  EXPECT_FALSE(raised());
  for (const Level level : {Level::kBackground, Level::kActive, Level::kDispatcher, fixed_level(0), kHighestLevel}) {
    ASSERT_TRUE(scheduling_.set_level(kThread, level).ok());
    EXPECT_TRUE(raised()) << to_string(level);
  }
  ASSERT_TRUE(scheduling_.set_level(kThread, Level::kOrdinary).ok());
  EXPECT_FALSE(raised());
  // A program's own.
  kernel_.policy = {SCHED_FIFO, 2, false};
  EXPECT_FALSE(raised()) << "which children inherit";
  kernel_.policy = {SCHED_RR, 2, true};
  EXPECT_FALSE(raised());
  kernel_.policy = {SCHED_FIFO, 99, true};
  EXPECT_FALSE(raised());
}

TEST_F(LinuxScheduling, ForeignRealTimePrioritiesAreNoLevel) {
  for (const SchedulingPolicy foreign :
       {SchedulingPolicy{SCHED_FIFO, 90, false}, SchedulingPolicy{SCHED_RR, 1, false}}) {
    kernel_.policy = foreign;
    const auto level = scheduling_.level(kThread);
    ASSERT_FALSE(level.ok());
    EXPECT_THAT(level.error().message(), testing::HasSubstr("none of Catan's levels"));
  }
  for (const int ordinary : {SCHED_OTHER, SCHED_BATCH, SCHED_IDLE}) {
    kernel_.policy = {ordinary, 0, false};
    EXPECT_EQ(scheduling_.level(kThread).value(), Level::kOrdinary);
  }
}

TEST_F(LinuxScheduling, RestoreGivesBackWhatAnotherHadSet) {
  kernel_.policy = {SCHED_RR, 17, false};
  kernel_.nice = -5;
  kernel_.cpus = CpuSet{1, 2};
  const auto saved = scheduling_.save(kThread).value();
  ASSERT_TRUE(scheduling_.set_level(kThread, Level::kActive).ok());
  ASSERT_TRUE(scheduling_.set_affinity(kThread, CpuSet{3}).ok());
  kernel_.nice = 3;
  ASSERT_TRUE(scheduling_.restore(saved).ok());
  EXPECT_EQ(kernel_.policy, (SchedulingPolicy{SCHED_RR, 17, false}));
  EXPECT_EQ(kernel_.nice, -5);
  EXPECT_EQ(kernel_.cpus, (CpuSet{1, 2}));
}

TEST_F(LinuxScheduling, FlagThatMayNotBeClearedStaysWithoutAnError) {
  kernel_.may_raise = false;
  const auto saved = scheduling_.save(kThread).value();
  ASSERT_TRUE(scheduling_.set_level(kThread, Level::kOrdinary).ok());
  const Status restored = scheduling_.restore(saved);
  EXPECT_TRUE(restored.ok()) << restored.error().message();
  EXPECT_EQ(kernel_.policy, (SchedulingPolicy{SCHED_OTHER, 0, true}));
}

TEST_F(LinuxScheduling, RefusedPolicyIsReportedAndTheCpusComeBackAllTheSame) {
  kernel_.policy = {SCHED_FIFO, 50, false};
  const auto saved = scheduling_.save(kThread).value();
  ASSERT_TRUE(scheduling_.set_level(kThread, Level::kOrdinary).ok());
  ASSERT_TRUE(scheduling_.set_affinity(kThread, CpuSet{3}).ok());
  kernel_.may_raise = false;
  EXPECT_FALSE(scheduling_.restore(saved).ok());
  EXPECT_EQ(kernel_.cpus, saved.affinity);
}

TEST_F(LinuxScheduling, AnotherThreadWithTheSameNumberIsNotTouched) {
  const auto saved = scheduling_.save(kThread).value();
  began_at("2000");
  kernel_.policy = {SCHED_RR, 17, false};
  kernel_.nice = -5;
  kernel_.cpus = CpuSet{1};
  const Status restored = scheduling_.restore(saved);
  ASSERT_FALSE(restored.ok());
  EXPECT_THAT(restored.error().message(), testing::HasSubstr("it is gone"));
  EXPECT_EQ(kernel_.policy, (SchedulingPolicy{SCHED_RR, 17, false}));
  EXPECT_EQ(kernel_.nice, -5);
  EXPECT_EQ(kernel_.cpus, CpuSet{1});
}

TEST_F(LinuxScheduling, RefusedNiceIsReported) {
  const auto saved = scheduling_.save(kThread).value();
  kernel_.nice = 10;
  kernel_.may_raise = false;
  EXPECT_FALSE(scheduling_.restore(saved).ok());
}

TEST_F(LinuxScheduling, DeadlineThreadsAreLeftAlone) {
  kernel_.policy = {6, 0, false};
  const auto saved = scheduling_.save(kThread);
  ASSERT_FALSE(saved.ok());
  EXPECT_THAT(saved.error().message(), testing::HasSubstr("SCHED_DEADLINE"));
}

TEST_F(LinuxScheduling, PartOfAnAffinityIsAnErrorThatNamesTheCpusThatAreThere) {
  const Status set = scheduling_.set_affinity(kThread, CpuSet{3, 4});
  ASSERT_FALSE(set.ok());
  EXPECT_THAT(set.error().message(), testing::AllOf(testing::HasSubstr("3-4"), testing::HasSubstr("may use CPUs 3"),
                                                    testing::HasSubstr("(0-3)")));
}

TEST_F(LinuxScheduling, AffinityThatDoesNotTakeIsAnError) {
  kernel_.ignores = true;
  EXPECT_FALSE(scheduling_.set_affinity(kThread, CpuSet{1}).ok());
  EXPECT_TRUE(scheduling_.set_affinity(kThread, CpuSet{0, 1, 2, 3}).ok());
}

TEST_F(LinuxScheduling, RestoreToCpusThatWentAway) {
  kernel_.cpus = CpuSet{2, 3};
  const auto saved = scheduling_.save(kThread).value();
  ASSERT_TRUE(scheduling_.set_affinity(kThread, CpuSet{0}).ok());
  kernel_.last_cpu = 2;
  ASSERT_TRUE(scheduling_.restore(saved).ok());
  EXPECT_EQ(kernel_.cpus, CpuSet{2});
  ASSERT_TRUE(scheduling_.set_affinity(kThread, CpuSet{0}).ok());
  kernel_.last_cpu = 1;
  ASSERT_TRUE(scheduling_.restore(saved).ok());
  EXPECT_EQ(kernel_.cpus, (CpuSet{0, 1}));
}

}  // namespace
}  // namespace ctn::os
