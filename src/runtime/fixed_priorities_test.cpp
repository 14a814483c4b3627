// Subchains with fixed priorities in the whole runtime, in virtual time, with threads that compete for CPUs: every
// figure exact. And the parts: subscribers in the region, CPU time of a run, which threads are raised above which.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/testing/apps.h"
#include "os/fake/fake_os.h"
#include "policy/planned.h"
#include "policy/testing/given_places.h"
#include "record/reader.h"
#include "runtime/engine.h"
#include "runtime/registered_nodes.h"
#include "runtime/run_clock.h"

namespace ctn::runtime {
namespace {

using policy::place_after;
using policy::place_by_phase;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::Each;
using testing::ElementsAre;

graph::App priorities_app() {
  return parse(R"(
catan: 1
app: priorities
nodes: { a: {}, b: {}, imu: { unscheduled: true, period: 50ms }, display: { external: true, period: 20ms } }
edges: [ a -> b, b -> display ]
objective: [ { response_time: [a], weight: 1 }, { response_time: [b], weight: 1 } ]
scheduler: { bootstrap: 100ms }
)");
}

const SubchainId kA{std::size_t{0}};
const SubchainId kB{std::size_t{1}};

class FixedPrioritiesTest : public ::testing::Test {
 protected:
  FixedPrioritiesTest() { fake.share_cpus(true); }

  void run_for(Nanos duration, std::vector<policy::SubchainPlace> places) {
    run_for(duration, std::make_shared<policy::GivenPlaces>(std::move(places)));
  }

  void run_for(Nanos duration, std::shared_ptr<const policy::Policy> policy) {
    const std::string path = testing::TempDir() + fmt::format("live_priorities_{}.catan", ::getpid());
    std::remove(path.c_str());
    auto engine = Engine::create(
        app, fake,
        {.policy = std::move(policy), .cpus = os::CpuSet{0, 1}, .record = path, .note = {}, .on_notice = {}});
    ASSERT_TRUE(engine.ok()) << engine.error().message();
    running = engine->get();
    for (const char* name : {"a", "b", "imu"}) {
      (*engine)->wiring().set_body(name, [this, name = std::string(name)](ctn::Run& run) {
        fake.burn(costs[name](run.number()));
        if (name == "b" && tell_ticks && run.number() % 5 == 0) {
          EXPECT_TRUE(running->tick("display", tell_ticks(fake.now())).ok());
        }
        if (name == "a" && run.number() % 4 == 0) run.skip_output();
      });
    }
    const Status started = (*engine)->start();
    ASSERT_TRUE(started.ok()) << started.error().message();
    fake.sleep_until(fake.now() + duration);
    for (const os::ThreadId thread : *fake.threads(fake.current_process())) ++threads_at[*fake.level(thread)];
    snapshot = (*engine)->snapshot();
    ASSERT_TRUE((*engine)->stop().ok());
    engine->reset();
    const auto reader = record::Reader::open(path);
    ASSERT_TRUE(reader.ok()) << reader.error().message();
    triggers.resize(app.graph.subchains().size());
    EXPECT_TRUE(reader
                    ->each_trigger(
                        [&](const record::Trigger& trigger) { triggers[trigger.subchain.index()].push_back(trigger); })
                    .ok());
    EXPECT_TRUE(reader->each_overrun([&](const record::Overrun& overrun) { overruns.push_back(overrun); }).ok());
    std::remove(path.c_str());
  }

