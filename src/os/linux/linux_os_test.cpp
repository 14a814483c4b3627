// What is promised on Linux beyond os.h, on the machine as it is.
#include "os/linux/linux_os.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <new>
#include <thread>

#include "os/linux/forked_process.h"
#include "os/linux/kernel_calls.h"
#include "os/linux/testing/fabricated_tree.h"
#include "os/scheduling_guard.h"
#include "os/testing/conformance.h"
#include "os/testing/requires_real_time.h"

namespace ctn::os {
namespace {

using namespace std::chrono_literals;
using conformance::kTimeout;

using Word = std::atomic<std::uint32_t>;

// Words in memory that a forked child shares.
struct SharedWords {
  Word child_ready{0};
  Word stop{0};
};

class SharedMapping {
 public:
  SharedMapping() {
    void* const memory =
        ::mmap(nullptr, sizeof(SharedWords), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    words_ = memory == MAP_FAILED ? nullptr : new (memory) SharedWords;
  }
  ~SharedMapping() {
    if (words_) ::munmap(words_, sizeof(SharedWords));
  }
  SharedMapping(const SharedMapping&) = delete;
  SharedMapping& operator=(const SharedMapping&) = delete;
  SharedWords* operator->() const { return words_; }
  explicit operator bool() const { return words_ != nullptr; }

 private:
  SharedWords* words_ = nullptr;
};

class LinuxOsTest : public testing::Test {
 protected:
  TimePoint soon() { return os_->now() + kTimeout; }

  std::unique_ptr<Os> os_ = make_linux_os();
};

TEST_F(LinuxOsTest, WordsMayBeSharedBetweenProcesses) {
  SharedMapping words;
  ASSERT_TRUE(words);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    words->child_ready = 1;
    os_->wake(words->child_ready);
    const bool woken = os_->wait(words->stop, 0, soon()) == WaitResult::kChanged;
    ::_exit(woken ? 0 : 1);
  }
  EXPECT_EQ(os_->wait(words->child_ready, 0, soon()), WaitResult::kChanged);
  os_->sleep_until(os_->now() + 5ms);
  words->stop = 1;
  os_->wake(words->stop);
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

// A server schedules the threads of other processes.
TEST_F(LinuxOsTest, ThreadsOfAnotherProcess) {
  SharedMapping words;
  ASSERT_TRUE(words);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const TimePoint give_up = soon();
    while (os_->thread_cpu_time() < 30ms && os_->now() < give_up) continue;
    words->child_ready = 1;
    os_->wake(words->child_ready);
    os_->wait(words->stop, 0, soon());
    ::_exit(0);
  }
  EXPECT_EQ(os_->wait(words->child_ready, 0, soon()), WaitResult::kChanged);
  os_->sleep_until(os_->now() + 20ms);  // its clock is up to date once it has blocked
  const auto threads = os_->threads(ProcessId{child});
  const auto used = os_->thread_cpu_time(ThreadId{child});
  const auto clock = os_->cpu_clock(ThreadId{child});
  const std::optional<Nanos> by_clock = clock ? (*clock)->now() : std::nullopt;
  const std::optional<Nanos> ready = os_->ready_time(ThreadId{child});
  const std::string name = os_->thread_name(ThreadId{child});
  const Status set = os_->set_level(ThreadId{child}, Level::kOrdinary);
  words->stop = 1;
  os_->wake(words->stop);
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  ASSERT_TRUE(threads.ok());
  EXPECT_THAT(*threads, testing::Contains(ThreadId{child}));  // a sanitizer adds its own
  EXPECT_TRUE(set.ok());
  ASSERT_TRUE(used.ok()) << used.error().message();
  EXPECT_GE(*used, 25ms);
  ASSERT_TRUE(by_clock);
  EXPECT_GE(*by_clock, *used);
  EXPECT_EQ(ready.has_value(), os_->ready_time().has_value());
  EXPECT_EQ(name, os_->thread_name(os_->current_thread())) << "a child has its maker's";
  EXPECT_FALSE((*clock)->now()) << "it has ended";
  EXPECT_FALSE(os_->threads(ProcessId{child}).ok());
}

// Two threads on one CPU, woken at once: the one that comes last was ready while the other worked.
TEST_F(LinuxOsTest, WhoWaitsForACpuIsReady) {
  if (!os_->ready_time()) GTEST_SKIP() << "this kernel does not tell";
  const auto cpus = os_->affinity(os_->current_thread());
  ASSERT_TRUE(cpus.ok());
  const CpuSet one{cpus->cpus().front()};
  std::atomic<std::uint32_t> go{0};
  std::array<Nanos, 2> ready{};
  std::vector<std::unique_ptr<Thread>> workers;
  for (Nanos& each : ready) {
    workers.push_back(os_->spawn("worker", [&] {
      ASSERT_TRUE(os_->set_affinity(os_->current_thread(), one).ok());
      os_->wait(go, 0, soon());
      const Nanos before = os_->ready_time().value_or(Nanos{0});
      const std::uint64_t blocked = os_->times_blocked();
      const Nanos end = os_->thread_cpu_time() + 40ms;
      for (const TimePoint give_up = soon(); os_->thread_cpu_time() < end && os_->now() < give_up;) continue;
      each = os_->ready_time(os_->current_thread()).value_or(Nanos{0}) - before;
      EXPECT_EQ(os_->times_blocked(), blocked) << "the CPU was taken from it";
    }));
  }
  os_->sleep_until(os_->now() + 20ms);
  go = 1;
  os_->wake(go);
  workers.clear();
  EXPECT_GE(std::max(ready[0], ready[1]), 10ms);
}

TEST_F(LinuxOsTest, ChildOfAForkHasItsOwnNumber) {
  os_->current_thread();
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) ::_exit(static_cast<pid_t>(os_->current_thread()) == ::getpid() ? 0 : 1);
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

TEST_F(LinuxOsTest, NamesAreCutWhereTheKernelDoes) {
  std::string name;
  os_->spawn("perception.detector",
             [&] {
               const auto self = std::to_string(static_cast<int>(os_->current_thread()));
               name = read_line("/proc/self/task/" + self + "/comm").value_or("");
             })
      ->join();
  EXPECT_EQ(name, "perception.dete");
}

// Libraries make threads of their own from a node's thread.
TEST_F(LinuxOsTest, ThreadsThatLibrariesMakeStartOrdinary) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  std::optional<Level> made;
  std::thread([&] {
    SchedulingGuard guard(*os_, os_->current_thread());
    if (!os_->set_level(os_->current_thread(), Level::kBackground).ok()) return;
    std::thread([&] {
      const auto level = os_->level(os_->current_thread());
      if (level.ok()) made = *level;
    }).join();
  }).join();
  EXPECT_EQ(made, Level::kOrdinary);
}

TEST_F(LinuxOsTest, SpawnIsOrdinaryEvenUnderAForeignRealTimePriority) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  KernelCalls kernel;
  std::optional<Level> made;
  int error = 0;
  std::thread([&] {
    const auto self = static_cast<pid_t>(os_->current_thread());
    error = kernel.set_policy(self, {SCHED_FIFO, 1, false});
    if (error != 0) return;
    const auto child = os_->spawn("child", [&] {
      const auto level = os_->level(os_->current_thread());
      if (level.ok()) made = *level;
    });
    child->join();
    kernel.set_policy(self, {SCHED_OTHER, 0, false});
  }).join();
  ASSERT_EQ(error, 0);
  EXPECT_EQ(made, Level::kOrdinary);
}

