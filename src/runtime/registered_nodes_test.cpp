// Nodes that come, go and come back, as those of other processes do, in virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "os/fake/faulty_os.h"
#include "runtime/scheduler.h"
#include "runtime/wiring.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// Two subchains, the second of two nodes.
graph::App two_chains(const std::string& rates = "") {
  return parse(R"(
catan: 1
app: pair
nodes:
  left: { fallback_rate: 20Hz)" +
               rates + R"( }
  front: { fallback_rate: 50Hz }
  back: {}
edges: [ front -> back ]
subchains: { right: [front, back] }
objective:
  - { period: left, weight: 1 }
  - { response_time: [front, back], weight: 1 }
scheduler: { bootstrap: 500ms }
)");
}

// A driver of two programs, and one that is scheduled.
graph::App driver() {
  return parse(R"(
catan: 1
app: driver
nodes:
  imu: { unscheduled: true, period: 5ms }
  sum: { unscheduled: true }
  left: { fallback_rate: 20Hz }
edges: [ imu -> sum -> left ]
objective: [ { period: left, weight: 1 } ]
scheduler: { bootstrap: 500ms }
)");
}

// A program that runs one node, as far as the scheduler can tell.
class Program {
 public:
  Program(os::FakeOs& fake, Scheduler& scheduler, const Region& region, const std::string& node, Nanos cost)
      : fake_(fake), node_(*scheduler.app().graph.find_node(node)), port_(fake, scheduler.app().graph, node_, region) {
    const graph::Node& described = scheduler.app().graph.node(node_);
    if (described.unscheduled && !described.follows) timer_ = described.period;
    thread_ = fake.spawn(node, [this, cost] {
      number_.store(static_cast<std::int32_t>(fake_.current_thread()), std::memory_order_release);
      Run run;
      while (wait()) {
        port_.begin(run);
        fake_.burn(cost);
        if (crashed_.load()) return;
        port_.end(run);
        ++runs;
      }
    });
    while (number_.load(std::memory_order_acquire) == 0) fake_.sleep_until(fake_.now() + milliseconds{1});
    const Status joined =
        scheduler.join(node_, fake.current_process(), os::ThreadId{number_.load(std::memory_order_acquire)});
    EXPECT_TRUE(joined.ok()) << joined.error().message();
  }
  ~Program() {
    port_.stop();
    thread_->join();
  }

  // In the middle of its run: it never ends.
  void crash() { crashed_.store(true); }

  std::atomic<int> runs{0};

 private:
  bool wait() {
    if (!timer_) return port_.wait_for_trigger();
    next_ = std::max(next_ + *timer_, fake_.now());
    fake_.sleep_until(next_);
    return !port_.stopping();
  }

  os::FakeOs& fake_;
  NodeId node_;
  std::optional<Nanos> timer_;
  TimePoint next_{};
  NodePort port_;
  std::atomic<std::int32_t> number_{0};
  std::atomic<bool> crashed_{false};
  std::unique_ptr<os::Thread> thread_;
};

class RegisteredNodesTest : public ::testing::TestWithParam<const char*> {
 protected:
  RegisteredNodesTest() { fake.share_cpus(true); }

  void open(int cpus, graph::App of = two_chains()) {
    app = std::move(of);
    std::vector<int> numbers;
    for (int cpu = 0; cpu < cpus; ++cpu) numbers.push_back(cpu);
    memory = std::make_unique<LocalRegion>(app.graph, numbers.size());
    SchedulerOptions options{
        .policy = *policy::make_policy(GetParam()), .cpus = {}, .record = {}, .note = {}, .on_notice = {}};
    auto made = Scheduler::create(app, fake, std::move(options), os::CpuSet(numbers), memory->region());
    ASSERT_TRUE(made.ok());
    scheduler = std::move(*made);
    ASSERT_TRUE(scheduler->prepare().ok());
    ASSERT_TRUE(scheduler->start().ok());
  }
  std::unique_ptr<Program> program(const std::string& node, Nanos cost = milliseconds{5}) {
    return std::make_unique<Program>(fake, *scheduler, memory->region(), node, cost);
  }
  void leave(const std::string& node) { scheduler->leave(*app.graph.find_node(node), "its process has ended"); }
  void pass(Nanos time) { fake.sleep_until(fake.now() + time); }
  static int runs_in(const std::unique_ptr<Program>& program, const std::function<void()>& time) {
    const int before = program->runs;
    time();
    return program->runs - before;
  }
  int notices(const std::string& with) const {
    const Snapshot snapshot = scheduler->snapshot();
    return static_cast<int>(
        std::count_if(snapshot.notices.begin(), snapshot.notices.end(),
                      [&](const std::string& notice) { return notice.find(with) != std::string::npos; }));
  }
  void TearDown() override {
    if (!scheduler) return;
    scheduler->end_scheduling();
    EXPECT_TRUE(scheduler->finish().ok());
  }

