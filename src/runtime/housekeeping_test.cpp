// How a session follows what changes, in virtual time: the whole runtime, every figure exact.
#include "runtime/housekeeping.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/testing/apps.h"
#include "os/fake/busy_thread.h"
#include "os/fake/fake_os.h"
#include "plan/json.h"
#include "policy/planned.h"
#include "policy/replan.h"
#include "record/reader.h"
#include "runtime/engine.h"
#include "runtime/testing/virtual_session.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class HousekeepingTest : public VirtualSession {
 protected:
  HousekeepingTest() { costs = {{"fast", milliseconds{4}}, {"slow", milliseconds{10}}}; }
  ~HousekeepingTest() override { std::remove(path.c_str()); }

  void start(graph::App app, int cpus, std::shared_ptr<const policy::Policy> policy = *policy::make_policy("catan")) {
    std::remove(path.c_str());
    open(in_frames(std::move(app)), std::move(policy), cpus, path);
    VirtualSession::start();
  }

  // The record, once the session has stopped.
  record::Reader finished() {
    EXPECT_TRUE(engine->stop().ok());
    Result<record::Reader> reader = record::Reader::open(path);
    EXPECT_TRUE(reader.ok());
    return std::move(*reader);
  }
  static std::vector<std::string> reasons(const record::Reader& reader) {
    std::vector<std::string> reasons;
    for (const record::PlanChange& plan : *reader.plans()) reasons.push_back(plan.reason);
    return reasons;
  }

  // Its own file for each process: tests run at the same time.
  const std::string path = testing::TempDir() + "catan_housekeeping_" + std::to_string(::getpid()) + ".catan";
};

TEST_F(HousekeepingTest, ALastingChangeIsPlannedForAtOnceAndRecorded) {
  start(two_loops_app(), 1);
  pass(seconds{5});
  costs["fast"] = milliseconds{8};
  const TimePoint changed = fake.now();
  pass(seconds{3});
  EXPECT_EQ(engine->snapshot().cost_changes, 1U);
  EXPECT_TRUE(engine->snapshot().notices.empty());
  const record::Reader reader = finished();
  EXPECT_EQ(reasons(reader), (std::vector<std::string>{"bootstrap", "measured", "change"}));
  const TimePoint planned = reader.plans()->back().at;
  EXPECT_LT(planned - changed, milliseconds{400}) << "some twelve runs, and a look every 50 ms";
  const std::vector<record::CostChange> changes = *reader.cost_changes();
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].node, NodeId(0));
  EXPECT_EQ(changes[0].before, milliseconds{4});
  EXPECT_EQ(changes[0].after, milliseconds{8});
}

TEST_F(HousekeepingTest, NoiseAndSpikesAreNotPlannedFor) {
  std::uint64_t run = 0;
  cost = [&](const std::string& node, std::uint64_t /*run*/) {
    ++run;
    return costs.at(node) + Nanos{static_cast<Nanos::rep>((run * 2654435761U >> 8U) % 1000000)} +
           (run % 40 == 0 ? Nanos{milliseconds{10}} : Nanos{0});
  };
  start(two_loops_app(), 1);
  pass(seconds{30});
  EXPECT_EQ(engine->snapshot().cost_changes, 0U);
  EXPECT_EQ(engine->snapshot().plans, 2U);
  finished();
}

TEST_F(HousekeepingTest, AStormOfChangesMakesNoStormOfPlans) {
  start(parse(R"(
catan: 1
app: quick
nodes: { fast: {}, slow: { max_rate: 5Hz } }
objective:
  - { response_time: [fast], weight: 1 }
  - { response_time: [slow], weight: 0.1 }
scheduler: { bootstrap: 1s, replan: 1000s }
)"),
        2);
  costs["fast"] = milliseconds{1};
  pass(seconds{3});
  ASSERT_EQ(engine->snapshot().plans, 2U);
  // Four times as expensive for 100 ms, then as before, over and over. Each owns a core, so each change calls for
  // another pace, and is noticed within some twelve runs.
  cost = [this](const std::string& node, std::uint64_t /*run*/) {
    const auto turn = fake.now().time_since_epoch() / milliseconds{100};
    return costs.at(node) * (node == "fast" && turn % 2 == 0 ? 4 : 1);
  };
  pass(seconds{10});
  const std::uint64_t changes = engine->snapshot().cost_changes;
  const record::Reader reader = finished();
  std::vector<TimePoint> answers;
  for (const record::PlanChange& plan : *reader.plans()) {
    if (plan.reason == "change") answers.push_back(plan.at);
  }
  ASSERT_GE(answers.size(), 5U) << "the storm was answered";
  EXPECT_GT(changes, answers.size()) << "there were more changes than plans";
  for (std::size_t i = 1; i < answers.size(); ++i) EXPECT_GE(answers[i] - answers[i - 1], policy::kChangeSpacing) << i;
}

os::PowerState clocked(long khz) {
  os::PowerState state;
  state.on_mains = true;
  for (const int cpu : {0, 1}) state.cpus.push_back({cpu, khz, "performance"});
  return state;
}

