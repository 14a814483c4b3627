// Apps in virtual time, each worked by hand, on a machine where scheduling costs nothing.
#include "sim/simulation.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/testing/apps.h"
#include "policy/planned.h"
#include "record/reader.h"
#include "sim/batch.h"
#include "sim/json.h"
#include "sim/testing/outcomes.h"

namespace ctn::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(Simulation, OneSubchainAtAHandSetRate) {
  const Outcome outcome = simulate(parse(kRow), kRowCosts, "default");
  const ChainOutcome& chain = outcome.chains.front();
  EXPECT_DOUBLE_EQ(chain.latency_ms.max, 13.0);
  EXPECT_DOUBLE_EQ(chain.latency_ms.mean, 13.0);
  EXPECT_DOUBLE_EQ(chain.period_ms.mean, 20.0);
  EXPECT_DOUBLE_EQ(chain.response_ms.max, 33.0) << "begin of the frame before to the end: 20 + 13";
  EXPECT_EQ(chain.over_bound, chain.response_ms.count);
  EXPECT_NEAR(node(outcome, "detect").rate_hz, 50.0, 0.06);
  EXPECT_NEAR(outcome.cores.front().ordinary, 0.65, 0.001);
  EXPECT_EQ(outcome.plans_made, 0U);
}

TEST(Simulation, TellsHowFarItIsAndIsTheSame) {
  const graph::App app = parse(kRow);
  const auto run = [&](const std::function<void(double)>& on_progress) {
    auto costs = std::make_unique<DrawnCosts>(app, parse_costs(app, kRowCosts), 1);
    return to_json({{1, *simulate(app, std::move(costs), on_ideal_machine(*policy::make_policy("catan")), seconds{45},
                                  on_progress)}},
                   1);
  };
  std::vector<double> parts;
  EXPECT_EQ(run([&](double part) { parts.push_back(part); }), run({}));
  ASSERT_GE(parts.size(), 4U);
  EXPECT_TRUE(std::is_sorted(parts.begin(), parts.end()));
  EXPECT_GT(parts.front(), 0.0);
  EXPECT_GT(parts.back(), 0.7);
  EXPECT_LT(parts.back(), 1.0);
}

// Catan triggers the next run as soon as the last has ended: 13 + 13.
TEST(Simulation, OneSubchainByFormulas) {
  const Outcome outcome = simulate(in_frames(parse(kRow)), kRowCosts, "catan");
  const ChainOutcome& chain = outcome.chains.front();
  EXPECT_NEAR(chain.response_ms.mean, 26.0, 0.001);
  EXPECT_NEAR(*chain.predicted_ms, 26.0, 0.001);
  EXPECT_NEAR(*outcome.objective, *outcome.objective_predicted, 0.001);
  EXPECT_EQ(chain.over_bound, 0U);
  EXPECT_NEAR(outcome.cores.front().real_time, 1.0, 0.001);
}

// Run `number` of a node takes two seconds if the number is in the list, else 10 ms.
class SometimesHangs : public RunCosts {
 public:
  explicit SometimesHangs(std::vector<std::uint64_t> hung) : hung_(std::move(hung)) {}
  int threads_used(NodeId /*node*/, int /*most*/) const override { return 1; }
  model::RunDraw draw(NodeId /*node*/, std::uint64_t number, Nanos /*since_start*/, int /*threads*/,
                      std::size_t /*kind*/) override {
    const bool hangs = std::find(hung_.begin(), hung_.end(), number) != hung_.end();
    return {.cpu = hangs ? seconds{2} : milliseconds{10}};
  }

 private:
  std::vector<std::uint64_t> hung_;
};

