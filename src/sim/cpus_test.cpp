// Which thread has which CPU when, by hand: every figure exact.
#include "sim/cpus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace ctn::sim {
namespace {

using std::chrono::milliseconds;

constexpr int kActive = static_cast<int>(os::Level::kActive);
constexpr int kBackground = static_cast<int>(os::Level::kBackground);

Machine ideal(int cores) {
  return {.cores = cores, .costs = MachineCosts::none(), .fair = {}, .limit = std::nullopt, .background = {}};
}

// Threads each of which works so long whenever it is woken, and writes down when it was done.
class CpusTest : public ::testing::Test, public Cpus::Client {
 protected:
  void make(const Machine& machine, std::vector<Nanos> works) {
    work = std::move(works);
    cpus = std::make_unique<Cpus>(machine, std::vector<double>(static_cast<std::size_t>(machine.cores), 1.0),
                                  work.size(), *this);
  }
  Nanos begin(Cpus::Thread thread, int cpu) override {
    began.emplace_back(thread, cpu);
    return work[thread];
  }
  bool done(Cpus::Thread thread, int cpu) override {
    if (!log.empty()) log += ' ';
    const double ms = to_millis(cpus->now() - TimePoint{}).count();
    std::string time = std::to_string(ms);
    time.erase(time.find_last_not_of('0') + 1);
    if (time.back() == '.') time.pop_back();
    log += std::to_string(thread) + "@" + std::to_string(cpu) + ":" + time;
    return again;
  }
  void wake(Cpus::Thread thread) { cpus->wake(thread, -1); }
  void wake_at(Cpus::Thread thread, int ms) { cpus->wake_at(thread, TimePoint{milliseconds{ms}}); }
  void run(int ms) { cpus->run_until(TimePoint{milliseconds{ms}}); }