TEST_F(HousekeepingTest, ALowerClockIsPlannedForBeforeAnyRunShowsIt) {
  fake.set_power_state(clocked(2000000));
  start(two_loops_app(), 1);
  pass(seconds{5});
  fake.set_power_state(clocked(1000000));
  on_notice = [this](const std::string&) { costs = {{"fast", milliseconds{8}}, {"slow", milliseconds{20}}}; };
  pass(seconds{4});
  const Snapshot snapshot = engine->snapshot();
  ASSERT_EQ(snapshot.notices.size(), 1U);
  EXPECT_EQ(snapshot.notices[0], "power: CPU 0 2000 MHz -> 1000 MHz");
  EXPECT_EQ(snapshot.cost_changes, 0U) << "it was expected";
  const record::Reader reader = finished();
  EXPECT_EQ(reasons(reader), (std::vector<std::string>{"bootstrap", "measured", "power"}));
  const plan::Plan plan = *plan::from_json(reader.plans()->back().json, reader.app(), "plan");
  EXPECT_NEAR(plan.subchains[1].slice.count() / plan.subchains[1].share, 20.0, 1e-6);
}

// What the kernel's fair server does, by a thread above all of ours: 50 ms in each second.
TEST_F(HousekeepingTest, WhatTheKernelTakesIsRecorded) {
  start(two_loops_app(), 1);
  const std::unique_ptr<os::Thread> server = fake.spawn("server", [this] {
    ASSERT_TRUE(fake.set_affinity(fake.current_thread(), os::CpuSet{0}).ok());
    ASSERT_TRUE(fake.set_level(fake.current_thread(), os::fixed_level(0)).ok());
    for (int strike = 0; strike < 5; ++strike) {
      fake.sleep_until(fake.now() + seconds{1});
      fake.burn(milliseconds{50});
    }
  });
  pass(seconds{7});
  const Snapshot snapshot = engine->snapshot();
  EXPECT_GE(snapshot.starved, 4U) << "of five; seen only where a timer ends in it";
  EXPECT_LE(snapshot.starved, 5U);
  EXPECT_NEAR(snapshot.starved_ms, 225.0, 50.0);
  ASSERT_EQ(snapshot.notices.size(), 1U) << "one, and then one every ten seconds";
  EXPECT_EQ(snapshot.notices[0].find("starved: CPU 0 was kept from real-time threads"), 0U) << snapshot.notices[0];
  finished();
  server->join();
}

constexpr const char* kBigAndLittle = R"(
catan: 1
app: loops
nodes: { fast: { max_rate: 20Hz }, slow: { max_rate: 5Hz } }
cores: { big: { count: 1, speed: 1 }, little: { count: 1, speed: 0.8 } }
objective:
  - { response_time: [fast], weight: 1 }
  - { response_time: [slow], weight: 0.1 }
scheduler: { bootstrap: 1s }
)";

TEST_F(HousekeepingTest, KindsOfCoresAreMeasuredApart) {
  // What the app says of the little core is not true: it is four times as slow.
  cost = [this](const std::string& node, std::uint64_t /*run*/) {
    return costs.at(node) * (fake.current_cpu() == 1 ? 4 : 1);
  };
  start(parse(kBigAndLittle), 2);
  pass(seconds{10});
  const record::Reader reader = finished();
  const plan::Plan plan = *plan::from_json(reader.plans()->back().json, reader.app(), "plan");
  EXPECT_EQ(plan.subchains[0].cores, std::vector<int>{0});
  EXPECT_NEAR(plan.subchains[0].execution.count(), 4.0, 1e-6);
  EXPECT_EQ(plan.subchains[1].cores, std::vector<int>{1});
  EXPECT_NEAR(plan.subchains[1].execution.count(), 40.0, 1e-6);
}

// Plans in frames, but it has no plan for one CPU until it is told.
class FailsOnOneCpu : public policy::PlannedPolicy {
 public:
  explicit FailsOnOneCpu(std::atomic<bool>& fails)
      : PlannedPolicy("fails"), fails_(fails), real_(std::make_shared<policy::FormulaPolicy>()) {}
  bool adapts() const override { return true; }
  Result<policy::Decision> decide(const policy::Situation& situation) const override {
    return real_->decide(situation);
  }
  Result<std::optional<policy::Decision>> decide_again(const policy::Situation& situation,
                                                       const policy::Decision& in_force) const override {
    if (fails_.load() && situation.cpus.size() == 1) return Error::caller("there is no plan", "wait");
    return real_->decide_again(situation, in_force);
  }

 private:
  std::atomic<bool>& fails_;
  std::shared_ptr<const policy::Policy> real_;
};