TEST(Simulation, RunsThatHungAloneDoNotMakeThePlan) {
  const graph::App app = parse(R"(
catan: 1
app: lone
nodes: { lone: {} }
objective: [ { response_time: [lone], weight: 1 } ]
scheduler: { slack: 0%, bootstrap: 1s }
)");
  const auto outcome_of = [&](std::vector<std::uint64_t> hung) {
    const Options options = on_ideal_machine(std::make_shared<policy::FormulaPolicy>());
    return *sim::simulate(app, std::make_unique<SometimesHangs>(std::move(hung)), options, seconds{20});
  };
  const Outcome alone = outcome_of({600, 620, 640});
  EXPECT_EQ(alone.hangs, 3U);
  EXPECT_EQ(std::count(alone.notices.begin(), alone.notices.end(),
                       "watchdog: a run of subchain lone hangs: it was suspended"),
            3)
      << "told as in life";
  EXPECT_NEAR(*alone.objective_predicted, 20.0, 1e-6);
  EXPECT_EQ(alone.plans_adopted, 2U) << "the one of the bootstrap and the measured one";
  EXPECT_GT(outcome_of({600, 601, 602, 603, 604, 605}).plans_adopted, 2U) << "the node has become that slow";
}

// From run 200 on, runs take twice as long.
class Doubles : public RunCosts {
 public:
  int threads_used(NodeId /*node*/, int /*most*/) const override { return 1; }
  model::RunDraw draw(NodeId /*node*/, std::uint64_t number, Nanos /*since_start*/, int /*threads*/,
                      std::size_t /*kind*/) override {
    return {.cpu = milliseconds{number < 200 ? 5 : 10}};
  }
};

// As a live record has it.
TEST(Simulation, ARecordHasCostChangesUnderAPolicyThatDoesNotAdapt) {
  const graph::App app = parse(R"(
catan: 1
app: lone
nodes: { lone: { fallback_rate: 50Hz } }
objective: [ { response_time: [lone], weight: 1 } ]
scheduler: { bootstrap: 1s }
)");
  const std::string path = testing::TempDir() + fmt::format("doubles_{}.catan", getpid());
  std::remove(path.c_str());
  Options options = on_ideal_machine(*policy::make_policy("default"));
  options.recording = {.path = path, .note = {}};
  const Outcome outcome = *sim::simulate(app, std::make_unique<Doubles>(), options, seconds{10});
  EXPECT_EQ(outcome.cost_changes, 1U);
  const auto record = record::Reader::open(path);
  ASSERT_TRUE(record.ok()) << record.error().message();
  ASSERT_EQ(record->cost_changes()->size(), 1U);
  EXPECT_EQ(record->cost_changes()->front().before, milliseconds{5});
  EXPECT_EQ(record->cost_changes()->front().after, milliseconds{10});
  std::remove(path.c_str());
}

// Plans once, and then no more.
class PlansOnce : public policy::Policy {
 public:
  PlansOnce() : Policy("once"), real_(*policy::make_policy("catan")) {}
  bool follows_plan() const override { return true; }
  bool adapts() const override { return true; }
  bool raises() const override { return true; }
  Result<policy::Decision> decide(const policy::Situation& situation) const override {
    return real_->decide(situation);
  }
  Result<std::optional<policy::Decision>> decide_again(const policy::Situation& /*situation*/,
                                                       const policy::Decision& /*in_force*/) const override {
    return Error::caller("there is no plan", "ask for less");
  }

 private:
  std::shared_ptr<const policy::Policy> real_;
};

TEST(Simulation, APlanThatCannotBeMadeIsToldAsInLife) {
  const graph::App app = parse(kRow);
  Options options{.policy = std::make_shared<PlansOnce>()};
  const Outcome outcome =
      *sim::simulate(app, std::make_unique<DrawnCosts>(app, parse_costs(app, kRowCosts), 1), options, seconds{20});
  ASSERT_EQ(outcome.notices.size(), 1U);
  EXPECT_EQ(outcome.notices.front().find("replan-failed: "), 0U) << outcome.notices.front();
  EXPECT_EQ(outcome.plans_adopted, 1U);
  EXPECT_GT(outcome.plans_made, 1U);
  EXPECT_NE(to_json({{1, outcome}}, 1).find("replan-failed"), std::string::npos);
}