  graph::App app = two_chains();
  os::FakeOs fake{os::fake_topology(2)};
  std::unique_ptr<LocalRegion> memory;
  std::unique_ptr<Scheduler> scheduler;
};

TEST_P(RegisteredNodesTest, AFollowerWaitsForItsLeader) {
  open(2, driver());
  auto sum = program("sum", milliseconds{1});
  pass(seconds{1});
  EXPECT_EQ(sum->runs, 0) << "it has no leader";
  for (int round = 0; round < 3; ++round) {
    SCOPED_TRACE(round);
    auto imu = program("imu", milliseconds{1});
    EXPECT_NEAR(runs_in(sum, [&] { pass(seconds{1}); }), 200, 1);
    leave("imu");
    imu.reset();
    EXPECT_LE(runs_in(sum, [&] { pass(seconds{1}); }), 1);
  }
}

TEST_P(RegisteredNodesTest, AFollowerThatComesBackGoesOn) {
  open(2, driver());
  auto imu = program("imu", milliseconds{1});
  for (int round = 0; round < 3; ++round) {
    SCOPED_TRACE(round);
    auto sum = program("sum", milliseconds{1});
    EXPECT_NEAR(runs_in(sum, [&] { pass(seconds{1}); }), 200, 1);
    leave("sum");
    sum.reset();
    EXPECT_NEAR(runs_in(imu, [&] { pass(seconds{1}); }), 200, 1) << "its leader does not mind";
  }
}

TEST_P(RegisteredNodesTest, AFollowerNeedsNoScheduler) {
  open(2, driver());
  auto imu = program("imu", milliseconds{1});
  auto sum = program("sum", milliseconds{1});
  pass(seconds{1});
  scheduler->end_scheduling();
  EXPECT_NEAR(runs_in(sum, [&] { pass(seconds{1}); }), 200, 1);
}

TEST_P(RegisteredNodesTest, NodesThatAreThereArePacedOthersAreWaitedFor) {
  open(1);
  auto left = program("left");
  pass(seconds{1});
  EXPECT_GE(left->runs, 15);
  auto front = program("front");
  pass(seconds{1});
  EXPECT_EQ(front->runs, 0) << "its subchain misses a node";
  auto back = program("back");
  pass(seconds{1});
  EXPECT_GE(front->runs, 15);
  EXPECT_NEAR(front->runs, back->runs, 1);
  EXPECT_EQ(notices("have registered"), 2);
}

// Nobody watches what it does until its subchain is complete.
TEST_P(RegisteredNodesTest, ANodeThatWaitsForOthersIsAtTheOrdinaryLevel) {
  open(1);
  auto front = program("front");
  pass(seconds{1});
  const std::vector<os::ThreadId> threads = scheduler->threads(*app.graph.find_node("front"));
  ASSERT_EQ(threads.size(), 1U);
  EXPECT_EQ(*fake.level(threads.front()), os::Level::kOrdinary);
  auto back = program("back");
  pass(seconds{1});
  EXPECT_GE(front->runs, 15);
}

TEST_P(RegisteredNodesTest, ANodeThatDiesInItsRunBreaksItsChainOnlyAndComesBack) {
  for (const int cpus : {1, 2}) {
    SCOPED_TRACE(cpus);
    open(cpus);
    auto left = program("left");
    auto front = program("front");
    auto back = program("back");
    pass(seconds{3});
    const int before = runs_in(left, [&] { pass(seconds{2}); });
    back->crash();
    pass(milliseconds{100});  // it runs more often than that
    leave("back");
    EXPECT_EQ(notices("node back is gone: its process has ended; broken until it is back: front -> back"), 1);
    pass(milliseconds{200});
    const int without = runs_in(left, [&] { EXPECT_EQ(runs_in(front, [&] { pass(seconds{2}); }), 0); });
    EXPECT_GE(without, before - 1) << "others keep their rates";
    auto again = program("back");
    pass(milliseconds{200});
    const int with = runs_in(again, [&] { pass(seconds{2}); });
    EXPECT_GE(with, 20);
    EXPECT_EQ(notices("hang"), 0);
    TearDown();
    scheduler.reset();
  }
}

