// Subchains that share cores, in virtual time with threads that compete for CPUs: the whole runtime, every figure
// exact.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/testing/apps.h"
#include "os/fake/busy_thread.h"
#include "os/fake/fake_os.h"
#include "planner/frames.h"
#include "policy/planned.h"
#include "record/reader.h"
#include "runtime/engine.h"
#include "runtime/testing/planned_rates.h"
#include "runtime/testing/virtual_session.h"

namespace ctn::runtime {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

class SharedTest : public VirtualSession {
 protected:
  SharedTest() { costs = robot_costs(); }

  void open(graph::App app, const std::string& policy, int cpus, const std::string& record = {}) {
    VirtualSession::open(std::move(app), *policy::make_policy(policy), cpus, record);
  }
  // Of core 0, which a thread gets in ten seconds that would take all of it.
  double share_of_an_ordinary_thread() {
    const os::BusyThread other(fake, "other", os::CpuSet{0}, os::Level::kOrdinary, milliseconds{1});
    const TimePoint begin = fake.now();
    run_for(seconds{10});
    Nanos had{0};
    for (const os::FakeCpus::Stretch& stretch : fake.stretches()) {
      if (stretch.level == os::Level::kOrdinary && stretch.cpu == 0) had += stretch.end - stretch.begin;
    }
    return to_millis(had) / to_millis(fake.now() - begin);
  }
};

// By the formulas a run in two slices once a second makes frames of half a second. Its trigger is deferred instead.
TEST_F(SharedTest, ALightNodeWithACapHoldsNobodyUp) {
  open(parse(R"(
catan: 1
app: capped
nodes: { fast: {}, slow: { max_rate: 1Hz } }
objective:
  - { response_time: [fast], weight: 1 }
  - { response_time: [slow], weight: 0.01 }
scheduler: { bootstrap: 1s }
)"),
       "catan", 1);
  costs = {{"fast", milliseconds{3}}, {"slow", milliseconds{2}}};
  const Snapshot snapshot = run_for(seconds{20});
  EXPECT_GT(rate(snapshot, "fast"), 250.0);
  EXPECT_GT(rate(snapshot, "slow"), 0.9);
  EXPECT_LE(rate(snapshot, "slow"), 1.05);
  EXPECT_TRUE(snapshot.notices.empty());
}

// All costs as planned: the formulas say what happens.
TEST_F(SharedTest, OneCoreIsSharedAsPlanned) {
  open(in_frames(robot_app()), "catan", 1);
  const Snapshot snapshot = run_for(seconds{20});
  EXPECT_TRUE(snapshot.notices.empty());
  ASSERT_EQ(snapshot.chains.size(), 2U);
  for (const ChainSnapshot& chain : snapshot.chains) {
    SCOPED_TRACE(chain.path.front());
    ASSERT_TRUE(chain.predicted_response_ms);
    EXPECT_LE(chain.response_ms.max, *chain.predicted_response_ms * 1.1);
    EXPECT_GT(chain.response_ms.count, 20U);
  }
  const plan::Plan plan =
      *planner::make_plan_in_frames(engine->app(), known_costs(engine->app()), {.cores = 1, .slack = 0.06});
  for (const char* node : {"scan", "map", "log"}) {
    const SubchainId id = *engine->app().graph.node(*engine->app().graph.find_node(node)).subchain;
    const double planned = 1000.0 / plan.subchains[id.index()].period.count();
    // The slack is for ordinary threads; where there are none, runs go on in it.
    EXPECT_GE(rate(snapshot, node), 0.98 * planned) << node;
    EXPECT_LE(rate(snapshot, node), 1.02 * planned / 0.94) << node;
  }
}

// Of 6 %.
TEST_F(SharedTest, OrdinaryThreadsGetTheSlack) {
  open(in_frames(robot_app()), "catan", 1);
  EXPECT_GE(share_of_an_ordinary_thread(), 0.055);
}

// Where a subchain comes a pause after its run has ended, its rate is higher than expected as long as runs cost less
// than is planned with, which the slack is part of.
TEST_F(SharedTest, OrdinaryThreadsGetMostOfTheSlackBesidePauses) {
  open(robot_app(), "catan", 1);
  EXPECT_GE(share_of_an_ordinary_thread(), 0.05);
}

// Runs and triggers are numbered without a gap, and a head ran once for each trigger, but for one that was sent last.
void expect_nothing_lost(const std::string& path) {
  const Result<record::Reader> reader = record::Reader::open(path);
  ASSERT_TRUE(reader.ok()) << reader.error().message();
  const graph::Graph& graph = reader->app().graph;
  std::map<NodeId, std::uint64_t> runs;
  std::map<SubchainId, std::uint64_t> triggers;
  ASSERT_TRUE(reader->each_run([&](const record::Run& run) { EXPECT_EQ(run.number, ++runs[run.node]); }).ok());
  ASSERT_TRUE(reader
                  ->each_trigger(
                      [&](const record::Trigger& trigger) { EXPECT_EQ(trigger.number, ++triggers[trigger.subchain]); })
                  .ok());
  EXPECT_EQ(triggers.size(), graph.subchains().size());
  for (const auto& [subchain, sent] : triggers) {
    const graph::Subchain& of = graph.subchain(subchain);
    EXPECT_GT(sent, 100U) << of.name;
    EXPECT_LE(runs[of.nodes.front()], sent) << of.name;
    EXPECT_GE(runs[of.nodes.front()] + 1, sent) << of.name;
  }
}

// Whatever happens to cores and costs, every node's runs are numbered without a gap, and no trigger is lost.
TEST_F(SharedTest, MovesFromCoreToCoreLoseNoRun) {
  // map becomes so cheap that it may share with fast, then so expensive that it wants a core of its own.
  cost = [this](const std::string& node, std::uint64_t run) {
    if (node != "map") return costs.at(node);
    return run % 200 < 100 ? Nanos{milliseconds{40}} : Nanos{milliseconds{1}};
  };
  const std::string path = testing::TempDir() + "catan_moves_" + std::to_string(getpid()) + ".catan";
  open(robot_app(), "catan", 2, path);
  const Snapshot snapshot = run_for(seconds{30});
  expect_nothing_lost(path);
  std::remove(path.c_str());
  EXPECT_GT(snapshot.plans, 4U);
  EXPECT_EQ(snapshot.notices, std::vector<std::string>());
  EXPECT_GT(rate(snapshot, "scan"), 100.0);
  EXPECT_GT(rate(snapshot, "map"), 10.0);
  EXPECT_LT(snapshot.chains[0].response_ms.max, 200.0) << "no trigger was deferred for long";
}

TEST_F(SharedTest, AHangIsSuspendedAndTheRestKeepsItsRates) {
  cost = [this](const std::string& node, std::uint64_t run) {
    return node == "map" && run == 30 ? Nanos{seconds{3}} : costs.at(node);
  };
  open(robot_app(), "catan", 1);
  // What the others leave may be no more than the slack.
  const Snapshot snapshot = run_for(seconds{60});
  ASSERT_EQ(snapshot.notices.size(), 2U);
  EXPECT_EQ(snapshot.notices[0], "watchdog: a run of subchain map hangs: it was suspended");
  EXPECT_EQ(snapshot.notices[1], "watchdog: the run of subchain map that hung has ended: it is scheduled as before");
  // It had its budget, twice what it costs, even where others take turns with it.
  EXPECT_LT(snapshot.chains[0].response_ms.max,
            3.0 * snapshot.chains[0].response_ms.p50 + 2.0 * to_millis(costs.at("map")).count());
}

graph::App with_a_driver(const std::string& period) {
  return parse(R"(
catan: 1
app: driven
nodes:
  imu: { unscheduled: true, period: )" +
               period + R"( }
  left: { fallback_rate: 20Hz, max_rate: 50Hz }
edges: [ imu -> left ]
objective: [ { period: left, weight: 1 } ]
)");
}

// It is above all that are scheduled, and no controller holds it.
TEST_F(SharedTest, AHangOfAnUnscheduledNodeIsAtTheOrdinaryLevelUntilItsNextRun) {
  costs = {{"imu", milliseconds{1}}, {"left", milliseconds{5}}};
  std::atomic<int> left{0};
  cost = [&](const std::string& node, std::uint64_t run) {
    if (node == "left") ++left;
    return node == "imu" && run == 100 ? Nanos{seconds{10}} : costs.at(node);
  };
  std::atomic<os::ThreadId> imu{};
  wait = [&](const std::string& node, std::uint64_t /*run*/) {
    if (node == "imu") imu = fake.current_thread();
    return Nanos{0};
  };
  open(with_a_driver("10ms"), "catan", 2);
  start();
  pass(milliseconds{500});
  EXPECT_GE(*fake.level(imu), os::Level::kUnscheduled);
  pass(milliseconds{1300});
  EXPECT_GE(*fake.level(imu), os::Level::kUnscheduled) << "not a second of CPU time yet";
  pass(milliseconds{500});
  EXPECT_EQ(*fake.level(imu), os::Level::kOrdinary);
  const int before = left;
  pass(seconds{5});
  EXPECT_GE(left - before, 240) << "each 20 ms";
  EXPECT_EQ(*fake.level(imu), os::Level::kOrdinary);
  pass(seconds{7});
  EXPECT_GE(*fake.level(imu), os::Level::kUnscheduled) << "as before";
  const Snapshot snapshot = engine->snapshot();
  EXPECT_TRUE(engine->stop().ok());
  EXPECT_EQ(snapshot.notices,
            std::vector<std::string>{
                "watchdog: run 100 of imu has used 1 s of CPU time: its threads are at the ordinary level until the "
                "next"});
}

TEST_F(SharedTest, AnUnscheduledRunThatWaitsForLongKeepsItsLevel) {
  costs = {{"imu", milliseconds{1}}, {"left", milliseconds{5}}};
  std::atomic<os::ThreadId> imu{};
  wait = [&](const std::string& node, std::uint64_t run) {
    if (node == "imu") imu = fake.current_thread();
    return node == "imu" && run == 20 ? Nanos{seconds{8}} : Nanos{0};
  };
  open(with_a_driver("10ms"), "catan", 2);
  start();
  pass(seconds{5});
  EXPECT_GE(*fake.level(imu), os::Level::kUnscheduled);
  EXPECT_TRUE(engine->snapshot().notices.empty());
  EXPECT_TRUE(engine->stop().ok());
}

TEST_F(SharedTest, TheEndDoesNotWaitForATimer) {
  costs = {{"imu", milliseconds{1}}, {"left", milliseconds{5}}};
  open(with_a_driver("60s"), "catan", 1);
  start();
  pass(seconds{1});
  const TimePoint asked = fake.now();
  EXPECT_TRUE(engine->stop().ok());
  EXPECT_LT(fake.now() - asked, milliseconds{200});
}

// Others may get their numbers, and there is room for 64 threads a node.
TEST_F(SharedTest, AdoptedThreadsThatHaveEndedAreForgotten) {
  open(robot_app(), "catan", 1);
  start();
  for (int i = 0; i < 70; ++i) {
    const auto helper = fake.spawn("helper", [&] {
      const Status adopted = engine->adopt_this_thread("map");
      EXPECT_TRUE(adopted.ok()) << i << ": " << adopted.error().message();
      fake.sleep_until(fake.now() + milliseconds{10});
    });
    helper->join();
    pass(milliseconds{60});
  }
  EXPECT_TRUE(engine->stop().ok());
}

TEST_F(SharedTest, WithoutPermissionRatesAreKeptAndLevelsLeftAlone) {
  fake.set_real_time_facts({false, "no right to", 0.05, "fair server"});
  open(in_frames(robot_app()), "catan", 1);
  const Snapshot snapshot = run_for(seconds{10});
  EXPECT_FALSE(snapshot.real_time);
  ASSERT_FALSE(snapshot.notices.empty());
  EXPECT_EQ(snapshot.notices[0], "rates-only: no right to");
  for (const os::FakeCpus::Stretch& stretch : fake.stretches()) EXPECT_EQ(stretch.level, os::Level::kOrdinary);
  // Without levels, turns on the core are not as planned to the last run.
  expect_planned_rates(
      engine->app(), snapshot,
      *planner::make_plan_in_frames(engine->app(), known_costs(engine->app()), {.cores = 1, .slack = 0.06}), 0.02);
}

TEST_F(SharedTest, FixedPrioritiesStarveWhoIsLast) {
  // 50 x 6 ms and 5 x 160 ms a second are more than there is: nothing is left for log, which comes last.
  costs["map"] = milliseconds{160};
  std::map<std::string, int> began;
  cost = [&](const std::string& node, std::uint64_t /*run*/) {
    ++began[node];
    return costs.at(node);
  };
  open(robot_app(), "fifo", 1);
  start();
  pass(seconds{10} - milliseconds{1});  // before the next trigger of scan
  const Snapshot snapshot = engine->snapshot();
  EXPECT_EQ(began["scan"], 500);
  EXPECT_EQ(began["map"], 44) << "500 runs of 6 ms leave 7 s, in which 43.75 runs end";
  EXPECT_EQ(began["log"], 0);
  EXPECT_TRUE(engine->stop().ok());
  EXPECT_NEAR(rate(snapshot, "scan"), 50.0, 0.5);
  EXPECT_NEAR(rate(snapshot, "map"), 700.0 / 160.0, 0.2) << "but for the runs at the ends of what is measured";
  EXPECT_EQ(rate(snapshot, "log"), 0.0);
}

// The made-up machine has no fair server: for what planning is to be left to ordinary threads while all is on one CPU,
// rates are capped.
TEST_F(SharedTest, ACpuThatGoesIsPlannedWithoutUntilItComesBack) {
  open(robot_app(", max_rate: 60Hz", ", max_rate: 6Hz"), "catan", 2);
  ASSERT_TRUE(engine->start().ok());
  fake.sleep_until(fake.now() + seconds{5});
  const std::uint64_t before = engine->snapshot().plans;
  fake.set_cpu_online(1, false);
  fake.sleep_until(fake.now() + milliseconds{300});
  EXPECT_EQ(engine->snapshot().plans, before + 1) << "at once, not with the next plan that is due";
  fake.sleep_until(fake.now() + seconds{5});
  fake.set_cpu_online(1, true);
  fake.sleep_until(fake.now() + seconds{5});
  const Snapshot snapshot = engine->snapshot();
  EXPECT_TRUE(engine->stop().ok());
  ASSERT_EQ(snapshot.notices.size(), 2U);
  EXPECT_EQ(snapshot.notices[0], "cpus: of CPUs 0-1, 0 are online and allowed: planning for these");
  EXPECT_EQ(snapshot.notices[1], "cpus: of CPUs 0-1, 0-1 are online and allowed: planning for these");
  EXPECT_GE(snapshot.plans, before + 2);
  EXPECT_GT(rate(snapshot, "scan"), 50.0);
  EXPECT_GT(rate(snapshot, "map"), 4.0);
  Nanos late{0};  // on the CPU that came back
  for (const os::FakeCpus::Stretch& stretch : fake.stretches()) {
    if (stretch.cpu == 1 && stretch.begin > TimePoint{seconds{11}}) late += stretch.end - stretch.begin;
  }
  EXPECT_GT(late, milliseconds{500});
}

// A sensor, what follows it, what follows that, and two that are scheduled.
graph::App headset(const std::string& of_sum = "") {
  return parse(R"(
catan: 1
app: headset
nodes:
  imu: { unscheduled: true, period: 5ms }
  sum: { unscheduled: true)" +
               of_sum + R"( }
  guess: { unscheduled: true }
  warp: { min_rate: 60Hz, max_rate: 60Hz, fallback_rate: 60Hz }
  look: { fallback_rate: 10Hz }
edges: [ imu -> sum -> guess -> warp, look -> warp ]
objective:
  - { response_time: [guess, warp], weight: 1 }
  - { response_time: [imu, sum, guess], weight: 0.1 }
  - { response_time: [look, warp], weight: 0.1 }
scheduler: { bootstrap: 1s }
)");
}

class FollowersTest : public SharedTest {
 protected:
  FollowersTest() {
    costs = {{"imu", microseconds{100}},
             {"sum", microseconds{200}},
             {"guess", microseconds{300}},
             {"warp", milliseconds{2}},
             {"look", milliseconds{20}}};
  }