TEST(Simulation, ANodeThatNeverGetsAnInputDoesNotHoldUpPlanning) {
  const graph::App app = parse(R"(
catan: 1
app: silent
nodes: { listen: {}, answer: {}, drive: {} }
edges: [ listen -> answer ]
subchains: { talk: [listen, answer] }
objective: [ { response_time: [listen, answer], weight: 1 }, { period: drive, weight: 1 } ]
scheduler: { slack: 0%, bootstrap: 1s }
)");
  auto simulation = simulation_of(app, "listen: 2ms\nanswer: 3ms\ndrive: 4ms\n", "catan", 2);
  simulation->set_body(*app.graph.find_node("listen"), [](ctn::Run& run) { run.skip_output(); });
  simulation->run_for(seconds{5});
  ASSERT_TRUE(simulation->plan());
  const plan::Plan& plan = *simulation->plan();
  EXPECT_EQ(plan.assumed, (std::vector<plan::AssumedCost>{{*app.graph.find_node("answer"), Millis{5}}}));
  EXPECT_NEAR(plan.subchains[app.graph.find_subchain("talk")->index()].execution.count(), 7.0, 0.1);
  EXPECT_NEAR(plan.subchains[app.graph.find_subchain("drive")->index()].period.count(), 4.0, 0.1);
  const Outcome outcome = simulation->outcome();
  EXPECT_EQ(outcome.notices,
            (std::vector<std::string>{"assumed-costs: these nodes have not run, and are planned at compute times that "
                                      "are assumed: answer (5 ms)"}));
}

// On two cores that it owns, detect works on one frame while the camera takes the next: every 10 ms, latency 13 ms.
TEST(Simulation, ASubchainOverTwoCoresIsAPipeline) {
  const Outcome outcome = simulate(parse(kRow), kRowCosts, "catan", 2);
  const ChainOutcome& chain = outcome.chains.front();
  EXPECT_NEAR(chain.period_ms.mean, 10.0, 0.05);
  EXPECT_NEAR(chain.response_ms.mean, 23.0, 0.2);
  EXPECT_LE(chain.response_ms.p95, *chain.predicted_ms * 1.01);
}

TEST(Simulation, WorkersShareARunOfAParallelNode) {
  std::string text = kRow;
  text.replace(text.find("detect: {}"), 10, "detect: { max_threads: 2 }");
  const graph::App app = parse(text);
  const Outcome outcome = simulate(app, kRowCosts, "default", 2);
  EXPECT_DOUBLE_EQ(outcome.chains.front().latency_ms.max, 8.0) << "detect: twice 5 ms at the same time";
  EXPECT_DOUBLE_EQ(node(outcome, "detect").compute_ms.mean, 10.0) << "all threads added up";
}

// A node that may use four cores, and is hardly faster on two than on one, and no faster on more: assumed to scale, it
// is tried on four threads, on three and on two, and then stays where it is best.
TEST(Simulation, WhatRunsTakeOnSeveralThreadsIsMeasuredAndPlannedWith) {
  const graph::App app = parse(R"(
catan: 1
app: lone
nodes: { lone: { max_threads: 4 } }
objective: [ { response_time: [lone], weight: 1 } ]
scheduler: { slack: 0%, bootstrap: 1s }
)");
  const auto check = [](const graph::App& planned, const char* costs, int threads, double response_ms) {
    auto simulation = simulation_of(planned, costs, "catan", 4);
    simulation->run_for(seconds{15});
    ASSERT_TRUE(simulation->plan());
    EXPECT_EQ(simulation->plan()->subchains.front().threads, threads) << costs;
    EXPECT_NEAR(simulation->plan()->expected->chains.front().response.count(), response_ms, 0.03 * response_ms);
    EXPECT_LE(simulation->outcome().plans_adopted, 8U) << costs;
    EXPECT_EQ(simulation->outcome().cost_changes, 0U) << costs;
  };
  for (const graph::App& planned : {in_frames(app), app}) {
    check(planned, "lone: { threads: { 1: 10ms, 2: 9ms } }", 2, 18.0);
    check(planned, "lone: { threads: { 1: 10ms, 2: 15ms, 3: 20ms } }", 1, 20.0);
    check(planned, "lone: 10ms", 4, 5.0);
  }
}

TEST(Simulation, ARunThatWaitsGivesItsCoreAway) {
  const Outcome outcome = simulate(two_rates_app(), "a: { cost: 2ms, wait: 4ms }\nb: 12ms\n", "fifo");
  EXPECT_DOUBLE_EQ(outcome.chains[0].latency_ms.max, 6.0);
  // b has the core from 1 to 5, from 6 to 10, and, while the next run of a waits, from 11 to 15: 12 ms.
  EXPECT_DOUBLE_EQ(outcome.chains[1].latency_ms.max, 14.0);
  EXPECT_NEAR(outcome.cores.front().real_time, 0.2 + 0.6, 0.001) << "waits are no load";
  EXPECT_DOUBLE_EQ(node(outcome, "a").compute_ms.mean, 2.0);
  ASSERT_TRUE(node(outcome, "a").wait_ms);
  EXPECT_DOUBLE_EQ(node(outcome, "a").wait_ms->mean, 4.0);
  EXPECT_FALSE(node(outcome, "b").wait_ms);
}