// It is back before any controller has noticed that nothing ends any more.
TEST_P(RegisteredNodesTest, ANodeThatIsBackAtOnceGoesOn) {
  open(1);
  auto left = program("left");
  pass(seconds{2});
  left->crash();
  pass(milliseconds{100});
  leave("left");
  auto again = program("left");
  pass(milliseconds{200});
  EXPECT_GE(runs_in(again, [&] { pass(seconds{1}); }), 15);
  EXPECT_EQ(notices("hang"), 0);
}

TEST_P(RegisteredNodesTest, ANodeIsThereOnce) {
  open(1);
  auto left = program("left");
  EXPECT_FALSE(scheduler->join(*app.graph.find_node("left"), fake.current_process(), fake.current_thread()).ok());
  pass(seconds{1});
  EXPECT_GE(left->runs, 15);
}

TEST_P(RegisteredNodesTest, ANodeThatLeavesGetsItsSchedulingBack) {
  open(1);
  auto left = program("left");
  pass(seconds{1});
  const std::vector<os::ThreadId> threads = scheduler->threads(*app.graph.find_node("left"));
  ASSERT_EQ(threads.size(), 1U);
  leave("left");
  EXPECT_TRUE(scheduler->threads(*app.graph.find_node("left")).empty());
  pass(seconds{1});
  EXPECT_EQ(*fake.level(threads[0]), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(threads[0]), fake.topology()->online());
}

// One program that is not there must not leave all others planned at a guess.
class PlannedNodesTest : public RegisteredNodesTest {};
TEST_P(PlannedNodesTest, NodesThatAreThereArePlannedAsMeasuredAndOthersAsAssumed) {
  open(2);
  auto left = program("left", milliseconds{2});
  pass(seconds{3});
  Snapshot snapshot = scheduler->snapshot();
  EXPECT_EQ(snapshot.plans, 2U);
  ASSERT_EQ(snapshot.assumed.size(), 2U);
  EXPECT_EQ(snapshot.assumed[0].node, "front");
  EXPECT_EQ(snapshot.assumed[1].node, "back");
  EXPECT_EQ(notices("assumed: front (5 ms), back (5 ms)"), 1);
  EXPECT_GE(runs_in(left, [&] { pass(seconds{1}); }), 450) << "2 ms and 6 % of slack";
  auto front = program("front", milliseconds{2});
  auto back = program("back", milliseconds{2});
  pass(seconds{2});
  snapshot = scheduler->snapshot();
  EXPECT_GE(snapshot.plans, 3U);
  EXPECT_TRUE(snapshot.assumed.empty());
  EXPECT_EQ(notices("assumed-costs: compute times are known now of: "), 1);
  // It goes: what it cost is remembered.
  leave("back");
  back.reset();
  pass(seconds{2});
  EXPECT_TRUE(scheduler->snapshot().assumed.empty());
}
INSTANTIATE_TEST_SUITE_P(Planned, PlannedNodesTest, ::testing::Values("catan"),
                         [](const auto& each) { return std::string(each.param); });

INSTANTIATE_TEST_SUITE_P(Policies, RegisteredNodesTest, ::testing::Values("catan", "default", "fifo"),
                         [](const auto& each) { return std::string(each.param); });

// A scheduler of two_chains() on an os of the test's own.
template <class TestOs>
struct Started {
  explicit Started(int cpus) : fake(os::fake_topology(cpus)), memory(app.graph, static_cast<std::size_t>(cpus)) {
    fake.share_cpus(true);
    SchedulerOptions options{
        .policy = *policy::make_policy("catan"), .cpus = {}, .record = {}, .note = {}, .on_notice = {}};
    scheduler = *Scheduler::create(app, os, std::move(options), fake.topology()->online(), memory.region());
    EXPECT_TRUE(scheduler->prepare().ok());
    EXPECT_TRUE(scheduler->start().ok());
  }
  ~Started() {
    scheduler->end_scheduling();
    EXPECT_TRUE(scheduler->finish().ok());
  }

  const graph::App app = two_chains();
  os::FakeOs fake;
  TestOs os{fake};
  LocalRegion memory;
  std::unique_ptr<Scheduler> scheduler;
};

// Tells of each thread that is about to be bound, or restored.
class ToldOs final : public os::FaultyOs {
 public:
  using FaultyOs::FaultyOs;
  Status set_affinity(os::ThreadId thread, const os::CpuSet& cpus) override {
    if (about_to_bind) about_to_bind(thread);
    return FaultyOs::set_affinity(thread, cpus);
  }
  Status restore_scheduling(const os::SavedScheduling& saved) override {
    if (about_to_restore) about_to_restore(saved.thread);
    return FaultyOs::restore_scheduling(saved);
  }
  std::function<void(os::ThreadId)> about_to_bind;
  std::function<void(os::ThreadId)> about_to_restore;
};