  std::vector<Nanos> work;
  std::unique_ptr<Cpus> cpus;
  std::vector<std::pair<Cpus::Thread, int>> began;
  std::string log;  // "thread@cpu:ms", in the order they were done
  bool again = false;
};

TEST_F(CpusTest, AHigherLevelPreemptsAndALowerWaits) {
  make(ideal(1), {milliseconds{10}, milliseconds{3}, milliseconds{2}});
  cpus->set_level(0, kBackground);
  cpus->set_level(1, kActive);
  cpus->set_level(2, kActive);
  wake(0);
  wake_at(1, 4);
  wake_at(2, 5);  // same level: after the first
  run(100);
  EXPECT_EQ(log, "1@0:7 2@0:9 0@0:15");
  EXPECT_EQ(cpus->used_by(0), milliseconds{10});
}

TEST_F(CpusTest, ARunningThreadThatIsLoweredGivesWayAtOnce) {
  make(ideal(1), {milliseconds{10}, milliseconds{3}});
  cpus->set_level(0, kActive);
  cpus->set_level(1, kBackground);
  wake(0);
  wake(1);
  run(4);
  cpus->set_level(0, 0);
  run(100);
  EXPECT_EQ(log, "1@0:7 0@0:13");
}

// A thread that is lowered into a level goes to the front of it, one that is raised into it to its end.
TEST_F(CpusTest, LoweredGoToTheFrontRaisedToTheEnd) {
  make(ideal(1), {milliseconds{1}, milliseconds{1}, milliseconds{1}, milliseconds{1}});
  for (const Cpus::Thread thread : {1U, 2U, 3U}) cpus->set_level(thread, kBackground);
  cpus->set_level(0, static_cast<int>(os::Level::kDispatcher));
  cpus->set_level(3, kActive);
  wake(0);
  for (const Cpus::Thread thread : {1U, 2U, 3U}) wake(thread);
  cpus->run_until(TimePoint{});
  cpus->set_level(3, kBackground);
  cpus->set_level(1, kActive);
  cpus->set_level(1, kBackground);
  run(100);
  EXPECT_EQ(log, "0@0:1 1@0:2 3@0:3 2@0:4");
}

TEST_F(CpusTest, RoamingThreadsGoWhereTheLowestRuns) {
  make(ideal(2), {milliseconds{10}, milliseconds{10}, milliseconds{2}});
  cpus->set_cpus(1, CpuMask::only(1));
  cpus->set_level(0, kActive);
  cpus->set_level(1, kBackground);
  cpus->set_level(2, kActive);
  CpuMask both = CpuMask::only(0);
  both.add(1);
  cpus->set_cpus(2, both);
  wake(0);
  wake(1);
  wake_at(2, 1);
  run(100);
  EXPECT_EQ(log, "2@1:3 0@0:10 1@1:12");
}

TEST_F(CpusTest, OrdinaryThreadsShareFairly) {
  make(ideal(1), {milliseconds{9}, milliseconds{9}});
  wake(0);
  wake(1);
  run(100);
  EXPECT_EQ(log, "0@0:15 1@0:18") << "by turns, 3 ms each";
}

TEST_F(CpusTest, WhoWakesWaitsForTheEndOfTheFirstSlice) {
  make(ideal(1), {milliseconds{20}, milliseconds{1}});
  wake(0);
  wake_at(1, 2);
  run(100);
  EXPECT_EQ(log, "1@0:4 0@0:21");
}

// As measured on Linux 6.18: where a thread has run for longer than a slice, one that wakes takes its place at once.
TEST_F(CpusTest, WhoHasHadASliceGivesWayToWhoWakes) {
  make(ideal(1), {milliseconds{20}, milliseconds{1}});
  wake(0);
  wake_at(1, 7);
  run(100);
  EXPECT_EQ(log, "1@0:8 0@0:21");
}

TEST_F(CpusTest, TimersOfOrdinaryThreadsAreLate) {
  Machine machine = ideal(2);
  machine.costs.ordinary_timer_min = milliseconds{1};
  machine.costs.ordinary_timer_max = milliseconds{1};
  make(machine, {milliseconds{1}, milliseconds{1}});
  cpus->set_level(1, 1);
  cpus->set_cpus(1, CpuMask::only(1));
  wake_at(0, 5);
  wake_at(1, 5);
  run(100);
  EXPECT_EQ(log, "1@1:6 0@0:7");
}

TEST_F(CpusTest, TimersOfRealTimeThreadsAreLateByChanceButTheSameEachTime) {
  Machine machine = ideal(1);
  machine.costs.timer_latency = milliseconds{1};
  machine.costs.timer_jitter = milliseconds{4};
  const auto lateness = [&] {
    make(machine, {Nanos{0}});
    cpus->set_level(0, kActive);
    std::vector<Nanos> late;
    for (int round = 1; round <= 100; ++round) {
      wake_at(0, 10 * round);
      began.clear();
      while (began.empty()) cpus->run_until(cpus->now() + std::chrono::microseconds{10});
      late.push_back(cpus->now() - TimePoint{milliseconds{10 * round}});
    }
    return late;
  };
  const std::vector<Nanos> late = lateness();
  const auto [min, max] = std::minmax_element(late.begin(), late.end());
  EXPECT_GE(*min, milliseconds{1});
  EXPECT_LE(*min, milliseconds{2});
  EXPECT_GE(*max, milliseconds{4});
  EXPECT_LE(*max, milliseconds{5} + std::chrono::microseconds{10});
  EXPECT_EQ(lateness(), late);
}

TEST_F(CpusTest, AnIdleCpuTakesAnOrdinaryThreadThatWaits) {
  make(ideal(2), {milliseconds{4}, milliseconds{10}, milliseconds{6}});
  CpuMask both = CpuMask::only(0);
  both.add(1);
  for (const Cpus::Thread thread : {0U, 1U, 2U}) cpus->set_cpus(thread, both);
  for (const Cpus::Thread thread : {0U, 1U, 2U}) wake(thread);
  run(100);
  // 0 and 2 share CPU 0; when 0 has had its 4 ms the CPU is 2's, and 1 has the other all the time.
  EXPECT_EQ(log, "0@0:7 2@0:10 1@1:10");
}

TEST_F(CpusTest, RealTimeThreadsAreLimitedWhereOrdinaryOnesWait) {
  Machine machine = ideal(1);
  machine.limit = RealTimeLimit{milliseconds{95}, milliseconds{100}};
  make(machine, {milliseconds{1000}, milliseconds{1000}});
  cpus->set_level(0, kActive);
  wake(0);
  run(200);
  EXPECT_EQ(cpus->used_by(0), milliseconds{200}) << "no thread waits";
  wake(1);
  run(400);
  EXPECT_EQ(cpus->used_by(0), milliseconds{390});
  EXPECT_EQ(cpus->used_by(1), milliseconds{10});
  EXPECT_EQ(cpus->throttled(), 2U);
}

TEST_F(CpusTest, ToWakeAndToSwitchTakesTime) {
  Machine machine = ideal(2);
  machine.costs.timer_latency = std::chrono::microseconds{5};
  machine.costs.wake_other = std::chrono::microseconds{9};
  machine.costs.context_switch = std::chrono::microseconds{2};
  make(machine, {milliseconds{1}, milliseconds{1}});
  cpus->set_cpus(1, CpuMask::only(1));
  wake_at(0, 1);
  cpus->wake(1, 0);
  run(100);
  EXPECT_EQ(log, "1@1:1.011 0@0:2.007");
}

TEST_F(CpusTest, UseIsCountedByKind) {
  make(ideal(1), {milliseconds{3}, milliseconds{5}});
  cpus->set_level(0, kActive);
  wake(0);
  wake(1);
  run(4);
  cpus->forget_use();
  run(100);
  EXPECT_EQ(cpus->use_of(0).real_time, Nanos{0});
  EXPECT_EQ(cpus->use_of(0).ordinary, milliseconds{4});
}

// --- Reservations ---

// On one core, worked by hand. 1 (4 of 8 ms, by 8) goes before 0 (2 of 10, woken at 1, by 11), and may use the
// millisecond that it has left when it is woken again at 4; then it waits for 8, by 16.
TEST_F(CpusTest, OfReservedThreadsTheEarliestDeadlineGoesFirst) {
  make(ideal(1), {milliseconds{2}, milliseconds{3}});
  cpus->reserve(0, milliseconds{2}, milliseconds{10});
  cpus->reserve(1, milliseconds{4}, milliseconds{8});
  wake(1);
  wake_at(0, 1);
  run(3);
  wake_at(1, 4);
  run(100);
  EXPECT_EQ(log, "1@0:3 0@0:6 1@0:10");
}

TEST_F(CpusTest, OnTwoCoresTheTwoEarliestDeadlinesRun) {
  make(ideal(2), {milliseconds{2}, milliseconds{5}, milliseconds{5}});
  CpuMask both = CpuMask::only(0);
  both.add(1);
  for (const Cpus::Thread thread : {0U, 1U, 2U}) {
    cpus->set_cpus(thread, both);
    cpus->reserve(thread, milliseconds{8}, milliseconds{10 * (static_cast<int>(thread) + 1)});
  }
  wake(2);
  wake(1);
  wake_at(0, 1);  // in the place of 2
  run(100);
  EXPECT_EQ(log, "0@1:3 1@0:5 2@1:7");
}

// 0 would work for ever. It gets 5 of every 10 ms, and 1 its 2 of every 20 right after.
TEST_F(CpusTest, AnOverrunIsKeptToItsReservation) {
  make(ideal(1), {milliseconds{1000}, milliseconds{2}});
  cpus->reserve(0, milliseconds{5}, milliseconds{10});
  cpus->reserve(1, milliseconds{3}, milliseconds{20});
  wake(0);
  for (int time = 0; time < 100; time += 20) {
    wake_at(1, time);
    run(time + 20 - 1);
  }
  run(100);
  EXPECT_EQ(log, "1@0:7 1@0:27 1@0:47 1@0:67 1@0:87");
  EXPECT_EQ(cpus->used_by(0), milliseconds{50});
}

// Nor does the limit that ordinary threads owe their part to keep them from the CPU.
TEST_F(CpusTest, ReservedThreadsAreAboveAllLevels) {
  Machine machine = ideal(1);
  machine.limit = RealTimeLimit{.runtime = milliseconds{2}, .period = milliseconds{20}};
  make(machine, {milliseconds{6}, milliseconds{4}, milliseconds{20}});
  cpus->reserve(0, milliseconds{4}, milliseconds{10});
  cpus->set_level(1, Cpus::kReserved - 1);
  wake(1);
  wake(2);
  wake_at(0, 1);  // by 11: 1 to 5, and from 11 to 13
  run(100);
  EXPECT_EQ(log, "0@0:13 2@0:29 1@0:30") << "1 has the core to 1 ms, from 20 to 22, and when 2 is done";
}

TEST_F(CpusTest, WhoLosesItsReservationWaitsForNoBudget) {
  make(ideal(1), {milliseconds{3}});
  cpus->reserve(0, milliseconds{1}, milliseconds{10});
  wake(0);
  run(5);
  EXPECT_EQ(cpus->used_by(0), milliseconds{1});
  cpus->set_level(0, 0);
  run(100);
  EXPECT_EQ(log, "0@0:7");
}

}  // namespace
}  // namespace ctn::sim