// One run at a time: 13 ms and 7 ms of waiting.
TEST(Simulation, OneSubchainThatWaitsByFormulas) {
  const Outcome outcome =
      simulate(in_frames(parse(kRow)), "camera: 2ms\ndetect: { cost: 10ms, wait: 7ms }\nmotor: 1ms\n", "catan");
  const ChainOutcome& chain = outcome.chains.front();
  EXPECT_NEAR(chain.response_ms.mean, 40.0, 0.001);
  EXPECT_NEAR(*chain.predicted_ms, 40.0, 0.001);
  EXPECT_NEAR(outcome.cores.front().real_time, 0.65, 0.001);
}

// On two cores, detect is occupied for 17 ms of each run, and the cores for 13.
TEST(Simulation, APipelineThatWaitsIsAsFastAsItsSlowestNode) {
  const Outcome outcome =
      simulate(in_frames(parse(kRow)), "camera: 2ms\ndetect: { cost: 10ms, wait: 7ms }\nmotor: 1ms\n", "catan", 2);
  const ChainOutcome& chain = outcome.chains.front();
  EXPECT_NEAR(chain.period_ms.mean, 17.0, 0.1);
  EXPECT_NEAR(chain.latency_ms.mean, 20.0, 0.2);
}

TEST(Simulation, OfSeveralThreadsTheFirstWaits) {
  std::string text = kRow;
  text.replace(text.find("detect: {}"), 10, "detect: { max_threads: 2 }");
  const Outcome outcome =
      simulate(parse(text), "camera: 2ms\ndetect: { cost: 10ms, wait: 4ms }\nmotor: 1ms\n", "default", 2);
  EXPECT_DOUBLE_EQ(outcome.chains.front().latency_ms.max, 12.0);
  EXPECT_DOUBLE_EQ(node(outcome, "detect").compute_ms.mean, 10.0);
}

TEST(Simulation, FixedPrioritiesPreempt) {
  const Outcome outcome = simulate(two_rates_app(), "a: 3ms\nb: 12ms\n", "fifo");
  EXPECT_DOUBLE_EQ(outcome.chains[0].latency_ms.max, 3.0);
  // b begins at 3, is pre-empted from 10 to 13, and has its last 5 ms until 18.
  EXPECT_DOUBLE_EQ(outcome.chains[1].latency_ms.max, 15.0);
  EXPECT_DOUBLE_EQ(outcome.chains[1].response_ms.max, 35.0);
  EXPECT_NEAR(outcome.cores.front().real_time, 0.9, 0.001);
}

TEST(Simulation, AnOverloadedLowPriorityStarves) {
  const Outcome outcome = simulate(two_rates_app(), "a: 9ms\nb: 10ms\n", "fifo");
  EXPECT_NEAR(node(outcome, "a").rate_hz, 100.0, 0.1);
  EXPECT_NEAR(node(outcome, "b").rate_hz, 10.0, 0.2) << "1 of 10 ms is left";
}

TEST(Simulation, TwoNodesTakeTurnsOnOneCoreAsPlanned) {
  const Outcome outcome = simulate(two_rates_app(), "a: 3ms\nb: 12ms\n", "catan");
  for (const ChainOutcome& chain : outcome.chains) {
    EXPECT_NEAR(chain.response_ms.mean, *chain.predicted_ms, 0.02 * *chain.predicted_ms) << chain.path;
  }
  EXPECT_GE(outcome.cores.front().real_time, 0.99);
}