// A controller that knows of a thread moves it, also between its being set and its being read back, and then the join
// was refused: "cannot bind to CPUs 0-1: it may use CPUs 0".
TEST(RegisteredNodes, AThreadIsPlacedBeforeControllersKnowOfIt) {
  Started<ToldOs> started(2);
  os::FakeOs& fake = started.fake;
  Scheduler& scheduler = *started.scheduler;

  const NodeId node = *started.app.graph.find_node("left");
  std::map<os::ThreadId, bool> known_when_first_bound;
  started.os.about_to_bind = [&](os::ThreadId thread) {
    const std::vector<os::ThreadId> known = scheduler.threads(node);
    known_when_first_bound.emplace(thread, std::find(known.begin(), known.end(), thread) != known.end());
  };
  const auto sleeper = [&] { fake.sleep_until(fake.now() + seconds{1}); };
  std::atomic<std::int32_t> numbers[2] = {0, 0};
  std::vector<std::unique_ptr<os::Thread>> threads;
  for (std::atomic<std::int32_t>& number : numbers) {
    threads.push_back(fake.spawn("left", [&] {
      number.store(static_cast<std::int32_t>(fake.current_thread()));
      sleeper();
    }));
  }
  fake.sleep_until(fake.now() + milliseconds{1});
  const os::ThreadId own{numbers[0].load()};
  const os::ThreadId other{numbers[1].load()};
  EXPECT_TRUE(scheduler.join(node, fake.current_process(), own).ok());
  EXPECT_TRUE(scheduler.add_thread(node, fake.current_process(), other).ok());
  EXPECT_EQ(known_when_first_bound.count(own) + known_when_first_bound.count(other), 2U);
  EXPECT_FALSE(known_when_first_bound[own]);
  EXPECT_FALSE(known_when_first_bound[other]);
  started.os.about_to_bind = nullptr;
  scheduler.leave(node, "the test ends");
  for (const auto& thread : threads) thread->join();
}

// Guards: a server that found a thread, raised it, and was killed before it listed it left it raised: the program did
// not know of it, and the guardian had been killed, too.
TEST(RegisteredNodes, TheRegionListsAThreadBeforeItIsPlacedAndUntilItIsRestored) {
  Started<ToldOs> started(2);
  os::FakeOs& fake = started.fake;
  Scheduler& scheduler = *started.scheduler;
  const NodeId node = *started.app.graph.find_node("left");
  os::ThreadId other{};
  const auto thread = fake.spawn("left", [&] {
    other = fake.current_thread();
    fake.sleep_until(fake.now() + seconds{1});
  });
  fake.sleep_until(fake.now() + milliseconds{1});
  const auto listed = [&] {
    const NodeCell& cell = started.memory.region().node(node);
    return std::any_of(cell.thread.begin(), cell.thread.end(),
                       [&](const auto& each) { return each.load() == static_cast<std::int32_t>(other); });
  };
  std::vector<bool> listed_when;
  started.os.about_to_bind = started.os.about_to_restore = [&](os::ThreadId about) {
    if (about == other) listed_when.push_back(listed());
  };
  EXPECT_TRUE(scheduler.join(node, fake.current_process(), fake.current_thread()).ok());
  EXPECT_FALSE(listed());
  EXPECT_TRUE(scheduler.add_thread(node, fake.current_process(), other).ok());
  EXPECT_TRUE(listed());
  scheduler.remove_thread(node, other);
  EXPECT_FALSE(listed());
  EXPECT_TRUE(scheduler.add_thread(node, fake.current_process(), other).ok());
  started.os.about_to_bind = nullptr;
  scheduler.leave(node, "the test ends");
  EXPECT_FALSE(listed());
  EXPECT_GE(listed_when.size(), 4U) << "placed and restored, twice";
  EXPECT_THAT(listed_when, testing::Each(true));
  started.os.about_to_restore = nullptr;
  thread->join();
}