  const graph::App app = priorities_app();
  os::FakeOs fake{os::fake_topology(2)};
  std::map<std::string, std::function<Nanos(std::uint64_t)>> costs{{"a", [](std::uint64_t) { return milliseconds{3}; }},
                                                                   {"b", [](std::uint64_t) { return milliseconds{4}; }},
                                                                   {"imu", [](std::uint64_t) { return Nanos{0}; }}};
  std::function<TimePoint(TimePoint)> tell_ticks;  // of the display: the newest
  Engine* running = nullptr;
  Snapshot snapshot;
  std::map<os::Level, int> threads_at;
  std::vector<std::vector<record::Trigger>> triggers;
  std::vector<record::Overrun> overruns;
};

TEST_F(FixedPrioritiesTest, TriggersComeAtTheirPhaseAndWithOutputsAlone) {
  run_for(milliseconds{400},
          {place_by_phase(1, 0, milliseconds{10}, milliseconds{7}), place_after(0, 0, kA, 1, milliseconds{10})});
  ASSERT_GT(triggers[kA.index()].size(), 35U);
  for (const record::Trigger& trigger : triggers[kA.index()]) {
    EXPECT_EQ((trigger.due - TimePoint{}) % milliseconds{10}, milliseconds{7});
    EXPECT_EQ(trigger.sent, trigger.due);
  }
  std::vector<TimePoint> with_output;
  for (const record::Trigger& trigger : triggers[kA.index()]) {
    if (trigger.number % 4 != 0) with_output.push_back(trigger.due + milliseconds{3});
  }
  ASSERT_GT(triggers[kB.index()].size(), 25U);
  for (std::size_t k = 0; k < triggers[kB.index()].size(); ++k) {
    EXPECT_EQ(triggers[kB.index()][k].due, with_output[k]);
    EXPECT_EQ(triggers[kB.index()][k].sent, with_output[k]);
  }
  EXPECT_EQ(snapshot.budget_overruns, 0U);
}

TEST_F(FixedPrioritiesTest, WhoTriggersAndWhoRunsByItselfOutrankAllOfThem) {
  run_for(milliseconds{205},
          {place_by_phase(6, 0, milliseconds{10}, Nanos{0}), place_by_phase(2, 1, milliseconds{10}, milliseconds{5})});
  EXPECT_EQ(threads_at[os::fixed_level(6)], 1);
  EXPECT_EQ(threads_at[os::fixed_level(2)], 1);
  EXPECT_EQ(threads_at[os::fixed_level(7)], 1) << "the driver of a sensor";
  EXPECT_EQ(threads_at[os::fixed_level(8)], 2) << "a controller each";
  std::map<os::ThreadId, os::Level> last;
  for (const os::FakeOs::Change& change : fake.changes()) {
    if (change.level) last[change.thread] = *change.level;
  }
  for (const auto& [thread, level] : last) EXPECT_EQ(level, os::Level::kOrdinary) << "restored";
}

// a may use 3 of every 10 ms above b, and uses 9 every fifth time: b needs 4 of every 10 ms.
TEST_F(FixedPrioritiesTest, ARunBeyondItsBudgetDoesNotDelayWhoIsBelow) {
  costs["a"] = [](std::uint64_t run) { return run % 5 == 0 ? milliseconds{9} : milliseconds{3}; };
  run_for(seconds{1}, {place_by_phase(1, 0, milliseconds{10}, Nanos{0}, milliseconds{3}),
                       place_by_phase(0, 0, milliseconds{10}, Nanos{0})});
  ASSERT_GE(overruns.size(), 15U);
  for (const record::Overrun& overrun : overruns) {
    EXPECT_EQ(overrun.subchain, kA);
    EXPECT_EQ(overrun.number % 5, 0U);
    EXPECT_EQ(overrun.cpu, milliseconds{3} + dispatch::kBudgetGrain);
  }
  EXPECT_GE(triggers[kB.index()].size(), 95U);
  for (const record::Trigger& trigger : triggers[kB.index()])
    EXPECT_EQ(trigger.sent, trigger.due) << "b was never late";
  EXPECT_GE(snapshot.budget_overruns + 2, overruns.size()) << "but for what was not collected yet";
  EXPECT_LE(snapshot.budget_overruns, overruns.size());
}

// Plans frames at first, and gives fixed priorities once costs were measured.
class PrioritiesLater : public policy::Policy {
 public:
  explicit PrioritiesLater(std::vector<policy::SubchainPlace> places)
      : Policy("later"), frames_(std::make_shared<policy::FormulaPolicy>()), priorities_(std::move(places)) {}
  bool follows_plan() const override { return true; }
  bool adapts() const override { return true; }
  bool raises() const override { return true; }
  Result<policy::Decision> decide(const policy::Situation& situation) const override {
    return frames_->decide(situation);
  }
  Result<std::optional<policy::Decision>> decide_again(const policy::Situation& situation,
                                                       const policy::Decision& in_force) const override {
    policy::Decision decision = *priorities_.decide(situation);
    decision.plan = in_force.plan;
    return std::optional(std::move(decision));
  }