TEST(Simulation, UnscheduledNodesRunByThemselves) {
  const graph::App app = parse(R"(
catan: 1
app: imu
nodes: { imu: { unscheduled: true, period: 4ms }, fuse: { fallback_rate: 10Hz } }
edges: [ imu -> fuse ]
objective: [ { response_time: [imu, fuse], weight: 1 } ]
scheduler: { bootstrap: 1s }
)");
  for (const char* policy : {"default", "fifo", "catan"}) {
    const Outcome outcome = simulate(app, "imu: 0.1ms\nfuse: 10ms\n", policy);
    EXPECT_NEAR(node(outcome, "imu").rate_hz, 250.0, 1.0) << policy;
  }
}

TEST(Simulation, PhasesLastWhereRatesAreFixed) {
  const graph::App app = parse(R"(
catan: 1
app: sampled
nodes: { imu: { unscheduled: true, period: 10ms }, look: { fallback_rate: 50Hz } }
edges: [ imu -> look ]
objective: [ { response_time: [imu, look], weight: 1 } ]
scheduler: { bootstrap: 1s }
)");
  const auto latency = [&](milliseconds imu, milliseconds look) {
    Options options = on_ideal_machine(*policy::make_policy("default"));
    options.phases = {.nodes = {imu, Nanos{0}}, .subchains = {look}};
    const Outcome outcome = *sim::simulate(
        app, std::make_unique<DrawnCosts>(app, parse_costs(app, "imu: 1ms\nlook: 2ms\n"), 1), options, seconds{5});
    EXPECT_DOUBLE_EQ(outcome.chains.front().latency_ms.mean, outcome.chains.front().latency_ms.max);
    return outcome.chains.front().latency_ms.mean;
  };
  EXPECT_DOUBLE_EQ(latency(milliseconds{3}, milliseconds{7}), 6.0) << "it is 4 ms old when it is read";
  EXPECT_DOUBLE_EQ(latency(milliseconds{7}, milliseconds{3}), 8.0);
}

// The record of a simulation is read as any other, and simulating it again gives the same.
TEST(Simulation, IsRecorded) {
  const graph::App app = parse(R"(
catan: 1
app: two
nodes: { scan: { max_rate: 50Hz }, local: {}, plan: { max_rate: 5Hz } }
edges: [ scan -> local, local -> plan ]
subchains: { near: [scan, local] }
objective: [ { response_time: [scan, local], weight: 1 }, { response_time: [scan, local, plan], weight: 0.1 } ]
scheduler: { bootstrap: 1s, schedule: frames }
)");
  const std::string path = testing::TempDir() + fmt::format("simulated_{}.catan", getpid());
  std::remove(path.c_str());
  Options options{.policy = *policy::make_policy("catan")};
  options.recording = {.path = path, .note = "a note"};
  const auto costs = [&] {
    return std::make_unique<DrawnCosts>(
        app, parse_costs(app, "scan: 1ms\nlocal: { cost: 4ms, typical: 3ms }\nplan: 20ms\n"), 1);
  };
  const Outcome outcome = *sim::simulate(app, costs(), options, seconds{5});
  EXPECT_FALSE(sim::simulate(app, costs(), options, seconds{5}).ok()) << "nothing recorded is ever overwritten";

  const auto record = record::Reader::open(path);
  ASSERT_TRUE(record.ok()) << record.error().message();
  EXPECT_TRUE(record->ending().closed);
  EXPECT_EQ(record->header().scheduler, "catan");
  EXPECT_EQ(record->header().note, "a note");
  EXPECT_EQ(record->plans()->size(), outcome.plans_adopted);
  EXPECT_EQ(record->plans()->front().reason, "bootstrap");
  const TimePoint warm = TimePoint{} + record->header().warm_up;
  std::uint64_t runs = 0;
  std::uint64_t triggers = 0;
  std::uint64_t slots = 0;
  EXPECT_TRUE(
      record->each_run([&](const record::Run& run) { runs += run.node == NodeId(1) && run.end >= warm ? 1U : 0U; })
          .ok());
  EXPECT_TRUE(record->each_trigger([&](const record::Trigger& one) { triggers += one.sent >= warm ? 1U : 0U; }).ok());
  EXPECT_TRUE(record->each_slot([&](const record::SlotUse&) { ++slots; }).ok());
  EXPECT_NEAR(static_cast<double>(runs), node(outcome, "local").rate_hz * 5.0, 1.0);
  EXPECT_EQ(triggers, outcome.triggers);
  EXPECT_GT(slots, 100U);
  std::remove(path.c_str());
}