TEST_F(LinuxOsTest, WithoutPermissionRaisingFailsAndSaysWhatToDo) {
  ForkedProcess unprivileged([&] {
    const rlimit none{0, 0};
    if (::setrlimit(RLIMIT_RTPRIO, &none) != 0) return 2;
    if (::getuid() == 0 && !become_nobody()) return 2;
    const auto os = make_linux_os();
    const RealTimeFacts facts = os->real_time_facts();
    if (facts.permitted) return 2;
    const Status raised = os->set_level(os->current_thread(), Level::kActive);
    if (facts.why_not.empty() || raised.ok()) return 3;
    const Error& error = raised.error();
    if (error.kind() != ErrorKind::kEnvironment || error.problems().front().hint.empty()) return 4;
    return os->level(os->current_thread()).value() == Level::kOrdinary ? 0 : 5;
  });
  const int exit_code = unprivileged.join();
  CATAN_REQUIRE(exit_code != 2, "needs a process that can give the permission up: run it as root");
  EXPECT_EQ(exit_code, 0);
}

TEST_F(LinuxOsTest, NiceSurvivesAllLevels) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  KernelCalls kernel;
  std::optional<SavedScheduling> before;
  std::optional<SavedScheduling> after;
  int nice_between = 0;
  std::thread([&] {
    const ThreadId self = os_->current_thread();
    kernel.set_nice(static_cast<pid_t>(self), 7);
    before = os_->save_scheduling(self).value();
    {
      SchedulingGuard guard(*os_, self);
      static_cast<void>(os_->set_level(self, Level::kActive));
      static_cast<void>(os_->set_level(self, Level::kOrdinary));
      kernel.get_nice(static_cast<pid_t>(self), nice_between);
    }
    after = os_->save_scheduling(self).value();
    after->reset_on_fork = before->reset_on_fork;  // not every process may clear it
  }).join();
  EXPECT_EQ(nice_between, 7);
  EXPECT_EQ(before, after);
}

TEST_F(LinuxOsTest, ThreadsOfAMadeUpProcess) {
  FabricatedTree tree;
  for (const char* entry : {"12/stat", "7/stat", "odd/stat", "130/stat"}) {
    tree.write(std::string("proc/7/task/") + entry, "");
  }
  tree.write("proc/8/task/none", "");
  const auto os = make_linux_os(tree.roots());
  EXPECT_THAT(os->threads(ProcessId{7}).value(), testing::ElementsAre(ThreadId{7}, ThreadId{12}, ThreadId{130}));
  EXPECT_FALSE(os->threads(ProcessId{8}).ok());
}

TEST_F(LinuxOsTest, RealTimeFactsHoldForThisMachine) {
  const RealTimeFacts facts = os_->real_time_facts();
  RecordProperty("permitted", facts.permitted ? "yes" : facts.why_not);
  RecordProperty("reserved_by", facts.reserved_by);
  EXPECT_THAT(facts.reserved_by, testing::AnyOf("fair server", "fair server (assumed default)", "throttling",
                                                "throttling (assumed default)", "nothing"));
}

TEST_F(LinuxOsTest, SurvivesAMachineWithoutProcAndSys) {
  const auto os = make_linux_os({"/nowhere/sys", "/nowhere/proc"});
  EXPECT_FALSE(os->topology().ok());
  EXPECT_FALSE(os->threads(os->current_process()).ok());
  EXPECT_EQ(os->host_facts().cpu_model, "");
  EXPECT_GT(os->real_time_facts().reserved, 0.0);
  EXPECT_TRUE(os->thread_cpu_time(os->current_thread()).ok());
}

}  // namespace
}  // namespace ctn::os
