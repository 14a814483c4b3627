// Queues, batches and nodes that give an output less often than they run, in virtual time, worked by hand.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "config/testing/apps.h"
#include "policy/measured_costs.h"
#include "record/reader.h"
#include "sim/simulation.h"
#include "sim/testing/outcomes.h"

namespace ctn::sim {
namespace {

using std::chrono::seconds;

// Ten runs of fast for each of slow.
graph::App batches_of_ten() {
  return parse(R"(
catan: 1
app: batch
nodes: { fast: { fallback_rate: 100Hz }, slow: { input: queue, fallback_rate: 10Hz } }
edges: [ fast -> slow ]
objective: [ { response_time: [fast, slow], weight: 1 } ]
scheduler: { bootstrap: 1s }
)");
}

TEST(SimulatedOutputs, QueueNodesTakeAllSinceTheirLastRun) {
  const Outcome outcome = simulate(batches_of_ten(), "fast: 1ms\nslow: 2ms\n", "fifo", 2);
  // Every run of fast reaches the end, the oldest of a batch of ten after about a period of slow.
  EXPECT_NEAR(static_cast<double>(outcome.chains.front().latency_ms.count), 2000.0, 15.0);
  EXPECT_NEAR(outcome.chains.front().latency_ms.max, 102.0, 1.1);
  EXPECT_EQ(outcome.dropped, 0U);
}

// A run of slow takes 2 ms, and 0.5 ms for each item.
TEST(SimulatedOutputs, ItemsOfABatchAddToARun) {
  const Outcome outcome = simulate(batches_of_ten(), "fast: 1ms\nslow: { cost: 2ms, per_item: 0.5ms }\n", "fifo", 2);
  EXPECT_NEAR(node(outcome, "slow").compute_ms.mean, 7.0, 0.01);
}

// It is not told what an item adds: both parts of what a batch costs are found, and what is expected of plans happens.
TEST(SimulatedOutputs, WhatItemsAddIsMeasuredAndPlannedWith) {
  const graph::App app = parse(R"(
catan: 1
app: batches
nodes: { scan: {}, steer: {}, map: { input: queue } }
edges: [ scan -> steer, scan -> map ]
objective:
  - { response_time: [scan, steer], weight: 1 }
  - { response_time: [scan, map], weight: 0.1 }
scheduler: { bootstrap: 1s }
)");
  const std::string path = testing::TempDir() + fmt::format("batches_{}.catan", getpid());
  std::remove(path.c_str());
  Options options{.policy = *policy::make_policy("catan")};
  options.recording = {.path = path, .note = ""};
  const std::string text = "scan: 1ms\nsteer: { cost: 2ms, typical: 1.6ms }\nmap: { cost: 1ms, per_item: 0.5ms }\n";
  auto simulation =
      *Simulation::create(app, std::make_unique<DrawnCosts>(app, parse_costs(app, text), 1), std::move(options));
  simulation->run_for(simulation->warm_from() - TimePoint{} + seconds{60});
  const NodeId map = *app.graph.find_node("map");
  const plan::Plan plan = *simulation->plan();
  ASSERT_EQ(plan.batches.size(), 1U) << "it is known that items add something";
  EXPECT_EQ(plan.batches.front().node, map);
  const Outcome outcome = simulation->outcome();
  for (const ChainOutcome& chain : outcome.chains) {
    EXPECT_NEAR(chain.response_ms.mean, *chain.predicted_ms, 0.03 * chain.response_ms.mean) << chain.path;
  }
  EXPECT_NEAR(*outcome.objective, *outcome.objective_predicted, 0.03 * *outcome.objective);
  EXPECT_LE(outcome.plans_adopted, 15U);
  ASSERT_TRUE(simulation->finish().ok());

  policy::MeasuredCosts measured(app);
  const auto record = record::Reader::open(path);
  ASSERT_TRUE(record.ok()) << record.error().message();
  std::uint64_t changes = 0;
  EXPECT_TRUE(record->each_run([&](const record::Run& run) { changes += measured.add(run, 0) ? 1U : 0U; }).ok());
  const model::CostProfile found = measured.typical_costs(Millis{1})[map];
  EXPECT_NEAR(found.per_item().count(), 0.5, 0.015);
  EXPECT_NEAR(found.single_thread().count(), 1.0, 0.05) << "the machine's part included";
  EXPECT_EQ(changes, 0U) << "larger batches are no change of what runs cost";
  std::remove(path.c_str());
}

// Ten runs of fast for each of slow, of which every tenth finds something.
TEST(SimulatedOutputs, ThePeriodOfAQueueNodeIsOfRunsThatHadAnInput) {
  const graph::App app = parse(R"(
catan: 1
app: mostly_empty
nodes: { slow: { fallback_rate: 10Hz }, fast: { input: queue, fallback_rate: 100Hz } }
edges: [ slow -> fast ]
objective: [ { response_time: [slow, fast], weight: 1 }, { period: fast, weight: 1 } ]
scheduler: { bootstrap: 1s }
)");
  const Outcome outcome = simulate(app, "slow: 1ms\nfast: 2ms\n", "fifo", 2);
  EXPECT_NEAR(node(outcome, "fast").rate_hz, 100.0, 0.1);
  EXPECT_NEAR(node(outcome, "fast").period_ms.mean, 100.0, 1e-6);
  EXPECT_NEAR(*outcome.objective, outcome.chains.front().response_ms.mean + 100.0, 1e-6);
}

TEST(SimulatedOutputs, OutputLessOftenThanRuns) {
  std::string text = kRow;
  text.replace(text.find("detect: {}"), 10, "detect: { output_period: 100ms }");
  const Outcome outcome = simulate(parse(text), kRowCosts, "default");
  EXPECT_NEAR(node(outcome, "detect").rate_hz, 50.0, 0.06);
  EXPECT_NEAR(node(outcome, "motor").rate_hz, 10.0, 0.06);
}

// As in a session: `output_period` is what plans go by, and stands in for code where there is none.
TEST(SimulatedOutputs, AFunctionDecidesWhichRunsGiveAnOutput) {
  std::string text = kRow;
  text.replace(text.find("detect: {}"), 10, "detect: { output_period: 100ms }");
  const graph::App app = parse(text);
  const auto rate_of_motor = [&](const Body& detect) {
    auto simulation = simulation_of(app, kRowCosts, "default");
    simulation->set_body(*app.graph.find_node("detect"), detect);
    simulation->run_for(simulation->warm_from() - TimePoint{} + seconds{20});
    return node(simulation->outcome(), "motor").rate_hz;
  };
  EXPECT_NEAR(rate_of_motor([](ctn::Run&) {}), 50.0, 0.06);
  EXPECT_NEAR(rate_of_motor([](ctn::Run& run) {
                if (run.number() % 2 != 0) run.skip_output();
              }),
              25.0, 0.06);
}

// It is not told that detect gives an output in every fourth run: plans learn it, and expect what happens.
TEST(SimulatedOutputs, OutputsOfOnlySomeRunsAreMeasuredAndPlannedWith) {
  for (const char* policy : {"catan", "paper"}) {
    const graph::App app = parse(kRow);
    auto simulation = simulation_of(app, kRowCosts, policy);
    simulation->set_effect(*app.graph.find_node("detect"), [](ctn::Run& run) {
      if (run.number() % 4 != 0) run.skip_output();
    });
    simulation->run_for(simulation->warm_from() - TimePoint{} + seconds{60});
    const plan::Plan& plan = *simulation->plan();
    EXPECT_EQ(plan.outputs, (std::vector<plan::RunsPerOutput>{{*app.graph.find_node("detect"), 4.0}})) << policy;
    EXPECT_GT(plan.relax_factor, 1.0) << policy << ": the bound of 30 ms cannot hold";
    const Outcome outcome = simulation->outcome();
    const ChainOutcome& chain = outcome.chains.front();
    EXPECT_NEAR(chain.response_ms.mean, *chain.predicted_ms, 0.1 * chain.response_ms.mean) << policy;
    EXPECT_LE(outcome.plans_adopted, 5U) << policy;
  }
}

}  // namespace
}  // namespace ctn::sim