TEST(Simulation, SlowerCoresTakeLonger) {
  std::string text = kRow;
  text += "cores: { little: { count: 1, speed: 0.5 } }\n";
  const Outcome outcome = simulate(parse(text), kRowCosts, "rate:30");
  EXPECT_DOUBLE_EQ(outcome.chains.front().latency_ms.max, 26.0);
}

// Real functions in virtual time: what one writes the other reads when its run begins, and the world sees it at its
// end.
TEST(Simulation, BodiesRunAtTheirVirtualTime) {
  const graph::App app = parse(kRow);
  auto simulation = simulation_of(app, kRowCosts, "default");
  const NodeId camera = *app.graph.find_node("camera");
  const NodeId detect = *app.graph.find_node("detect");
  const NodeId motor = *app.graph.find_node("motor");
  Channel<TimePoint>& pictures = simulation->channel<TimePoint>(camera, detect);
  Channel<TimePoint>& found = simulation->channel<TimePoint>(detect, motor);
  std::vector<std::pair<Nanos, Nanos>> ages;  // of the picture: when the motor begins, when it is done
  std::optional<TimePoint> acted_on;
  simulation->set_body(camera, [&](ctn::Run& run) { pictures.write(run, simulation->now()); });
  simulation->set_body(detect, [&](ctn::Run& run) {
    if (run.number() % 2 == 0) return run.skip_output();
    if (const TimePoint* taken = pictures.read(run)) found.write(run, *taken);
  });
  simulation->set_body(motor, [&](ctn::Run& run) {
    acted_on.reset();
    if (const TimePoint* taken = found.read(run)) acted_on = *taken;
    ages.emplace_back(simulation->now() - acted_on.value_or(TimePoint{}), Nanos{0});
  });
  simulation->set_effect(motor,
                         [&](ctn::Run&) { ages.back().second = simulation->now() - acted_on.value_or(TimePoint{}); });
  simulation->run_for(seconds{5});
  ASSERT_GT(ages.size(), 100U);
  for (const auto& [begin, end] : ages) {
    EXPECT_EQ(begin, milliseconds{12});
    EXPECT_EQ(end, milliseconds{13});
  }
  EXPECT_NEAR(node(simulation->outcome(), "motor").rate_hz, 25.0, 0.5);
}

// Costs that vary, plans that follow: the whole of it, twice, and in any number of threads.
TEST(Simulation, EqualSeedsGiveEqualBytes) {
  const graph::App app = robot_app();
  const std::string costs =
      "scan: 1ms\nsteer: { cost: 4ms, typical: 3ms, spikes: [0.02, 5ms] }\nmap: { cost: 40ms, typical: 20ms }\n"
      "log: { cost: 3ms, typical: 1ms }\n";
  const auto all = [&](const std::string& policy, std::size_t threads) {
    std::vector<Seeded> runs(4);
    for_each_in_parallel(runs.size(), threads, [&](std::size_t index) {
      auto simulation = simulation_of(app, costs, policy, 2, index, false);
      simulation->run_for(seconds{5});
      runs[index] = {index, simulation->outcome()};
    });
    return to_json(runs, 2);
  };
  for (const char* policy : {"catan", "default", "fifo"}) {
    const std::string once = all(policy, 1);
    EXPECT_EQ(once, all(policy, 3)) << policy;
    EXPECT_NE(once.find("\"seed\": 3"), std::string::npos);
  }
}

TEST(Simulation, SaysWhatItCannotDo) {
  const graph::App app = parse(R"(
catan: 1
app: one
nodes: { a: {} }
objective: [ { response_time: [a], weight: 1 } ]
)");
  const auto make = [&](const char* policy, int cores) {
    Options options{.policy = *policy::make_policy(policy)};
    options.machine.cores = cores;
    return Simulation::create(app, std::make_unique<DrawnCosts>(app, parse_costs(app, "a: 1ms\n"), 1), options);
  };
  EXPECT_FALSE(make("default", 1).ok()) << "no fallback_rate";
  EXPECT_FALSE(make("catan", 0).ok());
  EXPECT_FALSE(make("catan", 1000).ok());
  EXPECT_TRUE(make("catan", 1).ok());
}

}  // namespace
}  // namespace ctn::sim