TEST_F(HousekeepingTest, NodesGoOnWhereACpuGoesForWhichThereIsNoPlan) {
  std::map<std::string, int> runs;
  std::map<int, int> on_cpu;
  cost = [&](const std::string& node, std::uint64_t) {
    ++runs[node];
    ++on_cpu[fake.current_cpu()];
    return costs.at(node);
  };
  std::atomic<bool> fails{true};
  graph::App app = two_loops_app();
  app.scheduler.replan = seconds{1};
  start(std::move(app), 2, std::make_shared<FailsOnOneCpu>(fails));
  pass(seconds{5});
  fake.set_cpu_online(0, false);
  pass(milliseconds{300});
  runs.clear();
  on_cpu.clear();
  pass(seconds{5});
  EXPECT_NEAR(runs["fast"], 500, 5) << "at the rate that was planned";
  EXPECT_NEAR(runs["slow"], 100, 5);
  EXPECT_EQ(on_cpu[0], 0);
  Snapshot snapshot = engine->snapshot();
  EXPECT_EQ(std::count_if(snapshot.notices.begin(), snapshot.notices.end(),
                          [](const std::string& notice) { return notice.starts_with("replan-failed: "); }),
            1);
  fails = false;
  pass(seconds{5});
  const record::Reader reader = finished();
  const plan::Plan last = *plan::from_json(reader.plans()->back().json, reader.app(), "plan");
  EXPECT_EQ(last.cores.size(), 1U) << "planned again as soon as there is a plan";
}

TEST_F(HousekeepingTest, ABigCoreThatGoesLeavesTheLittleOne) {
  struct Begun {
    std::string node;
    TimePoint at;
    int cpu;
  };
  std::vector<Begun> begun;
  cost = [&](const std::string& node, std::uint64_t /*run*/) {
    begun.push_back({node, fake.now(), fake.current_cpu()});
    return costs.at(node) * (fake.current_cpu() == 1 ? 4 : 1);
  };
  start(parse(kBigAndLittle), 2);
  pass(seconds{5});
  fake.set_cpu_online(0, false);
  const TimePoint went = fake.now();
  pass(seconds{5});
  const record::Reader reader = finished();
  const std::vector<record::PlanChange> plans = *reader.plans();
  const auto gone = std::find_if(plans.begin(), plans.end(), [](const auto& plan) { return plan.reason == "cpus"; });
  ASSERT_NE(gone, plans.end());
  EXPECT_LE(gone->at - went, milliseconds{200}) << "a look every 100 ms";

  // The last plan is for one core, which is the little one, with what runs cost there.
  const plan::Plan last = *plan::from_json(plans.back().json, reader.app(), "plan");
  ASSERT_EQ(last.cores.size(), 1U);
  for (const plan::SubchainPlan& subchain : last.subchains) EXPECT_EQ(subchain.cores, std::vector<int>{0});
  EXPECT_NEAR(last.subchains[0].slice.count() / last.subchains[0].share, 16.0, 1e-6);
  EXPECT_NEAR(last.subchains[1].slice.count() / last.subchains[1].share, 40.0, 1e-6);

  // And that is where runs are: both nodes go on there.
  std::map<std::string, int> runs;
  for (const Begun& run : begun) {
    if (run.at <= went) continue;  // at that instant it was still there
    EXPECT_EQ(run.cpu, 1) << run.node;
    ++runs[run.node];
  }
  EXPECT_GE(runs["fast"], 40);
  EXPECT_GE(runs["slow"], 10);
}

TEST_F(HousekeepingTest, KindsOfCoresThatAreNotTheSessionsCpusAreRefused) {
  const auto made = Engine::create(
      parse(kBigAndLittle), fake,
      {.policy = *policy::make_policy("catan"), .cpus = os::CpuSet{0}, .record = {}, .note = {}, .on_notice = {}});
  ASSERT_FALSE(made.ok());
  EXPECT_NE(made.error().message().find("1 big, 1 little"), std::string::npos) << made.error().message();
}

// `scales`: more threads make a run shorter.
int threads_of_runs(const std::string& policy, int cpus, bool scales = true) {
  os::FakeOs machine{os::fake_topology(2)};
  const graph::App app = parse(R"(
catan: 1
app: one
nodes: { solve: { max_threads: 2, fallback_rate: 10Hz } }
objective: [ { response_time: [solve], weight: 1 } ]
scheduler: { bootstrap: 1s }
)");
  auto made = Engine::create(
      app, machine,
      {.policy = *policy::make_policy(policy), .cpus = first_cpus(cpus), .record = {}, .note = {}, .on_notice = {}});
  EXPECT_TRUE(made.ok());
  int threads = 0;
  (*made)->wiring().set_body("solve", [&](ctn::Run& run) {
    threads = run.threads();
    machine.burn(milliseconds{10} / (scales ? threads : 1));
  });
  EXPECT_TRUE((*made)->start().ok());
  machine.sleep_until(machine.now() + seconds{4});
  EXPECT_TRUE((*made)->stop().ok());
  return threads;
}

TEST(ThreadsOfARun, AreThosePlannedOrAsManyAsItCanUse) {
  EXPECT_EQ(threads_of_runs("catan", 2), 2);
  EXPECT_EQ(threads_of_runs("catan", 1), 1);
  EXPECT_EQ(threads_of_runs("default", 2), 2);
}

TEST(ThreadsOfARun, AreNoMoreThanMakeItShorter) { EXPECT_EQ(threads_of_runs("catan", 2, false), 1); }

}  // namespace
}  // namespace ctn::runtime
