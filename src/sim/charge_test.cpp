// Runs that are charged for their work, each worked by hand, on a machine where scheduling costs nothing.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "config/testing/apps.h"
#include "record/reader.h"
#include "sim/testing/outcomes.h"

namespace ctn::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;

// `extra`: of the node, and of the file.
graph::App lone_node(const std::string& extra, const std::string& more = "") {
  return parse(fmt::format(R"(
catan: 1
app: lone
nodes: {{ work: {{ fallback_rate: 10Hz{} }} }}
objective: [ {{ response_time: [work], weight: 1 }} ]
scheduler: {{ slack: 0%, bootstrap: 1s }}
{})",
                           extra, more));
}

// A node of which the costs know nothing, unless they are given.
std::unique_ptr<Simulation> charging(const graph::App& app, Body body, int cores = 1, double slowdown = 1.0,
                                     const std::string& costs = "", const std::string& record = "") {
  Options options = on_ideal_machine(*policy::make_policy("default"), cores);
  if (!record.empty()) options.recording = {.path = record, .note = {}};
  const std::vector<double> slowdowns{slowdown};
  auto drawn = costs.empty() ? std::make_unique<DrawnCosts>(app, model::Workload(app.graph), 1, slowdowns,
                                                            std::vector<bool>{false})
                             : std::make_unique<DrawnCosts>(app, parse_costs(app, costs), 1, slowdowns);
  auto made = Simulation::create(app, std::move(drawn), options);
  EXPECT_TRUE(made.ok());
  (*made)->set_body(NodeId(0), std::move(body));
  return std::move(*made);
}

Outcome after_ten_seconds(Simulation& simulation) {
  simulation.run_for(simulation.warm_from() - TimePoint{} + seconds{10});
  EXPECT_TRUE(simulation.status().ok());
  return simulation.outcome();
}

TEST(Charge, AddsUpAndStandsInPlaceOfTheCost) {
  const graph::App app = lone_node("");
  for (const char* const costs : {"", "work: { cost: 90ms, grow: 10%/s, spikes: [0.5, 50ms] }"}) {
    auto simulation = charging(
        app,
        [](ctn::Run& run) {
          run.charge(milliseconds{3});
          run.charge(nanoseconds{0});
          run.charge(milliseconds{4});
        },
        1, 1.0, costs);
    const Outcome outcome = after_ten_seconds(*simulation);
    EXPECT_DOUBLE_EQ(node(outcome, "work").compute_ms.mean, 7.0) << costs;
    EXPECT_DOUBLE_EQ(node(outcome, "work").compute_ms.max, 7.0) << costs;
    EXPECT_DOUBLE_EQ(outcome.chains.front().latency_ms.max, 7.0) << costs;
  }
}

TEST(Charge, IsMultipliedByTheSlowdown) {
  auto simulation = charging(
      lone_node(""), [](ctn::Run& run) { run.charge(milliseconds{4}); }, 1, 2.5);
  EXPECT_DOUBLE_EQ(node(after_ten_seconds(*simulation), "work").compute_ms.mean, 10.0);
}

// Run by run: every second one is charged.
TEST(Charge, OfSomeRunsLeavesTheOthersAtTheirCost) {
  auto simulation = charging(
      lone_node(""),
      [](ctn::Run& run) {
        if (run.number() % 2 == 0) run.charge(milliseconds{2});
      },
      1, 1.0, "work: 6ms");
  const Outcome outcome = after_ten_seconds(*simulation);
  EXPECT_DOUBLE_EQ(node(outcome, "work").compute_ms.mean, 4.0);
  EXPECT_DOUBLE_EQ(node(outcome, "work").compute_ms.max, 6.0);
}

TEST(Charge, IsOfACoreOfSpeedOne) {
  const graph::App app = lone_node("", "cores: { little: { count: 1, speed: 0.5 } }");
  auto simulation = charging(
      app, [](ctn::Run& run) { run.charge(milliseconds{4}); }, 1);
  EXPECT_DOUBLE_EQ(node(after_ten_seconds(*simulation), "work").compute_ms.mean, 8.0);
}

TEST(Charge, IsSharedByTheThreadsOfTheRun) {
  const graph::App app = lone_node(", max_threads: 2");
  auto simulation = charging(
      app, [](ctn::Run& run) { run.charge(milliseconds{5} * run.threads()); }, 2);
  const Outcome outcome = after_ten_seconds(*simulation);
  EXPECT_DOUBLE_EQ(node(outcome, "work").compute_ms.mean, 10.0) << "all threads added up";
  EXPECT_DOUBLE_EQ(outcome.chains.front().latency_ms.mean, 5.0);
}

TEST(Charge, LeavesWhatTheRunWaits) {
  auto simulation = charging(
      lone_node(""), [](ctn::Run& run) { run.charge(milliseconds{2}); }, 1, 1.0, "work: { cost: 9ms, wait: 4ms }");
  const Outcome outcome = after_ten_seconds(*simulation);
  EXPECT_DOUBLE_EQ(node(outcome, "work").compute_ms.mean, 2.0);
  EXPECT_DOUBLE_EQ(outcome.chains.front().latency_ms.mean, 6.0);
}

