// When a subchain that misses a node is let go of, and what its nodes get to know of that, in virtual time.
#include "runtime/incomplete_subchains.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "runtime/node_port.h"
#include "runtime/scheduler.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr SubchainId kFirst{std::size_t{0}};
constexpr SubchainId kSecond{std::size_t{1}};

TimePoint at(Nanos since_start) { return TimePoint{since_start}; }

TEST(IncompleteSubchainsTest, ASubchainIsLetGoOfOnceItHasWaitedForASecond) {
  IncompleteSubchains all(2);
  EXPECT_FALSE(all.look(kFirst, true, at(milliseconds{100})));
  EXPECT_FALSE(all.look(kFirst, true, at(milliseconds{1099})));
  EXPECT_FALSE(all.is_let_go(kFirst));
  EXPECT_TRUE(all.look(kFirst, true, at(milliseconds{1100})));
  EXPECT_TRUE(all.is_let_go(kFirst));
  EXPECT_FALSE(all.look(kFirst, true, at(milliseconds{1150}))) << "told once";
  EXPECT_FALSE(all.look(kSecond, true, at(milliseconds{1150}))) << "each has its own time";
}

TEST(IncompleteSubchainsTest, ProgramsThatStartOneAfterAnotherAreWaitedFor) {
  IncompleteSubchains all(1);
  all.look(kFirst, true, at(milliseconds{0}));
  all.look(kFirst, true, at(milliseconds{900}));
  EXPECT_FALSE(all.complete(kFirst)) << "it had not been let go of";
  EXPECT_FALSE(all.look(kFirst, true, at(milliseconds{1200}))) << "one of them has just gone: a new second";
  EXPECT_TRUE(all.look(kFirst, true, at(milliseconds{2200})));
}

TEST(IncompleteSubchainsTest, WhereNobodyIsThereNobodyWaits) {
  IncompleteSubchains all(1);
  for (int step = 0; step < 100; ++step) EXPECT_FALSE(all.look(kFirst, false, at(step * milliseconds{50})));
  EXPECT_FALSE(all.look(kFirst, true, at(seconds{5})));
  EXPECT_FALSE(all.look(kFirst, false, at(milliseconds{5900})));
  EXPECT_FALSE(all.look(kFirst, true, at(milliseconds{6100}))) << "who comes next waits for a second, too";
  EXPECT_TRUE(all.look(kFirst, true, at(milliseconds{7100})));
}

TEST(IncompleteSubchainsTest, WhatWasLetGoOfStaysSoUntilItIsComplete) {
  IncompleteSubchains all(1);
  all.look(kFirst, true, at(seconds{0}));
  ASSERT_TRUE(all.look(kFirst, true, at(seconds{1})));
  EXPECT_FALSE(all.look(kFirst, false, at(seconds{2})));
  EXPECT_TRUE(all.is_let_go(kFirst)) << "all have gone";
  EXPECT_TRUE(all.complete(kFirst));
  EXPECT_FALSE(all.is_let_go(kFirst));
  EXPECT_FALSE(all.complete(kFirst));
}

TEST(IncompleteSubchainsTest, NodesAreWokenSomeTimesMoreAfterEachChange) {
  IncompleteSubchains all(2);
  const auto woken = [&all] {
    std::vector<SubchainId> ids;
    all.wake_again([&](SubchainId id) { ids.push_back(id); });
    return ids;
  };
  all.look(kFirst, true, at(seconds{0}));
  EXPECT_THAT(woken(), IsEmpty());
  ASSERT_TRUE(all.look(kFirst, true, at(seconds{1})));
  for (int wake = 0; wake < IncompleteSubchains::kMoreWakes; ++wake) EXPECT_THAT(woken(), ElementsAre(kFirst));
  EXPECT_THAT(woken(), IsEmpty());
  ASSERT_TRUE(all.complete(kFirst));
  EXPECT_THAT(woken(), ElementsAre(kFirst));
  EXPECT_FALSE(all.complete(kFirst)) << "a program has come again, at once";
  for (int wake = 1; wake < IncompleteSubchains::kMoreWakes; ++wake) EXPECT_THAT(woken(), ElementsAre(kFirst));
  EXPECT_FALSE(all.complete(kSecond)) << "it was not let go of";
  EXPECT_THAT(woken(), IsEmpty());
}

