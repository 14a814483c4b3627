// The guardian on the machine as it is. What it is for, a server that is killed while other processes' threads are at
// real-time levels, is tried with processes made for that; how fast, in tests/guardian_test.cpp.
#include "os/linux/guardian.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <functional>
#include <memory>
#include <thread>

#include "os/linux/descriptor.h"
#include "os/linux/files.h"
#include "os/linux/forked_process.h"
#include "os/linux/guardian_process.h"
#include "os/linux/kernel_calls.h"
#include "os/linux/linux_os.h"
#include "os/linux/process.h"
#include "os/linux/testing/fabricated_tree.h"
#include "os/testing/requires_real_time.h"

namespace ctn::os {
namespace {

using namespace std::chrono_literals;

// Whether it has ended, though the init process that inherited it may not have looked yet.
bool has_ended(pid_t process) {
  const std::string status = read_text(fmt::format("/proc/{}/status", process)).value_or("");
  return find_value(status, "State").value_or("Z").starts_with("Z");
}

// The guardians among a process's children.
std::vector<pid_t> guardians_of(pid_t parent) {
  std::vector<pid_t> found;
  for (const int process : numbered_entries("/proc", "").value_or(std::vector<int>())) {
    const std::string status = read_text(fmt::format("/proc/{}/status", process)).value_or("");
    if (find_value(status, "PPid") == std::to_string(parent) && find_value(status, "Name") == "catan-guard") {
      found.push_back(process);
    }
  }
  return found;
}

bool is_running(pid_t process) { return ::kill(process, 0) == 0; }

class LinuxGuardianTest : public testing::Test {
 protected:
  // Patiently.
  bool becomes(const std::function<bool()>& condition) {
    for (const TimePoint end = os_->now() + 30s; os_->now() < end; os_->sleep_until(os_->now() + 1ms)) {
      if (condition()) return true;
    }
    return false;
  }
  SavedScheduling scheduling(pid_t thread) { return os_->save_scheduling(ThreadId{thread}).value(); }