// Guards: a thread that was named after the node's others had been listed, and before the node had joined, was not
// placed with them. So what it had before was not saved, though controllers then set its level.
TEST(RegisteredNodes, AThreadThatIsNamedWhileItsNodeJoinsIsPlaced) {
  Started<ToldOs> started(1);
  os::FakeOs& fake = started.fake;
  Scheduler& scheduler = *started.scheduler;
  std::vector<std::unique_ptr<os::Thread>> threads;
  std::vector<os::ThreadId> ids;
  for (int number = 0; number < 2; ++number) {
    threads.push_back(fake.spawn("left", [&] {
      ids.push_back(fake.current_thread());
      fake.sleep_until(fake.now() + seconds{1});
    }));
  }
  fake.sleep_until(fake.now() + milliseconds{1});
  ASSERT_EQ(ids.size(), 2U);
  const NodeId node = *started.app.graph.find_node("left");
  std::vector<os::ThreadId> placed;
  started.os.about_to_bind = [&](os::ThreadId thread) {
    placed.push_back(thread);
    if (placed.size() > 1) return;
    EXPECT_TRUE(scheduler.add_thread(node, fake.current_process(), ids[1]).ok());
  };
  EXPECT_TRUE(scheduler.join(node, fake.current_process(), ids[0]).ok());
  started.os.about_to_bind = nullptr;
  EXPECT_EQ(placed, ids);
  EXPECT_EQ(scheduler.threads(node).size(), 2U);
  fake.sleep_until(fake.now() + milliseconds{100});
  scheduler.leave(node, "the test ends");
  for (const os::ThreadId id : ids) EXPECT_EQ(*fake.level(id), os::Level::kOrdinary);
  for (const auto& thread : threads) thread->join();
}

// A controller that is slow between seeing a thread and setting its level.
class SlowOs final : public os::FaultyOs {
 public:
  explicit SlowOs(os::FakeOs& fake) : FaultyOs(fake), fake_(fake) {}
  void shift_level(os::ThreadId thread, os::Level level) override {
    if (level == os::Level::kActive) {
      about_to_raise.store(true);
      fake_.sleep_until(fake_.now() + milliseconds{2});
      about_to_raise.store(false);
    }
    FaultyOs::shift_level(thread, level);
  }
  std::atomic<bool> about_to_raise{false};

 private:
  os::FakeOs& fake_;
};

// A controller has seen the one thread of node left, and is about to raise it.
struct AboutToRaise : Started<SlowOs> {
  AboutToRaise() : Started(1), left(fake, *scheduler, memory.region(), "left", milliseconds{5}) {
    fake.sleep_until(fake.now() + milliseconds{300});
    threads = scheduler->threads(node);
    while (!os.about_to_raise.load()) fake.sleep_until(fake.now() + std::chrono::microseconds{100});
  }

  Program left;
  const NodeId node = *app.graph.find_node("left");
  std::vector<os::ThreadId> threads;
};

// The level was set after the thread had been given back, and stayed.
TEST(RegisteredNodes, ARestoredThreadIsNotRaisedByAControllerThatSawItBefore) {
  for (const bool all : {false, true}) {
    SCOPED_TRACE(all ? "end" : "leave");
    AboutToRaise started;
    os::FakeOs& fake = started.fake;
    Scheduler& scheduler = *started.scheduler;
    const NodeId node = started.node;
    const std::vector<os::ThreadId>& threads = started.threads;
    ASSERT_EQ(threads.size(), 1U);
    if (all) {
      scheduler.end_scheduling();
    } else {
      scheduler.leave(node, "its process has ended");
    }
    fake.sleep_until(fake.now() + milliseconds{100});
    EXPECT_EQ(*fake.level(threads[0]), os::Level::kOrdinary);
  }
}

// Guards: a thread that joined again while leave() still waited for a controller was restored and forgotten although it
// had joined; a level that controllers gave it afterwards stayed.
TEST(RegisteredNodes, ANodeThatJoinsWhileItLeavesIsRestoredAtTheEnd) {
  AboutToRaise started;
  os::FakeOs& fake = started.fake;
  Scheduler& scheduler = *started.scheduler;
  const NodeId node = started.node;
  const std::vector<os::ThreadId>& threads = started.threads;
  ASSERT_EQ(threads.size(), 1U);
  const auto joins = fake.spawn("joins", [&] {
    while (!scheduler.join(node, fake.current_process(), threads[0])) {
      fake.sleep_until(fake.now() + std::chrono::microseconds{100});
    }
  });
  scheduler.leave(node, "its process has ended");
  joins->join();
  EXPECT_EQ(scheduler.threads(node), threads);
  const int before = started.left.runs;
  fake.sleep_until(fake.now() + milliseconds{500});
  EXPECT_GE(started.left.runs - before, 5);
  scheduler.end_scheduling();
  EXPECT_EQ(*fake.level(threads[0]), os::Level::kOrdinary);
  EXPECT_EQ(*fake.affinity(threads[0]), fake.topology()->online());
}

}  // namespace
}  // namespace ctn::runtime
