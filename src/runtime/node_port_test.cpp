// What a run is reported to have cost, and what sets a follower off, in virtual time; and which threads are a node's.
#include "runtime/node_port.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "base/run_access.h"
#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "os/fake/faulty_os.h"
#include "os/linux/linux_os.h"
#include "runtime/node_link.h"

namespace ctn::runtime {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

class NodePortTest : public ::testing::Test {
 protected:
  void trigger() { region.node(node).word.fetch_add(1); }

  // Waits for its trigger, and takes a millisecond for the run.
  void run_once(Nanos cost = milliseconds{1}) {
    trigger();
    ASSERT_TRUE(port.wait_for_trigger());
    port.begin(run);
    fake.burn(cost);
    port.end(run);
  }

  std::vector<Nanos> reported() {
    std::vector<Nanos> costs;
    link.drain([&](const record::Run& each) { costs.push_back(each.cpu); });
    return costs;
  }

  os::FakeOs fake;
  graph::App app = one_node_app();
  NodeId node{std::size_t{0}};
  LocalRegion memory{app.graph, 1};
  Region& region = memory.region();
  NodeLink link{fake, app.graph, node, region};
  NodePort port{fake, app.graph, node, region};
  ctn::Run run;
};

using Costs = std::vector<Nanos>;

// Its thread says itself when it runs: it reads a device, say.
TEST(NodePortOfThreads, AnUnscheduledNodeOfItsOwnPeriodDoesNotWait) {
  os::FakeOs fake;
  const graph::App app = parse(
      "catan: 1\napp: one\nnodes: { imu: { unscheduled: true, period: 5ms }, node: {} }\nedges: [ imu -> node ]\n"
      "objective: [ { period: node, weight: 1 } ]\n");
  const NodeId imu{std::size_t{0}};
  LocalRegion memory{app.graph, 1};
  NodeLink link{fake, app.graph, imu, memory.region()};
  NodePort port{fake, app.graph, imu, memory.region()};
  ctn::Run run;
  const TimePoint start = fake.now();
  std::vector<TimePoint> begun;
  for (int count = 0; count < 3; ++count) {
    ASSERT_TRUE(port.wait_for_trigger());
    port.begin(run);
    fake.burn(milliseconds{1});
    port.end(run);
  }
  link.drain([&](const record::Run& each) { begun.push_back(each.begin); });
  EXPECT_EQ(begun, (std::vector{start, start + milliseconds{1}, start + milliseconds{2}}));
  port.stop();
  EXPECT_FALSE(port.wait_for_trigger());
}

// Guards: its whole lifetime was taken from the run, which then seemed to cost nothing.
TEST_F(NodePortTest, AThreadThatEndsInARunTakesNothingFromIt) {
  os::ThreadId worker{};
  const std::unique_ptr<os::Thread> thread = fake.spawn("worker", [&] {
    worker = fake.current_thread();
    fake.burn(milliseconds{20});
    fake.sleep_until(TimePoint{milliseconds{24}});
  });
  fake.sleep_until(TimePoint{milliseconds{22}});
  ASSERT_TRUE(link.add_thread(worker));
  run_once(milliseconds{5});
  EXPECT_EQ(reported(), Costs{milliseconds{5}});
}

// Guards: a run in which a pool was named cost all that the pool had ever done.
TEST_F(NodePortTest, AThreadThatJoinsInARunCountsFromThenOn) {
  os::ThreadId worker{};
  const std::unique_ptr<os::Thread> thread = fake.spawn("worker", [&] {
    worker = fake.current_thread();
    fake.burn(milliseconds{20});
    fake.sleep_until(TimePoint{milliseconds{40}});
    fake.burn(milliseconds{3});
    fake.sleep_until(TimePoint{std::chrono::hours{1}});
  });
  fake.sleep_until(TimePoint{milliseconds{22}});
  trigger();
  ASSERT_TRUE(port.wait_for_trigger());
  port.begin(run);
  ASSERT_TRUE(link.add_thread(worker));
  fake.burn(milliseconds{2});
  port.end(run);
  fake.sleep_until(TimePoint{milliseconds{39}});
  run_once(milliseconds{5});
  EXPECT_EQ(reported(), (Costs{milliseconds{2}, milliseconds{8}}));
}

TEST_F(NodePortTest, WhatComesBeforeTheFirstRunIsNotCounted) {
  fake.burn(milliseconds{7});
  run_once();
  EXPECT_EQ(reported(), Costs{milliseconds{1}});
}

TEST_F(NodePortTest, ComingStraightBackToWaitCountsAsTheRuns) {
  run_once();
  fake.burn(microseconds{10});
  run_once();
  EXPECT_EQ(reported(), (Costs{milliseconds{1}, microseconds{1010}}));
}

// A program may do other things between its runs; a run that seemed to take longer than it can would not be believed.
TEST_F(NodePortTest, WhatElseAThreadDoesBetweenRunsIsNotCounted) {
  run_once();
  fake.burn(milliseconds{5});
  run_once();
  EXPECT_EQ(reported(), (Costs{milliseconds{1}, milliseconds{1}}));
}

TEST_F(NodePortTest, ARunThatBeginsLateIsNotSaidToTakeMoreThanItCan) {
  run_once();
  trigger();
  ASSERT_TRUE(port.wait_for_trigger());
  fake.burn(milliseconds{5});
  port.begin(run);
  fake.burn(milliseconds{1});
  port.end(run);
  EXPECT_EQ(reported(), (Costs{milliseconds{1}, milliseconds{1} + NodePort::kStraightBack}));
}

TEST_F(NodePortTest, WhatARunWaitsIsReportedBesideItsCost) {
  std::vector<Nanos> waits;
  for (int count = 0; count < 3; ++count) {
    trigger();
    ASSERT_TRUE(port.wait_for_trigger());
    port.begin(run);
    fake.burn(milliseconds{1});
    fake.sleep_until(fake.now() + milliseconds{4});
    fake.burn(milliseconds{1});
    port.end(run);
  }
  Costs costs;
  link.drain([&](const record::Run& each) {
    costs.push_back(each.cpu);
    waits.push_back(each.wait);
    EXPECT_EQ(each.end - each.begin, milliseconds{6});
  });
  EXPECT_EQ(costs, Costs(3, milliseconds{2}));
  EXPECT_EQ(waits, Costs(3, milliseconds{4}));
}

// The node's own thread works for 2 ms, and waits for 3 ms until another one is done.
TEST(NodePortOfThreads, ARunThatIsToWorkOnSeveralIsTimed) {
  os::FakeOs fake;
  const graph::App app = parse(
      "catan: 1\napp: one\nnodes: { node: { max_threads: 4 } }\nedges: []\n"
      "objective: [ { period: node, weight: 1 } ]\n");
  const NodeId node{std::size_t{0}};
  LocalRegion memory{app.graph, 1};
  NodeLink link{fake, app.graph, node, memory.region()};
  NodePort port{fake, app.graph, node, memory.region()};
  ctn::Run run;
  const auto run_on = [&](int planned) {
    memory.region().signal(*app.graph.node(node).subchain).threads.store(planned);
    memory.region().node(node).word.fetch_add(1);
    ASSERT_TRUE(port.wait_for_trigger());
    port.begin(run);
    EXPECT_EQ(run.threads(), planned);
    fake.burn(milliseconds{2});
    fake.sleep_until(fake.now() + milliseconds{3});
    port.end(run);
  };
  run_on(1);
  run_on(3);
  std::vector<record::Run> reported;
  link.drain([&](const record::Run& each) { reported.push_back(each); });
  ASSERT_EQ(reported.size(), 2U);
  EXPECT_EQ(reported[0].threads, 1);
  EXPECT_EQ(reported[0].elapsed, Nanos{0});
  EXPECT_EQ(reported[1].threads, 3);
  EXPECT_EQ(reported[1].elapsed + reported[1].wait, milliseconds{5});
  EXPECT_EQ(reported[1].on_cpu, reported[0].on_cpu);
}

// A sensor, what follows it, and a third that has no part in it but takes all that the sensor gives.
class FollowerTest : public ::testing::Test {
 protected:
  NodeId id(const char* name) const { return *app.graph.find_node(name); }