  std::unique_ptr<Os> os_ = make_linux_os();
  KernelCalls kernel_;
};

TEST_F(LinuxGuardianTest, IsAProcessThatHoldsNothing) {
  const Descriptor ours(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  const auto guardian = start_guardian();
  ASSERT_TRUE(guardian.ok()) << guardian.error().message();
  const auto found = guardians_of(::getpid());
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(::getsid(found[0]), found[0]);
  EXPECT_LE(numbered_entries(fmt::format("/proc/{}/fd", found[0]), "").value().size(), 3U);
  for (const int number : {SIGTERM, SIGINT, SIGHUP, SIGQUIT, SIGUSR1, SIGTSTP}) ::kill(found[0], number);
  os_->sleep_until(os_->now() + 5ms);
  EXPECT_EQ(guardians_of(::getpid()), found);
  EXPECT_TRUE((*guardian)->ensure_running().ok());
  EXPECT_EQ((*guardian)->replaced(), 0);
}

TEST_F(LinuxGuardianTest, EndsWithoutATraceWhenAllIsForgotten) {
  ForkedProcess client([] { return ::pause(); });
  const SavedScheduling before = scheduling(client.number());
  pid_t process = 0;
  {
    const auto guardian = start_guardian().value();
    process = guardians_of(::getpid()).at(0);
    ASSERT_TRUE(guardian->watch(before));
    ASSERT_EQ(kernel_.set_nice(client.number(), 7), 0);
    guardian->forget(ThreadId{client.number()});
  }
  EXPECT_FALSE(is_running(process));  // nor is there a zombie
  EXPECT_EQ(scheduling(client.number()).nice, 7);
}

// A thread of a killed server may set something after another has ended already.
TEST_F(LinuxGuardianTest, SetsEverythingAgainUntilAllOfTheServerIsGone) {
  ForkedProcess client([] { return ::pause(); });
  const auto table = std::make_unique<GuardianTable>();  // the fork copies it
  WatchedThread& watched = table->threads.at(0);
  watched.saved.thread = ThreadId{client.number()};
  watched.saved.started = start_time(watched.saved.thread, {}).value();
  watched.saved.nice = 3;
  watched.published = 1;
  std::array<int, 2> ends{-1, -1};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
  Descriptor ours(ends[0]);
  Descriptor theirs(ends[1]);
  sigset_t all{};
  sigset_t before{};
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  std::atomic<bool> last{false};
  pid_t process = 0;
  std::thread forker([&] {
    process = ::fork();
    if (process == 0) run_guardian(*table, "/proc", theirs.number(), -1);
    while (!last) std::this_thread::sleep_for(1ms);
  });
  char ready = 0;
  EXPECT_EQ(::recv(ours.number(), &ready, 1, 0), 1);
  theirs = {};
  EXPECT_NE(scheduling(client.number()).nice, 3);
  last = true;
  forker.join();
  for (int round = 0; round < 5; ++round) {
    EXPECT_TRUE(becomes([&] { return scheduling(client.number()).nice == 3; }));
    EXPECT_EQ(kernel_.set_nice(client.number(), 5), 0);
  }
  EXPECT_TRUE(becomes([&] { return scheduling(client.number()).nice == 3; }));
  EXPECT_FALSE(has_ended(process));
  ours = {};
  EXPECT_EQ(::waitpid(process, nullptr, 0), process);
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

TEST_F(LinuxGuardianTest, OneThatIsStoppedIsNotWaitedForLong) {
  pid_t process = 0;
  {
    const auto guardian = start_guardian().value();
    process = guardians_of(::getpid()).at(0);
    ::kill(process, SIGSTOP);
  }
  EXPECT_FALSE(is_running(process));
}

TEST_F(LinuxGuardianTest, OneThatWasKilledIsReplacedAndTheNextKnowsAll) {
  ForkedProcess client([] { return ::pause(); });
  const SavedScheduling before = scheduling(client.number());
  const CpuSet last{before.affinity.cpus().back()};
  pid_t second = 0;
  {
    const auto guardian = start_guardian().value();
    ASSERT_TRUE(guardian->watch(before));
    ASSERT_TRUE(os_->set_affinity(ThreadId{client.number()}, last).ok());
    const pid_t first = guardians_of(::getpid()).at(0);
    ::kill(first, SIGKILL);
    ASSERT_TRUE(becomes([&] {
      EXPECT_TRUE(guardian->ensure_running().ok());
      return guardian->replaced() == 1;
    }));
    EXPECT_FALSE(is_running(first));
    ASSERT_TRUE(becomes([&] { return guardians_of(::getpid()).size() == 1; }));
    second = guardians_of(::getpid()).at(0);
    EXPECT_EQ(scheduling(client.number()).affinity, last);
  }
  EXPECT_FALSE(is_running(second));
  EXPECT_EQ(scheduling(client.number()), before);
}

TEST_F(LinuxGuardianTest, HasRoomForAThousandAndSaysWhenItIsFull) {
  FabricatedTree tree;
  const std::string stat = read_text("/proc/self/stat").value();
  for (std::size_t i = 1; i <= kMaxWatched + 1; ++i) tree.write(fmt::format("proc/{}/stat", 1'000'000'000 + i), stat);
  const auto guardian = start_guardian(tree.roots()).value();
  const SavedScheduling before = scheduling(::getpid());
  const auto thread = [](std::size_t i) { return ThreadId{static_cast<std::int32_t>(1'000'000'000 + i)}; };
  const auto watch = [&](std::size_t i) {
    SavedScheduling saved = before;
    saved.thread = thread(i);
    return guardian->watch(saved);
  };
  for (std::size_t i = 1; i <= kMaxWatched; ++i) ASSERT_TRUE(watch(i));
  EXPECT_FALSE(watch(kMaxWatched + 1));
  guardian->forget(thread(5));
  EXPECT_TRUE(watch(kMaxWatched + 1));
  for (std::size_t i = 1; i <= kMaxWatched + 1; ++i) guardian->forget(thread(i));
}

TEST_F(LinuxGuardianTest, WhatItCouldNotGiveBackIsNotWatched) {
  const auto guardian = start_guardian().value();
  SavedScheduling before = scheduling(::getpid());
  before.affinity = CpuSet{static_cast<int>(kMaxCpus)};
  EXPECT_FALSE(guardian->watch(before));
}

// A number that has passed on to another thread is another's business.
TEST_F(LinuxGuardianTest, ThreadThatOnlyHasTheSameNumberIsLeftAlone) {
  ForkedProcess client([] { return ::pause(); });
  FabricatedTree tree;
  const std::string file = fmt::format("proc/{}/stat", client.number());
  const std::string stat = read_text(fmt::format("/proc/{}/stat", client.number())).value();
  tree.write(file, stat);
  const SavedScheduling before = scheduling(client.number());
  {
    const auto guardian = start_guardian(tree.roots()).value();
    ASSERT_TRUE(guardian->watch(before));
    ASSERT_EQ(kernel_.set_nice(client.number(), 7), 0);
    // Another start time: the 22nd field.
    std::string other = stat;
    std::size_t at = other.rfind(')');
    for (int field = 2; field < 22; ++field) at = other.find(' ', at + 1);
    other.insert(at + 1, "9");
    tree.write(file, other);
  }
  EXPECT_EQ(scheduling(client.number()).nice, 7);
}

// ---- A server that is killed

class KilledServer : public LinuxGuardianTest {
 protected:
  // A server that watches the thread, changes it, and is killed at some time after that.
  template <class Change>
  void change_and_be_killed(pid_t thread, Change change) {
    const SyncPipe ready;
    ForkedProcess server([&] {
      const auto guardian = os_->start_guardian().value();
      const bool watched = guardian->watch(scheduling(thread));
      if (!watched || !change()) return 1;
      ready.send();
      return ::pause();
    });
    ASSERT_TRUE(ready.receive().has_value());
    guardian_ = guardians_of(server.number()).at(0);
    EXPECT_EQ(server.end(SIGKILL), -SIGKILL);
  }

  pid_t guardian_ = 0;
};

TEST_F(KilledServer, AllThatWasSetIsRestored) {
  ForkedProcess client([] { return ::pause(); });
  const pid_t thread = client.number();
  ASSERT_EQ(kernel_.set_nice(thread, 3), 0);
  const SavedScheduling before = scheduling(thread);
  const bool permitted = os_->real_time_facts().permitted;
  change_and_be_killed(thread, [&] {
    const CpuSet last{before.affinity.cpus().back()};
    return kernel_.set_nice(thread, 9) == 0 && os_->set_affinity(ThreadId{thread}, last).ok() &&
           (!permitted || os_->set_level(ThreadId{thread}, Level::kActive).ok());
  });
  EXPECT_TRUE(becomes([&] {
    SavedScheduling now = scheduling(thread);
    if (!permitted) now.reset_on_fork = before.reset_on_fork;
    if (!permitted) now.nice = before.nice;  // raising it again needs the same privilege
    return now == before;
  }));
  EXPECT_TRUE(becomes([&] { return has_ended(guardian_); }));
}

TEST_F(KilledServer, PolicyThatAnotherGaveTheThreadIsGivenBackToo) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  ForkedProcess client([] { return ::pause(); });
  const pid_t thread = client.number();
  ASSERT_EQ(kernel_.set_policy(thread, {SCHED_RR, 17, false}), 0);
  const SavedScheduling before = scheduling(thread);
  change_and_be_killed(thread, [&] { return os_->set_level(ThreadId{thread}, Level::kBackground).ok(); });
  EXPECT_TRUE(becomes([&] { return scheduling(thread) == before; }));
}

TEST_F(KilledServer, ChildThatKeepsEverythingOpenChangesNothing) {
  ForkedProcess client([] { return ::pause(); });
  const pid_t thread = client.number();
  const SavedScheduling before = scheduling(thread);
  const SyncPipe kept;
  change_and_be_killed(thread, [&] {
    const pid_t keeper = ::fork();
    if (keeper == 0) ::_exit(::pause());
    kept.send(keeper);
    return os_->set_affinity(ThreadId{thread}, CpuSet{before.affinity.cpus().back()}).ok();
  });
  const auto keeper = kept.receive();
  ASSERT_TRUE(keeper.has_value());
  EXPECT_TRUE(becomes([&] { return scheduling(thread) == before; }));
  ::kill(*keeper, SIGKILL);
}

TEST_F(KilledServer, KilledInTheMiddleOfWatchingItLeavesNothingHalfDone) {
  ForkedProcess client([] { return ::pause(); });
  const pid_t thread = client.number();
  ASSERT_EQ(kernel_.set_nice(thread, 3), 0);
  const SavedScheduling before = scheduling(thread);
  CATAN_REQUIRE(before.affinity.size() >= 2, "needs two CPUs: let it use more (taskset)");
  CATAN_REQUIRE_REAL_TIME(*os_);  // with it comes the one to lower nice values
  for (int round = 0; round < 40; ++round) {
    const SyncPipe ready;
    ForkedProcess server([&] {
      const auto guardian = os_->start_guardian().value();
      for (bool said = false;; said = true) {
        // Either of these is what the thread had; a mixture is not.
        SavedScheduling other = before;
        other.nice = 4;
        other.affinity = CpuSet{before.affinity.cpus().front()};
        guardian->watch(other);
        guardian->forget(ThreadId{thread});
        guardian->watch(before);
        if (!said) ready.send();
      }
      return 0;
    });
    ASSERT_TRUE(ready.receive().has_value());
    const pid_t guardian = guardians_of(server.number()).at(0);
    std::this_thread::sleep_for(std::chrono::microseconds(37 * round));
    server.end(SIGKILL);
    ASSERT_TRUE(becomes([&] { return has_ended(guardian); }));
    const SavedScheduling now = scheduling(thread);
    ASSERT_EQ(now.nice == 4, now.affinity.size() == 1) << "nice " << now.nice << ", CPUs " << to_string(now.affinity);
    ASSERT_EQ(kernel_.set_nice(thread, before.nice), 0);
    ASSERT_TRUE(os_->set_affinity(ThreadId{thread}, before.affinity).ok());
  }
}

}  // namespace
}  // namespace ctn::os
