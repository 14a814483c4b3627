// What os.h promises, checked on every implementation. A new port adds its line at the end of this file. Levels,
// guardians and CPUs: conformance_scheduling_test.cpp.
//
// On a real system nothing here fails for being slow: bounds are lower ones, and upper ones only keep a broken
// implementation from hanging. Tests that raise a thread do so for a few calls, under a guard that gives the level
// back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "os/os.h"
#include "os/scheduling_guard.h"
#include "os/testing/conformance_suite.h"

namespace ctn::os::conformance {
namespace {

using namespace std::chrono_literals;

// ---- Time

TEST_P(OsConformance, TimeNeverGoesBack) {
  TimePoint last = os().now();
  for (int i = 0; i < 1000; ++i) {
    const TimePoint time = os().now();
    ASSERT_GE(time, last);
    last = time;
  }
}

TEST_P(OsConformance, AThreadIsOnACpuThatItMayUse) {
  const Result<CpuSet> mine = os().affinity(os().current_thread());
  ASSERT_TRUE(mine.ok());
  EXPECT_TRUE(mine->contains(os().current_cpu()));
}

TEST_P(OsConformance, StolenTimeIsToldOfCpusThatThereAreAndNeverFalls) {
  const auto before = os().stolen_time();
  const auto after = os().stolen_time();
  const auto online = os().online_cpus();
  ASSERT_TRUE(online.ok());
  for (const auto& [cpu, stolen] : before) {
    EXPECT_TRUE(online->contains(cpu)) << cpu;
    ASSERT_TRUE(after.contains(cpu));
    EXPECT_GE(stolen, Nanos{0});
    EXPECT_GE(after.at(cpu), stolen);
  }
}

TEST_P(OsConformance, PowerIsToldOfTheCpusAskedFor) {
  const CpuSet none;
  EXPECT_TRUE(os().power_state(none).cpus.empty());
  EXPECT_EQ(os().power_state(none), os().power_state(none));
}

TEST_P(OsConformance, SleepIsNotEarly) {
  const TimePoint deadline = os().now() + 3ms;
  os().sleep_until(deadline);
  EXPECT_GE(os().now(), deadline);
}

// Not even for as long as the deadline lies back. In virtual time that is no time at all.
TEST_P(OsConformance, SleepUntilThePastReturnsAtOnce) {
  const TimePoint begin = os().now();
  os().sleep_until(begin - 2 * kTimeout);
  os().sleep_until(TimePoint{Nanos{-5}});
  os().sleep_until(begin);
  EXPECT_LE(os().now() - begin, at_once());
}

TEST_P(OsConformance, CpuTimeCountsWorkNotSleep) {
  const Nanos start = os().thread_cpu_time();
  work(5ms);
  const Nanos worked = os().thread_cpu_time();
  EXPECT_GE(worked - start, 5ms);
  os().sleep_until(os().now() + 50ms);
  EXPECT_LT(os().thread_cpu_time() - worked, 50ms);
}

TEST_P(OsConformance, CpuTimeOfAnotherThread) {
  std::atomic<std::uint32_t> id{0};
  std::atomic<std::uint32_t> stop{0};
  const auto worker = os().spawn("worker", [&] {
    work(5ms);
    id = static_cast<std::uint32_t>(os().current_thread());
    os().wake(id);
    os().wait(stop, 0, soon());
  });
  os().wait(id, 0, soon());
  const auto used = os().thread_cpu_time(ThreadId{static_cast<std::int32_t>(id.load())});
  stop = 1;
  os().wake(stop);
  ASSERT_TRUE(used.ok()) << used.error().message();
  EXPECT_GE(*used, 5ms);
}

TEST_P(OsConformance, CpuTimeOfItselfByNumber) {
  work(2ms);
  const Nanos before = os().thread_cpu_time();
  const auto by_number = os().thread_cpu_time(os().current_thread());
  ASSERT_TRUE(by_number.ok());
  EXPECT_GE(*by_number, before);
  EXPECT_LE(*by_number, os().thread_cpu_time());
}

TEST_P(OsConformance, ACpuClockGoesOnAndEndsWithItsThread) {
  std::atomic<std::uint32_t> id{0};
  std::atomic<std::uint32_t> stop{0};
  const auto worker = os().spawn("worker", [&] {
    id = static_cast<std::uint32_t>(os().current_thread());
    os().wake(id);
    os().wait(stop, 0, soon());
    work(5ms);
  });
  os().wait(id, 0, soon());
  const auto clock = os().cpu_clock(ThreadId{static_cast<std::int32_t>(id.load())});
  ASSERT_TRUE(clock.ok()) << clock.error().message();
  const std::optional<Nanos> before = (*clock)->now();
  ASSERT_TRUE(before);
  stop = 1;
  os().wake(stop);
  std::optional<Nanos> last = before;
  for (std::optional<Nanos> now = before; now && os().now() < soon(); now = (*clock)->now()) {
    EXPECT_GE(*now, *last);
    last = now;
    if (*now >= *before + 5ms) break;
    os().sleep_until(os().now() + 1ms);
  }
  EXPECT_GT(*last, *before);
  worker->join();
  // The kernel lets go of it a moment after.
  for (const TimePoint end = soon(); (*clock)->now() && os().now() < end;) os().sleep_until(os().now() + 1ms);
  EXPECT_FALSE((*clock)->now());
}

// What is taken from a thread does not count as blocked; a sleep does.
TEST_P(OsConformance, BlockingIsCounted) {
  const std::uint64_t before = os().times_blocked();
  work(1ms);
  os().sleep_until(os().now() + 1ms);
  const std::uint64_t after = os().times_blocked();
  EXPECT_GT(after, before);
  os().sleep_until(os().now() + 1ms);
  EXPECT_GT(os().times_blocked(), after);
}

TEST_P(OsConformance, ReadyTimeIsPartOfTheTimeThatPasses) {
  // A kernel that counts by ticks (10 ms at 100 Hz) knows nothing of a thread that none has met so far.
  for (const TimePoint met = os().now() + 100ms; !os().ready_time() && os().now() < met;) work(1ms);
  const TimePoint begin = os().now();
  const std::optional<Nanos> before = os().ready_time();
  const Nanos cpu_before = os().thread_cpu_time();
  work(2ms);
  os().sleep_until(os().now() + 1ms);
  const std::optional<Nanos> after = os().ready_time();
  ASSERT_EQ(before.has_value(), after.has_value());
  if (!before) GTEST_SKIP() << "this system does not tell";
  EXPECT_GE(*after, *before);
  const Nanos worked = os().thread_cpu_time() - cpu_before;
  const Nanos passed = os().now() - begin;
  // The kernel takes both from clocks of CPUs, and those of two CPUs may be a tick apart (10 ms at 100 Hz) where a
  // thread moves from one to the other.
  EXPECT_LE(*after - *before + worked, passed + 10ms);
}

TEST_P(OsConformance, ReadyTimeOfItselfByNumber) {
  for (const TimePoint met = os().now() + 100ms; !os().ready_time() && os().now() < met;) work(1ms);
  const std::optional<Nanos> before = os().ready_time();
  const std::optional<Nanos> by_number = os().ready_time(os().current_thread());
  const std::optional<Nanos> after = os().ready_time();
  ASSERT_EQ(before.has_value(), by_number.has_value());
  if (!before || !after) GTEST_SKIP() << "this system does not tell";
  EXPECT_GE(*by_number, *before);
  EXPECT_LE(*by_number, *after);
}

// ---- Waiting

TEST_P(OsConformance, WaitReturnsAtOnceWhenTheWordDiffers) {
  const std::atomic<std::uint32_t> word{1};
  EXPECT_EQ(os().wait(word, 0, kNever), WaitResult::kChanged);
  EXPECT_EQ(os().wait(word, 0, os().now() - 1s), WaitResult::kChanged);
}

TEST_P(OsConformance, WaitTimesOutNotEarly) {
  const std::atomic<std::uint32_t> word{7};
  const TimePoint deadline = os().now() + 3ms;
  EXPECT_EQ(os().wait(word, 7, deadline), WaitResult::kTimedOut);
  EXPECT_GE(os().now(), deadline);
  EXPECT_EQ(os().wait(word, 7, os().now() - 1s), WaitResult::kTimedOut);
  EXPECT_EQ(os().wait(word, 7, TimePoint{Nanos{-5}}), WaitResult::kTimedOut);
}

TEST_P(OsConformance, WakeReachesAllWaiters) {
  std::atomic<std::uint32_t> word{0};
  std::array<WaitResult, 3> results{WaitResult::kTimedOut, WaitResult::kTimedOut, WaitResult::kTimedOut};
  std::vector<std::unique_ptr<Thread>> waiters;
  waiters.reserve(results.size());
  for (WaitResult& result : results) {
    waiters.push_back(os().spawn("waiter", [&] { result = os().wait(word, 0, soon()); }));
  }
  os().sleep_until(os().now() + 5ms);
  word = 1;
  os().wake(word);
  for (const auto& waiter : waiters) waiter->join();
  EXPECT_THAT(results, testing::Each(WaitResult::kChanged));
}

TEST_P(OsConformance, WaitWithoutADeadlineIsWoken) {
  std::atomic<std::uint32_t> word{0};
  WaitResult result = WaitResult::kTimedOut;
  const auto waiter = os().spawn("waiter", [&] { result = os().wait(word, 0, kNever); });
  os().sleep_until(os().now() + 2ms);
  word = 1;
  os().wake(word);
  waiter->join();
  EXPECT_EQ(result, WaitResult::kChanged);
}

TEST_P(OsConformance, WhoWaitsForAWakeIsWokenWithoutAChange) {
  std::atomic<std::uint32_t> word{0};
  std::atomic<bool> told{false};
  std::atomic<bool> returned{false};
  os().wait_for_wake(word, 1);  // it differs
  const auto waiter = os().spawn("waiter", [&] {
    while (!told) os().wait_for_wake(word, 0);
    returned = true;
  });
  os().sleep_until(os().now() + 5ms);
  EXPECT_FALSE(returned);
  told = true;
  // It may have looked before, and wait only now.
  while (!returned) {
    os().wake(word);
    os().sleep_until(os().now() + 1ms);
  }
  waiter->join();
}

TEST_P(OsConformance, WakeWithoutAChangeIsAbsorbed) {
  const std::atomic<std::uint32_t> word{0};
  const TimePoint deadline = os().now() + 30ms;
  WaitResult result = WaitResult::kChanged;
  TimePoint returned{};
  const auto waiter = os().spawn("waiter", [&] {
    result = os().wait(word, 0, deadline);
    returned = os().now();
  });
  for (int i = 0; i < 5; ++i) {
    os().sleep_until(os().now() + 2ms);
    os().wake(word);
  }
  waiter->join();
  EXPECT_EQ(result, WaitResult::kTimedOut);
  EXPECT_GE(returned, deadline);
}

// ---- Threads

TEST_P(OsConformance, ThreadsAreListedWhileTheyLive) {
  Parked parked(os());
  const ThreadId self = os().current_thread();
  EXPECT_NE(parked.id(), self);
  EXPECT_EQ(os().current_thread(), self);
  const auto live = os().threads(os().current_process());
  ASSERT_TRUE(live.ok()) << live.error().message();
  EXPECT_TRUE(std::is_sorted(live->begin(), live->end()));
  EXPECT_THAT(*live, testing::IsSupersetOf({self, parked.id()}));
  parked.end();
  await_gone(parked.id());
}

TEST_P(OsConformance, TheMainThreadIsOneOfItsProcess) {
  const ProcessId process = os().current_process();
  const Result<std::vector<ThreadId>> threads = os().threads(process);
  ASSERT_TRUE(threads.ok());
  EXPECT_THAT(*threads, testing::Contains(os().main_thread(process)));
}

TEST_P(OsConformance, ProcessThatIsGoneHasNoThreads) {
  EXPECT_ENVIRONMENT_ERROR(os().threads(ProcessId{0x3fffffff}));
  EXPECT_ENVIRONMENT_ERROR(os().threads(ProcessId{0}));
  EXPECT_ENVIRONMENT_ERROR(os().threads(ProcessId{-1}));
}

TEST_P(OsConformance, HandleJoinsWhenItGoes) {
  bool done = false;
  {
    const auto thread = os().spawn("a name that is longer than a kernel takes", [&] {
      os().sleep_until(os().now() + 2ms);
      done = true;
    });
  }
  EXPECT_TRUE(done);
}

TEST_P(OsConformance, ThreadsHaveTheNamesThatTheyWereMadeWith) {
  std::string own;
  std::string cut;
  os().spawn("detector", [&] { own = os().thread_name(os().current_thread()); })->join();
  os().spawn("perception.detector", [&] { cut = os().thread_name(os().current_thread()); })->join();
  EXPECT_EQ(own, "detector");
  EXPECT_EQ(cut, "perception.dete");
}

TEST_P(OsConformance, JoiningTwiceIsHarmless) {
  std::atomic<int> runs{0};
  std::atomic<ThreadId> joined{};
  const auto thread = os().spawn("", [&] {
    joined = os().current_thread();
    ++runs;
  });
  thread->join();
  EXPECT_EQ(runs, 1) << "it has ended";
  await_gone(joined);
  Parked other(os());  // may have been given what the one that ended left
  const TimePoint begin = os().now();
  thread->join();
  EXPECT_LE(os().now() - begin, at_once());
  EXPECT_EQ(runs, 1);
  EXPECT_TRUE(is_listed(other.id())) << "nobody else was waited for";
}

TEST_P(OsConformance, CallsAboutAThreadThatIsGoneSaySo) {
  auto saved = os().save_scheduling(os().current_thread());
  const auto cpus = os().affinity(os().current_thread());
  ASSERT_TRUE(saved.ok() && cpus.ok());
  for (const ThreadId gone : {gone_thread(), ThreadId{0}, ThreadId{-1}, ThreadId{0x3fffffff}}) {
    SCOPED_TRACE(static_cast<int>(gone));
    EXPECT_ENVIRONMENT_ERROR(os().thread_cpu_time(gone));
    EXPECT_ENVIRONMENT_ERROR(os().cpu_clock(gone));
    EXPECT_EQ(os().ready_time(gone), std::nullopt);
    EXPECT_EQ(os().thread_name(gone), "");
    EXPECT_ENVIRONMENT_ERROR(os().set_level(gone, Level::kOrdinary));
    EXPECT_ENVIRONMENT_ERROR(os().level(gone));
    EXPECT_ENVIRONMENT_ERROR(os().set_affinity(gone, *cpus));
    EXPECT_ENVIRONMENT_ERROR(os().affinity(gone));
    EXPECT_ENVIRONMENT_ERROR(os().save_scheduling(gone));
    saved->thread = gone;
    EXPECT_ENVIRONMENT_ERROR(os().restore_scheduling(*saved));
  }
}

// ---- Facts

TEST_P(OsConformance, RealTimeFactsAreTrue) {
  const RealTimeFacts facts = os().real_time_facts();
  EXPECT_GE(facts.reserved, 0.0);
  EXPECT_LT(facts.reserved, 1.0);
  EXPECT_FALSE(facts.reserved_by.empty());
  EXPECT_EQ(facts.permitted, facts.why_not.empty());
  Parked parked(os());
  SchedulingGuard guard(os(), parked.id());
  EXPECT_EQ(os().set_level(parked.id(), Level::kDispatcher).ok(), facts.permitted);
}

TEST_P(OsConformance, AskingForFactsLeavesTheCallerAlone) {
  const auto before = os().save_scheduling(os().current_thread());
  os().real_time_facts();
  EXPECT_EQ(os().save_scheduling(os().current_thread()).value(), before.value());
}

TEST_P(OsConformance, HostFactsNameTheSystem) {
  const HostFacts facts = os().host_facts();
  EXPECT_FALSE(facts.kernel.empty());
  EXPECT_EQ(facts.cpu_count, static_cast<int>(os().topology().value().online().size()));
  EXPECT_GE(facts.steal, Nanos{0});
}

TEST_P(OsConformance, CpusAreKeptReadyOrItIsSaidWhyNot) {
  const auto ready = os().keep_cpus_ready();
  if (ready.ok()) {
    // Null where there is nothing to keep: that depends on the machine, not on who asks.
    const auto again = os().keep_cpus_ready();
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(*again == nullptr, *ready == nullptr);
    return;
  }
  EXPECT_EQ(ready.error().kind(), ErrorKind::kEnvironment);
  EXPECT_FALSE(ready.error().problems().front().hint.empty());
}

class FakeSharingCpus : public FakePlatform {
 public:
  FakeSharingCpus() { fake().share_cpus(true); }
};

constexpr std::array<Port, 5> kPermitted = {{
    {"Linux", make_platform<LinuxPlatform>},
    {"Fake", make_platform<FakePlatform>},
    {"FakeSharingCpus", make_platform<FakeSharingCpus>},
    {"FaultyOverLinux", make_platform<FaultyPlatform<LinuxPlatform>>},
    {"FaultyOverFake", make_platform<FaultyPlatform<FakePlatform>>},
}};
constexpr std::array<Port, 1> kNotPermitted = {{{"FakeWithoutPermission", make_platform<FakeWithoutPermission>}}};

std::string name_of(const testing::TestParamInfo<Port>& port) { return port.param.name; }

INSTANTIATE_TEST_SUITE_P(Ports, OsConformance, testing::ValuesIn(kPermitted), name_of);
INSTANTIATE_TEST_SUITE_P(StrictPorts, OsConformance, testing::ValuesIn(kNotPermitted), name_of);
INSTANTIATE_TEST_SUITE_P(Ports, RealTimeConformance, testing::ValuesIn(kPermitted), name_of);
INSTANTIATE_TEST_SUITE_P(StrictPorts, ConformanceWithoutPermission, testing::ValuesIn(kNotPermitted), name_of);

}  // namespace
}  // namespace ctn::os::conformance