// Every second run is charged; the others take four items each at 1 ms, not those of the run before, too.
TEST(Charge, TakesTheBatchOfTheRun) {
  const graph::App app = parse(R"(
catan: 1
app: two
nodes: { fast: { fallback_rate: 40Hz }, slow: { input: queue, fallback_rate: 10Hz } }
edges: [ fast -> slow ]
objective: [ { response_time: [fast, slow], weight: 1 } ]
scheduler: { slack: 0%, bootstrap: 1s }
)");
  auto simulation = simulation_of(app, "fast: 0ms\nslow: { cost: 2ms, per_item: 1ms }\n", "default", 2);
  simulation->set_body(NodeId(1), [](ctn::Run& run) {
    if (run.number() % 2 == 0) run.charge(milliseconds{3});
  });
  const Outcome outcome = after_ten_seconds(*simulation);
  EXPECT_DOUBLE_EQ(node(outcome, "slow").compute_ms.max, 6.0);
  EXPECT_DOUBLE_EQ(node(outcome, "slow").compute_ms.mean, 4.5);
}

// In a run that is not charged the mode is drawn: the file says that it is always `match`.
TEST(Charge, MakesTheModeTheFunctions) {
  const std::string path = testing::TempDir() + fmt::format("charged_modes_{}.catan", getpid());
  std::remove(path.c_str());
  auto simulation = charging(
      lone_node(", modes: [skip, match]"),
      [](ctn::Run& run) {
        if (run.number() == 1) run.set_mode(1);
        if (run.number() <= 2) run.charge(milliseconds{1});
        if (run.number() == 4) run.set_mode(0);
      },
      1, 1.0, "work: { modes: { skip: [0, 1ms], match: [1, 5ms] } }", path);
  simulation->run_for(milliseconds{350});
  ASSERT_TRUE(simulation->status().ok());
  ASSERT_TRUE(simulation->finish().ok());
  std::vector<std::uint32_t> modes;
  const auto record = record::Reader::open(path);
  ASSERT_TRUE(record.ok()) << record.error().message();
  ASSERT_TRUE(record->each_run([&](const record::Run& run) { modes.push_back(run.mode); }).ok());
  EXPECT_THAT(modes, ElementsAre(1U, 0U, 1U, 1U));
  std::remove(path.c_str());
}

// 240 hours are the longest run there is, charged or drawn.
TEST(Charge, HasAnEnd) {
  auto simulation = charging(lone_node(""), [](ctn::Run& run) {
    run.charge(nanoseconds::max());
    run.charge(nanoseconds::max());
  });
  simulation->run_for(seconds{1});
  EXPECT_TRUE(simulation->status().ok());
  EXPECT_EQ(simulation->now() - TimePoint{}, seconds{1});
}

// --- Mistakes ---

std::string mistake_of(Simulation& simulation, Nanos at) {
  simulation.run_for(seconds{1});
  EXPECT_FALSE(simulation.status().ok());
  if (simulation.status().ok()) return {};
  EXPECT_EQ(simulation.status().error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(simulation.now() - TimePoint{}, at) << "time stops there";
  simulation.run_for(seconds{1});
  EXPECT_EQ(simulation.now() - TimePoint{}, at) << "and does not go on";
  EXPECT_EQ(simulation.status().error().problems().size(), 1U);
  return simulation.status().error().message();
}

TEST(Charge, IsMissedWhereNoCostIsKnown) {
  auto simulation = charging(lone_node(""), [](ctn::Run& run) {
    if (run.number() < 3) run.charge(milliseconds{1});
  });
  const std::string told = mistake_of(*simulation, milliseconds{200});
  EXPECT_THAT(told, HasSubstr("run 3 of node work has no cost"));
  EXPECT_THAT(told, HasSubstr("Run::charge()"));
}

TEST(Charge, IsNotBelowZero) {
  auto simulation = charging(lone_node(""), [](ctn::Run& run) {
    run.charge(milliseconds{1});
    run.charge(nanoseconds{-5});
    run.charge(nanoseconds{-7});
  });
  EXPECT_THAT(mistake_of(*simulation, Nanos{0}), HasSubstr("run 1 of node work charged -5 ns"));
}

TEST(Charge, ComesTooLateWhenTheRunHasEnded) {
  auto simulation = charging(lone_node(""), [](ctn::Run& run) { run.charge(milliseconds{8}); });
  simulation->set_effect(NodeId(0), [](ctn::Run& run) { run.charge(milliseconds{1}); });
  EXPECT_THAT(mistake_of(*simulation, milliseconds{8}), HasSubstr("charged in on_effect()"));
}

TEST(Charge, IsOfAModeThatThereIs) {
  auto simulation = charging(lone_node(", modes: [skip, match]"), [](ctn::Run& run) {
    run.set_mode(2);
    run.charge(milliseconds{1});
  });
  EXPECT_THAT(mistake_of(*simulation, Nanos{0}), HasSubstr("run 1 of node work is in mode 2"));
}

// As a cost file that leaves it out says.
TEST(Charge, IsNotMissedOfAnUnscheduledNode) {
  const graph::App app = parse(R"(
catan: 1
app: two
nodes: { imu: { unscheduled: true, period: 10ms }, fuse: { fallback_rate: 10Hz } }
edges: [ imu -> fuse ]
objective: [ { response_time: [imu, fuse], weight: 1 } ]
scheduler: { bootstrap: 1s }
)");
  const std::vector<bool> given(2, false);
  for (const bool charges : {false, true}) {
    auto simulation = *Simulation::create(
        app, std::make_unique<DrawnCosts>(app, model::Workload(app.graph), 1, std::vector<double>{}, given),
        on_ideal_machine(*policy::make_policy("default")));
    simulation->set_body(NodeId(1), [](ctn::Run& run) { run.charge(milliseconds{5}); });
    if (charges) simulation->set_body(NodeId(0), [](ctn::Run& run) { run.charge(milliseconds{1}); });
    const Outcome outcome = after_ten_seconds(*simulation);
    EXPECT_DOUBLE_EQ(node(outcome, "imu").compute_ms.mean, charges ? 1.0 : 0.0);
  }
}

}  // namespace
}  // namespace ctn::sim
