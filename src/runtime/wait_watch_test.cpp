// What runs are said to wait: in virtual time, and on the real system.
#include "runtime/wait_watch.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <vector>

#include "os/fake/fake_os.h"
#include "os/linux/linux_os.h"

namespace ctn::runtime {
namespace {

using namespace std::chrono_literals;

class WaitWatchTest : public ::testing::Test {
 protected:
  // A run that computes, waits and computes; what it is said to have waited.
  Nanos run(Nanos cpu, Nanos wait) {
    watch.begin();
    const TimePoint begin = os.now();
    const Nanos cpu_before = os.thread_cpu_time();
    os.burn(cpu / 2);
    if (wait > Nanos{0}) os.sleep_until(os.now() + wait);
    os.burn(cpu - cpu / 2);
    return watch.end(os.now() - begin, os.thread_cpu_time() - cpu_before);
  }

  os::FakeOs os;
  WaitWatch watch{os};
};

TEST_F(WaitWatchTest, TellsWaitsFromTheFirstOn) {
  EXPECT_EQ(run(2ms, 3ms), 3ms);
  EXPECT_EQ(run(2ms, 3ms), 3ms);
  EXPECT_EQ(run(2ms, 0ms), 0ms);
  EXPECT_EQ(run(2ms, 7ms), 7ms);
  EXPECT_EQ(run(2ms, 20us), 0ms) << "too short to be told from switching";
}

TEST_F(WaitWatchTest, LooksAwayAfterManyRunsWithoutAny) {
  run(1ms, 3ms);
  for (int i = 0; i < WaitWatch::kWatchedRuns; ++i) EXPECT_EQ(run(1ms, 0ms), 0ms);
  EXPECT_EQ(run(1ms, 3ms), 0ms) << "it was not known that it might";
  EXPECT_EQ(run(1ms, 3ms), 3ms);
}

TEST_F(WaitWatchTest, ASystemThatDoesNotTellReadyTimeTellsNoWaits) {
  os.set_tells_ready_time(false);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(run(1ms, 3ms), 0ms);
}

// 4 ms of the run belong to a thread of a higher level, 3 ms to its own wait.
TEST_F(WaitWatchTest, TimeThatOthersHadTheCpuIsNoWait) {
  os.share_cpus(true);
  ASSERT_TRUE(os.set_affinity(os.current_thread(), os::CpuSet{0}).ok());
  run(1ms, 1ms);
  std::vector<Nanos> waits;
  for (const Nanos wait : {Nanos{3ms}, Nanos{0ms}}) {
    const auto other = os.spawn("other", [&] {
      const os::ThreadId self = os.current_thread();
      ASSERT_TRUE(os.set_level(self, os::Level::kActive).ok());
      os.sleep_until(os.now() + 500us);
      os.burn(4ms);
    });
    waits.push_back(run(4ms, wait));
    other->join();
  }
  EXPECT_EQ(waits, (std::vector<Nanos>{3ms, 0ms}));
}

// On the real system: bounds are those that hold however busy the machine is.
TEST(WaitWatchOnTheRealSystem, TellsComputingWaitingAndBeingReadyApart) {
  const auto os = os::make_linux_os();
  if (!os->ready_time()) GTEST_SKIP() << "this kernel does not tell ready time";
  const auto cpus = os->affinity(os->current_thread());
  ASSERT_TRUE(cpus.ok());
  ASSERT_TRUE(os->set_affinity(os->current_thread(), os::CpuSet{cpus->cpus().front()}).ok());
  std::atomic<bool> stop{false};
  const auto other = os->spawn("other", [&] {
    while (!stop) continue;
  });
  WaitWatch watch(*os);
  struct Told {
    Nanos elapsed, cpu, wait;
  };
  const auto run = [&](Nanos wait) {
    watch.begin();
    const TimePoint begin = os->now();
    const Nanos cpu_before = os->thread_cpu_time();
    const auto compute = [&](Nanos cpu) {
      for (const Nanos end = os->thread_cpu_time() + cpu; os->thread_cpu_time() < end;) continue;
    };
    compute(10ms);
    if (wait > Nanos{0}) os->sleep_until(os->now() + wait);
    compute(10ms);
    Told told{os->now() - begin, os->thread_cpu_time() - cpu_before, {}};
    told.wait = watch.end(told.elapsed, told.cpu);
    return told;
  };
  run(10ms);
  for (int i = 0; i < 3; ++i) {
    const Told waited = run(60ms);
    EXPECT_GE(waited.cpu, 20ms);
    EXPECT_GE(waited.wait, 30ms);
    EXPECT_LE(waited.wait, waited.elapsed - waited.cpu);
    const Told pre_empted = run(0ms);
    EXPECT_GE(pre_empted.elapsed - pre_empted.cpu, 5ms) << "the other thread had half of the CPU";
    EXPECT_EQ(pre_empted.wait, 0ms);
  }
  stop = true;
  other->join();
  ASSERT_TRUE(os->set_affinity(os->current_thread(), *cpus).ok());
}

// What the system opens to be asked is open after the first run, and none later pays for it.
TEST(WaitWatchOnTheRealSystem, OpensNothingAfterTheFirstRun) {
  const auto count_files = [] {
    const std::filesystem::directory_iterator files("/proc/self/fd");
    return std::distance(begin(files), end(files));
  };
  const auto os = os::make_linux_os();
  const auto before = count_files();
  std::vector<std::ptrdiff_t> counts;
  const auto node = os->spawn("node", [&] {
    WaitWatch watch(*os);
    for (int i = 0; i < 3; ++i) {
      watch.begin();
      os->sleep_until(os->now() + 1ms);
      watch.end(1ms, 0ms);
      counts.push_back(count_files());
    }
  });
  node->join();
  EXPECT_EQ(counts, std::vector<std::ptrdiff_t>(3, counts.at(0)));
  EXPECT_LE(counts.at(0), before + 1);
  EXPECT_EQ(count_files(), before);
}

}  // namespace
}  // namespace ctn::runtime