 private:
  std::shared_ptr<const policy::Policy> frames_;
  policy::GivenPlaces priorities_;
};

TEST_F(FixedPrioritiesTest, WhoTriggersIsRaisedBeforeAnybodyIsAboveIt) {
  run_for(seconds{2}, std::make_shared<PrioritiesLater>(
                          std::vector<policy::SubchainPlace>{place_by_phase(4, 0, milliseconds{10}, Nanos{0}),
                                                             place_by_phase(3, 1, milliseconds{10}, milliseconds{5})}));
  EXPECT_GE(snapshot.plans, 2U);
  EXPECT_EQ(threads_at[os::fixed_level(4)], 1);
  EXPECT_EQ(threads_at[os::fixed_level(3)], 1);
  EXPECT_EQ(threads_at[os::fixed_level(5)], 1) << "the driver of a sensor";
  EXPECT_EQ(threads_at[os::fixed_level(6)], 4) << "a controller for each subchain and core";
  // At any time the nodes' levels are below the level of the controller that triggers.
  std::map<os::ThreadId, os::Level> levels;
  std::map<os::ThreadId, os::Level> highest;
  for (const os::FakeOs::Change& change : fake.changes()) {
    if (change.level) highest[change.thread] = std::max(highest[change.thread], *change.level);
  }
  bool given = false;
  for (const os::FakeOs::Change& change : fake.changes()) {
    if (!change.level) continue;
    levels[change.thread] = *change.level;
    if (given || *change.level != os::fixed_level(4)) continue;
    given = true;
    for (const auto& [thread, level] : highest) {
      if (level != os::fixed_level(5) && level != os::fixed_level(6)) continue;
      EXPECT_EQ(levels[thread], level);
    }
  }
  EXPECT_TRUE(given);
}

// --- Subscribers to outputs, in the region ---

TEST_F(FixedPrioritiesTest, WhatArrivesFromAnUnscheduledNodeTriggersAtOnce) {
  costs["imu"] = [](std::uint64_t) { return milliseconds{2}; };
  run_for(seconds{1}, {place_after(1, 0, *app.graph.find_node("imu"), 1, milliseconds{50}),
                       place_by_phase(0, 0, milliseconds{20}, milliseconds{7})});
  ASSERT_GE(triggers[kA.index()].size(), 15U);
  for (std::size_t k = 0; k < triggers[kA.index()].size(); ++k) {
    const record::Trigger& trigger = triggers[kA.index()][k];
    EXPECT_EQ(trigger.sent, trigger.due);
    if (k > 0) {
      EXPECT_EQ(trigger.due - triggers[kA.index()][k - 1].due, milliseconds{50});
    }
  }
}

// A display of 20 ms, told of with every fifth of b's runs: known after some seconds.
TEST_F(FixedPrioritiesTest, PhasesAreKeptToAClockThatTheProgramTellsOf) {
  tell_ticks = [](TimePoint now) { return Ticks{TimePoint{} + milliseconds{3}, milliseconds{20}}.last(now); };
  policy::SubchainPlace place = place_by_phase(1, 0, milliseconds{20}, milliseconds{14});
  place.pacing.clock = *app.graph.find_node("display");
  run_for(seconds{4}, {place, place_by_phase(0, 0, milliseconds{20}, milliseconds{1})});
  ASSERT_GT(triggers[kA.index()].size(), 190U);
  EXPECT_EQ((triggers[kA.index()].front().sent - TimePoint{}) % milliseconds{20}, milliseconds{14});
  EXPECT_EQ((triggers[kA.index()].back().sent - TimePoint{}) % milliseconds{20}, milliseconds{17});
}

class OutputSubscribersTest : public ::testing::Test {
 protected:
  std::uint32_t wakes(std::size_t controller) const { return region.controller_cell(controller).word.load(); }