  void give(bool output = true) {
    leader.begin(run);
    if (!output) run.skip_output();
    leader.end(run);
  }
  // A thread that runs `sum`, each time for as long as it says. Stopped by port.stop().
  std::unique_ptr<os::Thread> follow(Nanos cost = Nanos{0}) {
    return fake.spawn("sum", [this, cost] {
      ctn::Run own;
      while (port.wait_for_trigger()) {
        port.begin(own);
        consumed.push_back(RunAccess::inputs(own)[0].last);
        fake.burn(cost);
        port.end(own);
      }
    });
  }
  void pass(Nanos time) { fake.sleep_until(fake.now() + time); }

  os::FakeOs fake;
  graph::App app = parse(R"(
catan: 1
app: followers
nodes:
  imu: { unscheduled: true, period: 5ms }
  sum: { unscheduled: true }
  log: { unscheduled: true, period: 20ms, input: queue }
  sink: {}
edges: [ imu -> sum -> sink, imu -> log ]
objective: [ { period: sink, weight: 1 } ]
)");
  LocalRegion memory{app.graph, 1};
  Region& region = memory.region();
  NodePort leader{fake, app.graph, id("imu"), region};
  NodePort port{fake, app.graph, id("sum"), region};
  ctn::Run run;
  std::vector<std::uint64_t> consumed;
};

using Numbers = std::vector<std::uint64_t>;

TEST_F(FollowerTest, EachOutputMakesARunThatHasIt) {
  const auto thread = follow();
  for (int count = 0; count < 3; ++count) {
    give();
    pass(milliseconds{5});
  }
  EXPECT_EQ(consumed, (Numbers{1, 2, 3}));
  port.stop();
  thread->join();
}

TEST_F(FollowerTest, WithoutOutputNoRun) {
  const auto thread = follow();
  for (const bool output : {false, true, false, true}) {
    give(output);
    pass(milliseconds{5});
  }
  EXPECT_EQ(consumed, (Numbers{2, 4}));
  port.stop();
  thread->join();
}

TEST_F(FollowerTest, WhatComesWhileItIsBusyMakesOneRunMore) {
  const auto thread = follow(milliseconds{10});
  give();
  pass(milliseconds{1});
  for (int count = 0; count < 3; ++count) give();
  pass(milliseconds{50});
  EXPECT_EQ(consumed, (Numbers{1, 4}));
  port.stop();
  thread->join();
}

TEST_F(FollowerTest, WhoComesLateWaitsForTheNextOutput) {
  give();
  NodePort late(fake, app.graph, id("sum"), region);
  int runs = 0;
  const auto thread = fake.spawn("late", [&] {
    for (; late.wait_for_trigger(); ++runs) {
    }
  });
  pass(milliseconds{5});
  EXPECT_EQ(runs, 0);
  give();
  pass(milliseconds{5});
  EXPECT_EQ(runs, 1);
  late.stop();
  thread->join();
}

// A process that writes there without a reason, as often as it likes.
TEST_F(FollowerTest, AWordThatLiesMakesRunsAndNoMore) {
  const auto thread = follow();
  for (const std::uint32_t word : {7U, 0U, 0xffffffffU, 1U << 31U}) {
    region.node(id("sum")).word.store(word);
    fake.wake(region.node(id("sum")).word);
    pass(milliseconds{1});
  }
  EXPECT_EQ(consumed, (Numbers{0, 0, 0, 0}));
  give();
  pass(milliseconds{1});
  EXPECT_EQ(consumed.back(), 1U);
  port.stop();
  thread->join();
}

// What the leader gives in the new region before the follower has looked is not lost.
TEST_F(FollowerTest, MovesToAnotherRegionWithItsLeader) {
  LocalRegion other(app.graph, 1);
  const auto thread = follow(milliseconds{10});
  give();
  pass(milliseconds{1});  // busy
  port.move_to(other.region(), app.graph);
  leader.move_to(other.region(), app.graph);
  give();
  pass(milliseconds{50});
  EXPECT_EQ(consumed, (Numbers{1, 2}));
  EXPECT_FALSE(port.uses(region) || leader.uses(region));
  give();
  pass(milliseconds{50});
  EXPECT_EQ(consumed, (Numbers{1, 2, 3}));
  port.stop();
  thread->join();
}

// Guards: what a node was about to use was freed if it was moved twice just then (which sanitizers tell), and a wake
// that came before it had looked at the word was lost.
TEST(NodePortOfThreads, FollowsEveryMoveAndStops) {
  const auto linux_os = os::make_linux_os();
  const graph::App app = one_node_app();
  const NodeId node{std::size_t{0}};
  LocalRegion one{app.graph, 1};
  LocalRegion other{app.graph, 1};
  for (int round = 0; round < 50; ++round) {
    NodePort port{*linux_os, app.graph, node, one.region()};
    const auto thread = linux_os->spawn("node", [&] {
      for (ctn::Run run; port.wait_for_trigger(); port.end(run)) port.begin(run);
    });
    for (int times = 0; times < 20 * (round % 5); ++times) {
      port.move_to(other.region(), app.graph);
      port.move_to(one.region(), app.graph);
    }
    if (round % 2 == 0) {
      const TimePoint give_up = linux_os->now() + std::chrono::seconds{20};
      while (port.uses(other.region()) && linux_os->now() < give_up) {
        linux_os->sleep_until(linux_os->now() + microseconds{10});
      }
      EXPECT_FALSE(port.uses(other.region())) << "it has followed to the last region";
    }
    port.stop();
    thread->join();
  }
}

// Guards: the next thread got the place, and then lost its clock to the removal of the one before.
TEST(NodeLinkOfThreads, APlaceIsNotFreeWhileWhoHadItIsVisited) {
  os::FakeOs fake;
  os::FaultyOs faulty(fake);
  const graph::App app = one_node_app();
  const NodeId node{std::size_t{0}};
  LocalRegion memory{app.graph, 1};
  NodeLink link{faulty, app.graph, node, memory.region()};
  const auto wait = [&](Nanos time) { fake.sleep_until(fake.now() + time); };
  os::ThreadId last{};
  const auto thread = fake.spawn("last", [&] {
    last = fake.current_thread();
    wait(milliseconds{50});
  });
  wait(milliseconds{1});
  faulty.fail_next(os::Call::kThreadCpuTime, 1);
  ASSERT_TRUE(link.add_thread(fake.current_thread())) << "without a clock";
  const os::ThreadId first = fake.current_thread();
  const auto visitor =
      fake.spawn("visitor", [&] { link.for_each_thread([&](os::ThreadId) { wait(milliseconds{5}); }); });
  wait(milliseconds{1});
  const auto remover = fake.spawn("remover", [&] { link.remove_thread(first, [](os::ThreadId) {}); });
  wait(milliseconds{1});
  ASSERT_TRUE(link.add_thread(last));
  wait(milliseconds{10});
  std::vector<os::ThreadId> with_clock;
  link.for_each_clock([&](os::ThreadId each, os::CpuClock&) { with_clock.push_back(each); });
  EXPECT_EQ(with_clock, std::vector<os::ThreadId>{last});
  for (const auto& each : {&visitor, &remover, &thread}) (*each)->join();
}

// The thread of a framework that has a timer of its own does not wait.
TEST_F(FollowerTest, WhoDoesNotWaitIsCountedFromItsBegin) {
  NodeLink link{fake, app.graph, id("sum"), region};
  std::vector<Nanos> costs;
  for (int count = 0; count < 2; ++count) {
    give();
    fake.burn(microseconds{10});
    port.begin(run);
    fake.burn(milliseconds{1});
    port.end(run);
  }
  link.drain([&](const record::Run& each) { costs.push_back(each.cpu); });
  EXPECT_EQ(costs, (Costs{milliseconds{1}, milliseconds{1}}));
}

TEST_F(FollowerTest, AnUnscheduledNodeTakesEachOutputOfItsQueueOnce) {
  NodePort log(fake, app.graph, id("log"), region);
  ctn::Run of_log;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> taken;
  for (int count = 0; count < 3; ++count) {
    give();
    give();
    log.begin(of_log);
    const RunAccess::Input& input = RunAccess::inputs(of_log)[0];
    taken.emplace_back(input.first, input.last);
    log.end(of_log);
  }
  EXPECT_EQ(taken, (std::vector<std::pair<std::uint64_t, std::uint64_t>>{{1, 2}, {3, 4}, {5, 6}}));
}

TEST_F(FollowerTest, ARunTakesWhatItsMessagesSay) {
  NodePort log(fake, app.graph, id("log"), region);
  ctn::Run of_log;
  const auto range = [&] {
    const RunAccess::Input& input = RunAccess::inputs(of_log)[0];
    return std::pair(input.first, input.last);
  };
  give();
  pass(milliseconds{1});
  give();
  give();
  log.begin(of_log);
  EXPECT_EQ(range(), std::pair(std::uint64_t{1}, std::uint64_t{3})) << "all, where nothing is said";
  log.take(of_log, "imu", 1, 2);
  EXPECT_EQ(range(), std::pair(std::uint64_t{1}, std::uint64_t{2}));
  EXPECT_EQ(RunAccess::inputs(of_log)[0].origin, fake.now().time_since_epoch() - milliseconds{1});
  log.take(of_log, "sum", 1, 1);
  log.take(of_log, "nobody", 1, 1);
  EXPECT_EQ(range(), std::pair(std::uint64_t{1}, std::uint64_t{2})) << "of others it says nothing";
  log.end(of_log);
  log.begin(of_log);
  EXPECT_EQ(range(), std::pair(std::uint64_t{3}, std::uint64_t{3})) << "what was left";
  log.take(of_log, "imu", 9, 9);
  EXPECT_EQ(range(), std::pair(std::uint64_t{3}, std::uint64_t{3})) << "what has not been given does not count";
  log.end(of_log);
}

}  // namespace
}  // namespace ctn::runtime