// Two subchains, the second of two nodes.
constexpr const char* kTwoChains = R"(
catan: 1
app: pair
nodes:
  left: { fallback_rate: 20Hz }
  front: { fallback_rate: 50Hz }
  back: {}
edges: [ front -> back ]
subchains: { right: [front, back] }
objective:
  - { period: left, weight: 1 }
  - { response_time: [front, back], weight: 1 }
scheduler: { bootstrap: 500ms }
)";

// A program that runs one node. One that asks notes when its subchain was let go of, and when that was over.
class WaitingProgram {
 public:
  WaitingProgram(os::FakeOs& fake, Scheduler& scheduler, const Region& region, const std::string& node, bool asks)
      : fake_(fake), node_(*scheduler.app().graph.find_node(node)), port_(fake, scheduler.app().graph, node_, region) {
    thread_ = fake.spawn(node, [this, asks] {
      number_.store(static_cast<std::int32_t>(fake_.current_thread()), std::memory_order_release);
      for (;;) {
        const Awaited awaited = asks ? port_.await() : port_.wait_for_trigger() ? Awaited::kTrigger : Awaited::kStopped;
        if (awaited == Awaited::kStopped) return;
        if (awaited == Awaited::kTrigger) {
          run_once();
        } else if (!wait_until_complete()) {
          return;
        }
      }
    });
    while (number_.load(std::memory_order_acquire) == 0) fake_.sleep_until(fake_.now() + milliseconds{1});
    EXPECT_TRUE(scheduler.join(node_, fake.current_process(), os::ThreadId{number_.load(std::memory_order_acquire)}));
  }
  ~WaitingProgram() {
    port_.stop();
    thread_->join();
  }

  std::atomic<int> runs{0};
  std::atomic<bool> let_go{false};
  std::atomic<int> let_go_of{0};  // so often
  std::atomic<TimePoint> changed{TimePoint{}};

 private:
  void run_once() {
    port_.begin(run_);
    fake_.burn(milliseconds{5});
    port_.end(run_);
    ++runs;
  }
  bool wait_until_complete() {
    changed.store(fake_.now());
    let_go.store(true);
    ++let_go_of;
    if (!port_.await_complete()) return false;
    changed.store(fake_.now());
    let_go.store(false);
    return true;
  }

  os::FakeOs& fake_;
  NodeId node_;
  NodePort port_;
  ctn::Run run_;
  std::atomic<std::int32_t> number_{0};
  std::unique_ptr<os::Thread> thread_;
};

class LettingGoTest : public ::testing::TestWithParam<const char*> {
 protected:
  LettingGoTest() {
    fake.share_cpus(true);
    memory = std::make_unique<LocalRegion>(app.graph, 1);
    SchedulerOptions options{
        .policy = *policy::make_policy(GetParam()), .cpus = {}, .record = {}, .note = {}, .on_notice = {}};
    auto made = Scheduler::create(app, fake, std::move(options), os::CpuSet({0}), memory->region());
    EXPECT_TRUE(made.ok());
    scheduler = std::move(*made);
    EXPECT_TRUE(scheduler->prepare().ok());
    EXPECT_TRUE(scheduler->start().ok());
  }
  ~LettingGoTest() override {
    scheduler->end_scheduling();
    EXPECT_TRUE(scheduler->finish().ok());
  }

  std::unique_ptr<WaitingProgram> program(const std::string& node, bool asks = true) {
    return std::make_unique<WaitingProgram>(fake, *scheduler, memory->region(), node, asks);
  }
  void leave(const std::string& node) { scheduler->leave(*app.graph.find_node(node), "its process has ended"); }
  void pass(Nanos time) { fake.sleep_until(fake.now() + time); }