  const graph::App app = priorities_app();
  os::FakeOs fake{os::fake_topology(1)};
  LocalRegion memory{app.graph, 4};
  const Region& region = memory.region();
  SignalCell& signal = region.signal(kA);
};

TEST_F(OutputSubscribersTest, AreWokenByEachOutputAndByNoneAfterTheyHaveGone) {
  EXPECT_TRUE(signal.subscribe(1, 1));
  EXPECT_TRUE(signal.subscribe(3, 1));
  EXPECT_TRUE(signal.subscribe(1, 1)) << "again and again";
  signal.give_output(fake, region, TimePoint{} + milliseconds{7});
  EXPECT_EQ(wakes(0), 0U);
  EXPECT_EQ(wakes(1), 1U);
  EXPECT_EQ(wakes(3), 1U);
  EXPECT_EQ(signal.outputs.load(), 1U);
  EXPECT_EQ(signal.newest_output.load(), Nanos{milliseconds{7}}.count());
  signal.unsubscribe(1);
  signal.give_output(fake, region, TimePoint{} + milliseconds{8});
  EXPECT_EQ(wakes(1), 1U);
  EXPECT_EQ(wakes(3), 2U);
}

TEST_F(OutputSubscribersTest, AreWokenByNoOutputBeforeTheOneTheyWaitFor) {
  EXPECT_TRUE(signal.subscribe(1, 3));
  EXPECT_TRUE(signal.subscribe(2, 1));
  const auto give = [&] { signal.give_output(fake, region, TimePoint{}); };
  give();
  give();
  EXPECT_EQ(wakes(1), 0U);
  EXPECT_EQ(wakes(2), 2U);
  give();
  EXPECT_EQ(wakes(1), 1U);
  give();
  EXPECT_EQ(wakes(1), 2U) << "and by each beyond";
  EXPECT_TRUE(signal.subscribe(1, 6)) << "in its place";
  give();
  EXPECT_EQ(wakes(1), 2U);
  give();
  EXPECT_EQ(wakes(1), 3U);
  signal.unsubscribe(1);
  give();
  EXPECT_EQ(wakes(1), 3U);
  EXPECT_EQ(wakes(2), 7U);
}

TEST_F(OutputSubscribersTest, CountsAreComparedAlsoWhereTheyWrapAround) {
  constexpr std::uint64_t kNewest = std::numeric_limits<std::uint64_t>::max();
  signal.outputs.store(kNewest - 1);
  EXPECT_TRUE(signal.subscribe(1, kNewest + 2));
  for (int output = 0; output < 2; ++output) signal.give_output(fake, region, TimePoint{});
  EXPECT_EQ(wakes(1), 0U);
  signal.give_output(fake, region, TimePoint{});
  EXPECT_EQ(wakes(1), 1U);
}

// A program may write what it likes: a follower that waited for a count of before would sleep for days.
TEST_F(OutputSubscribersTest, AreWokenWhereTheCountHasFallenBack) {
  signal.outputs.store(1'000'000);
  EXPECT_TRUE(signal.subscribe(1, 1'000'007));
  signal.outputs.store(0);
  signal.give_output(fake, region, TimePoint{});
  EXPECT_EQ(wakes(1), 1U);
}

TEST_F(OutputSubscribersTest, WhereThereIsNoRoomOneIsTold) {
  for (std::size_t controller = 0; controller < SignalCell::kMaxSubscribers; ++controller) {
    EXPECT_TRUE(signal.subscribe(controller, 1));
  }
  EXPECT_FALSE(signal.subscribe(5, 1));
  signal.unsubscribe(2);
  EXPECT_TRUE(signal.subscribe(5, 1));
}

TEST_F(OutputSubscribersTest, NumbersOfNoSubchainWakeNone) {
  signal.subscribers[0].store(0xffffffff);
  signal.subscribers[1].store(region.controller_cells() + 1);
  EXPECT_TRUE(signal.subscribe(0, 1));
  signal.give_output(fake, region, TimePoint{});
  EXPECT_EQ(wakes(0), 1U);
  for (std::size_t controller = 1; controller < region.controller_cells(); ++controller) {
    EXPECT_EQ(wakes(controller), 0U);
  }
}

// --- CPU time of a run ---

TEST(RunClockTest, CountsAllThreadsSinceTheTriggerAlsoThoseThatHaveEnded) {
  const graph::App app = priorities_app();
  os::FakeOs fake{os::fake_topology(2)};
  LocalRegion memory(app.graph, 1);
  const Links links = links_of(fake, app.graph, memory.region());
  const std::vector<SubchainLinks> subchains = subchain_links(app.graph, links, memory.region());
  const auto worker = [&](Nanos before, Nanos after) {
    return fake.spawn("worker", [&fake, before, after] {
      fake.burn(before);
      fake.sleep_until(TimePoint{} + milliseconds{10});
      fake.burn(after);
    });
  };
  const auto first = worker(milliseconds{5}, milliseconds{2});
  const auto second = worker(milliseconds{1}, milliseconds{30});
  NodeLink& node = *links[app.graph.find_node("a")->index()];
  for (const os::ThreadId thread : *fake.threads(fake.current_process())) {
    if (thread != fake.current_thread()) node.add_thread(thread);
  }
  RunClock clock;
  fake.sleep_until(TimePoint{} + milliseconds{9});
  clock.begin(subchains[kA.index()]);
  EXPECT_EQ(clock.used(subchains[kA.index()]), Nanos{0});
  fake.sleep_until(TimePoint{} + milliseconds{11});
  EXPECT_EQ(clock.used(subchains[kA.index()]), milliseconds{2}) << "one each";
  fake.sleep_until(TimePoint{} + milliseconds{20});
  EXPECT_EQ(clock.used(subchains[kA.index()]), milliseconds{11}) << "the first has ended, as it was seen last";
  clock.begin(subchains[kA.index()]);
  EXPECT_EQ(clock.used(subchains[kA.index()]), Nanos{0});
}

// --- Which threads are raised ---

TEST(RaisedAbove, UnscheduledNodesThatHaveJoinedAndThoseThatJoinLater) {
  const graph::App app = parse(R"(
catan: 1
app: drivers
nodes: { imu: { unscheduled: true, period: 5ms }, gps: { unscheduled: true, period: 5ms }, left: {} }
objective: [ { period: left, weight: 1 } ]
)");
  os::FakeOs fake{os::fake_topology(1)};
  LocalRegion memory(app.graph, 1);
  Links links = links_of(fake, app.graph, memory.region());
  driver::Notices notices({}, false);
  Enforcer enforcer(fake, true, nullptr, &notices);
  RegisteredNodes registered(app, fake, memory.region(), links, notices);
  registered.open(enforcer,
                  {.cpus = os::CpuSet{0}, .scheduled = os::Level::kBackground, .unscheduled = os::Level::kUnscheduled});
  const auto sleeper = [&] { return fake.spawn("node", [&fake] { fake.sleep_until(TimePoint{} + seconds{1}); }); };
  std::vector<std::unique_ptr<os::Thread>> threads;
  std::vector<os::ThreadId> ids;
  for (int index = 0; index < 3; ++index) threads.push_back(sleeper());
  for (const os::ThreadId thread : *fake.threads(fake.current_process())) {
    if (thread != fake.current_thread()) ids.push_back(thread);
  }
  ASSERT_EQ(ids.size(), 3U);
  const auto join = [&](const char* name, os::ThreadId thread) {
    EXPECT_TRUE(registered.join(*app.graph.find_node(name), fake.current_process(), thread).ok());
  };
  join("imu", ids[0]);
  join("left", ids[1]);
  EXPECT_EQ(*fake.level(ids[0]), os::Level::kUnscheduled);
  registered.raise_unscheduled(os::fixed_level(3));
  EXPECT_EQ(*fake.level(ids[0]), os::fixed_level(3));
  EXPECT_EQ(*fake.level(ids[1]), os::Level::kOrdinary) << "scheduled ones are the controllers'";
  join("gps", ids[2]);
  EXPECT_EQ(*fake.level(ids[2]), os::fixed_level(3));
  registered.raise_unscheduled(os::Level::kUnscheduled);
  EXPECT_EQ(*fake.level(ids[0]), os::fixed_level(3)) << "never lower";
  enforcer.restore_for_good();
  for (const os::ThreadId thread : ids) EXPECT_EQ(*fake.level(thread), os::Level::kOrdinary);
}

}  // namespace
}  // namespace ctn::runtime