  // Runs of the record of a run that has ended, by node.
  static std::map<std::string, std::vector<record::Run>> runs_of(const std::string& path) {
    std::map<std::string, std::vector<record::Run>> runs;
    const Result<record::Reader> reader = record::Reader::open(path);
    EXPECT_TRUE(reader.ok());
    if (!reader) return runs;
    const graph::Graph& graph = reader->app().graph;
    EXPECT_EQ(graph.node(*graph.find_node("sum")).follows, graph.find_node("imu"));
    EXPECT_TRUE(reader->each_run([&](const record::Run& run) { runs[graph.node(run.node).name].push_back(run); }).ok());
    return runs;
  }
};

TEST_F(FollowersTest, BeginWithTheOutputThatSetThemOff) {
  const std::string path = testing::TempDir() + "catan_followers.catan";
  for (const char* policy : {"catan", "default", "fifo"}) {
    SCOPED_TRACE(policy);
    std::remove(path.c_str());
    open(headset(), policy, 2, path);
    const Snapshot snapshot = run_for(seconds{5});
    EXPECT_TRUE(snapshot.notices.empty());
    EXPECT_NEAR(rate(snapshot, "sum"), 200.0, 4.0);
    EXPECT_NEAR(rate(snapshot, "guess"), 200.0, 4.0);
    const ChainSnapshot& chain = snapshot.chains[1];
    EXPECT_NEAR(chain.latency_ms.p50, 0.6, 1e-6);
    EXPECT_LE(chain.latency_ms.max, policy == std::string("default") ? 5.0 : 0.6 + 1e-6);
    auto runs = runs_of(path);
    ASSERT_GT(runs["sum"].size(), 900U);
    ASSERT_LE(runs["sum"].size(), runs["imu"].size());
    for (std::size_t index = 0; index < runs["sum"].size(); ++index) {
      ASSERT_EQ(runs["sum"][index].consumed.size(), 1U);
      EXPECT_EQ(runs["sum"][index].consumed[0].last, runs["imu"][index].number);
      EXPECT_GE(runs["sum"][index].begin, runs["imu"][index].end);
    }
  }
  std::remove(path.c_str());
}

TEST_F(FollowersTest, RunOnOutputAlone) {
  silent = [](const std::string& node, std::uint64_t run) { return node == "imu" && run % 4 != 0; };
  open(headset(), "catan", 2);
  const Snapshot snapshot = run_for(seconds{10});
  EXPECT_NEAR(rate(snapshot, "imu"), 200.0, 4.0);
  EXPECT_NEAR(rate(snapshot, "sum"), 50.0, 1.0);
  EXPECT_NEAR(rate(snapshot, "guess"), 50.0, 1.0);
}

TEST_F(FollowersTest, ThatAreBusyRunOnceMore) {
  costs["sum"] = milliseconds{8};
  costs["look"] = milliseconds{2};
  open(headset(), "default", 2);
  const Snapshot snapshot = run_for(seconds{5});
  EXPECT_NEAR(rate(snapshot, "sum"), 125.0, 5.0);
  EXPECT_LE(snapshot.chains[1].latency_ms.max, 0.1 + 5.0 + 8.0 + 0.3 + 2.5) << "the newest, not what waits in a row";
}

TEST_F(FollowersTest, WithAPeriodOfTheirOwnHaveATimer) {
  open(headset(", period: 5ms"), "catan", 2);
  const Snapshot snapshot = run_for(seconds{5});
  EXPECT_NEAR(rate(snapshot, "sum"), 200.0, 4.0);
  EXPECT_GT(snapshot.chains[1].latency_ms.p50, 5.0) << "both begin at once, so it has the output before";
}

TEST_F(SharedTest, AGivenPlanIsFollowedAndNeverRevised) {
  const graph::App app = robot_app();
  const model::CostTable guess(app.graph, Millis{10});
  const plan::Plan plan = *planner::make_plan_in_frames(app, guess, {.cores = 1, .slack = 0.06});
  for (const graph::FrameMode frames : {graph::FrameMode::kElastic, graph::FrameMode::kFixed}) {
    os::FakeOs machine;
    machine.share_cpus(true);
    Result<std::unique_ptr<Engine>> made =
        Engine::create(robot_app(), machine,
                       {.policy = std::make_shared<policy::StaticPolicy>("static", plan),
                        .cpus = os::CpuSet{0},
                        .record = {},
                        .note = {},
                        .frames = frames,
                        .on_notice = {}});
    ASSERT_TRUE(made.ok());
    for (const char* node : {"scan", "steer", "map", "log"}) {
      (*made)->wiring().set_body(node, [&](ctn::Run&) { machine.burn(milliseconds{2}); });
    }
    const Status started = (*made)->start();
    ASSERT_TRUE(started.ok()) << started.error().message();
    machine.sleep_until(machine.now() + seconds{5});
    EXPECT_EQ((*made)->snapshot().plans, 1U);
    EXPECT_GT(rate((*made)->snapshot(), "scan"), 10.0);
    EXPECT_TRUE((*made)->stop().ok());
  }
}

TEST_F(SharedTest, AllLevelsAreRestored) {
  open(robot_app(), "catan", 2);
  run_for(seconds{3});
  std::map<os::ThreadId, os::Level> last;
  for (const os::FakeOs::Change& change : fake.changes()) {
    if (change.level) last[change.thread] = *change.level;
  }
  EXPECT_GT(last.size(), 6U);
  for (const auto& [thread, level] : last) EXPECT_EQ(level, os::Level::kOrdinary) << static_cast<int>(thread);
}

}  // namespace
}  // namespace ctn::runtime