  graph::App app = parse(kTwoChains);
  os::FakeOs fake{os::fake_topology(2)};
  std::unique_ptr<LocalRegion> memory;
  std::unique_ptr<Scheduler> scheduler;
};

TEST_P(LettingGoTest, ANodeIsToldWithinASecondThatAnotherIsMissingAndAtOnceThatItIsThere) {
  auto left = program("left");
  auto front = program("front");
  const TimePoint joined = fake.now();
  pass(milliseconds{900});
  EXPECT_FALSE(front->let_go);
  pass(seconds{2});
  EXPECT_TRUE(front->let_go);
  EXPECT_LE(front->changed.load() - joined, milliseconds{1200});
  EXPECT_EQ(front->runs, 0);
  EXPECT_GT(left->runs, 30) << "of another subchain";
  EXPECT_THAT(scheduler->snapshot().notices,
              Contains(HasSubstr("subchain right is let go of until node back is there")));

  auto back = program("back");
  const TimePoint complete = fake.now();
  pass(seconds{2});
  EXPECT_FALSE(front->let_go);
  EXPECT_LE(front->changed.load() - complete, milliseconds{200});
  EXPECT_GT(front->runs, 50);
  EXPECT_NEAR(front->runs, back->runs, 1) << "nothing of the time before is left over";
  EXPECT_LE(back->let_go_of, 1) << "before the server has seen it";
  EXPECT_FALSE(back->let_go);
  EXPECT_EQ(left->let_go_of, 0);
  EXPECT_THAT(scheduler->snapshot().notices, Contains(HasSubstr("subchain right runs: all of its nodes have")));
}

TEST_P(LettingGoTest, EachNodeThatIsLeftIsToldWhenOneIsKilledAndAgain) {
  auto front = program("front");
  auto back = program("back");
  pass(seconds{2});
  for (int round = 1; round <= 3; ++round) {
    SCOPED_TRACE(round);
    leave("front");
    front.reset();
    const int runs = back->runs;
    const TimePoint gone = fake.now();
    pass(seconds{2});
    EXPECT_EQ(back->let_go_of, round);
    EXPECT_TRUE(back->let_go);
    EXPECT_LE(back->changed.load() - gone, milliseconds{1200});
    EXPECT_LE(back->runs - runs, 1) << "but for the run that was under way";
    front = program("front");
    pass(seconds{2});
    EXPECT_FALSE(back->let_go);
    EXPECT_GT(back->runs - runs, 50);
  }
}

TEST_P(LettingGoTest, WhoDoesNotAskGoesOnWaiting) {
  auto front = program("front", false);
  pass(seconds{3});
  EXPECT_EQ(front->runs, 0);
  auto back = program("back", false);
  pass(seconds{2});
  EXPECT_GT(front->runs, 50);
  EXPECT_NEAR(front->runs, back->runs, 1);
}

// A server that is gone triggers nothing, and nobody else is to either as long as the subchain is let go of.
TEST_P(LettingGoTest, WhatTriggersANodeMeanwhileIsPassedOver) {
  auto front = program("front");
  pass(seconds{2});
  ASSERT_TRUE(front->let_go);
  NodeCell& cell = memory->region().node(*app.graph.find_node("front"));
  cell.word.fetch_add(1);
  fake.wake(cell.word);
  pass(milliseconds{200});
  EXPECT_EQ(front->runs, 0);
  EXPECT_TRUE(front->let_go);
  auto back = program("back");
  pass(seconds{2});
  EXPECT_GT(front->runs, 50);
  EXPECT_NEAR(front->runs, back->runs, 1);
}

TEST_P(LettingGoTest, AProgramThatIsLetGoOfCanBeStopped) {
  auto front = program("front");
  pass(seconds{2});
  ASSERT_TRUE(front->let_go);
  front.reset();
}

INSTANTIATE_TEST_SUITE_P(All, LettingGoTest, testing::Values("catan", "default"),
                         [](const auto& each) { return std::string(each.param); });

}  // namespace
}  // namespace ctn::runtime
