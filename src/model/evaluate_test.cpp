#include "model/evaluate.h"

#include <gtest/gtest.h>

#include <vector>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::model {
namespace {

// imu (unscheduled, 5 ms) -> {a, b} -> motor (external); camera -> vio is a subchain of two; vio -> a.
graph::App headset() {
  graph::AppSpec spec = graph::spec_of({"imu", "camera", "vio", "a", "b", "motor"}, {"imu a b motor", "camera vio a"});
  node(spec, "imu").unscheduled = true;
  node(spec, "imu").period = graph::At<Nanos>{std::chrono::milliseconds{5}, {}};
  node(spec, "vio").output_period = graph::At<Nanos>{std::chrono::milliseconds{100}, {}};
  node(spec, "motor").external = true;
  spec.subchains = {graph::subchain("slow", "camera vio"), graph::subchain("fast", "a b")};
  spec.objective.push_back(graph::response("imu a b motor", 1.0));
  return graph::build_app(spec).value();
}

std::vector<NodeId> path(const graph::App& app, const std::string& names) {
  std::vector<NodeId> nodes;
  for (const graph::Name& name : graph::split(names)) nodes.push_back(*app.graph.find_node(name.value));
  return nodes;
}

class Evaluate : public testing::Test {
 protected:
  const graph::App app_ = headset();
  const CostTable costs_{app_.graph, Millis{0.25}};
  const std::vector<SubchainTiming> timings_{{Millis{40}, Millis{30}}, {Millis{8}, Millis{6}}};
};

TEST_F(Evaluate, AnUnscheduledNodeHasItsOwnPeriodAndAnExternalOneNone) {
  const ChainTiming timing = evaluate_chain(app_.graph, path(app_, "imu a b motor"), costs_, timings_);
  EXPECT_EQ(timing.latency, Millis{0.25 + 8 + 6});
  EXPECT_EQ(timing.period, Millis{8});
  EXPECT_EQ(timing.response, timing.latency + timing.period);
}

// driver (unscheduled, 20 ms) sets off filter and log -> a; a chain begins at filter, or comes to it from elsewhere.
TEST(EvaluateFollowers, AnUnscheduledFollowerIsAsLateAsItsLeader) {
  graph::AppSpec spec = graph::spec_of({"driver", "filter", "a", "base"}, {"driver filter a base"});
  node(spec, "driver").unscheduled = node(spec, "filter").unscheduled = true;
  node(spec, "driver").period = graph::At<Nanos>{std::chrono::milliseconds{20}, {}};
  node(spec, "base").external = true;
  spec.objective = {graph::response("driver filter a base", 1.0), graph::response("filter a base", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  CostTable costs(app.graph, Millis{1});
  costs.set(NodeId(0), CostProfile::constant(Millis{5}));
  costs.set_wait(NodeId(0), Millis{2});
  const std::vector<SubchainTiming> timings{{Millis{10}, Millis{4}}};
  const auto of = [&](const char* names) { return evaluate_chain(app.graph, path(app, names), costs, timings); };
  EXPECT_EQ(of("driver filter a base").response, Millis{20 + 7 + 1 + 10 + 4});
  EXPECT_EQ(of("filter a base").latency, Millis{1 + 10 + 4});
  EXPECT_EQ(of("filter a base").response, Millis{20 + 7 + 1 + 10 + 4})
      << "one output is 7 ms late, the next one is not";
}

// What is done by a tick counts at the tick; what comes in does so at ticks.
TEST(EvaluateClocks, ATickIsAnElementThatCostsNothing) {
  graph::AppSpec spec = graph::spec_of({"sensor", "a", "display"}, {"sensor a display"});
  node(spec, "sensor").external = true;
  node(spec, "display").external = true;
  node(spec, "display").period = graph::At<Nanos>{std::chrono::milliseconds{16}, {}};
  spec.objective.push_back(graph::response("sensor a display", 1.0));
  const std::vector<SubchainTiming> timings{{Millis{10}, Millis{4}}};
  const graph::App ends = graph::build_app(spec).value();
  const ChainTiming timing =
      evaluate_chain(ends.graph, path(ends, "sensor a display"), CostTable(ends.graph, Millis{1}), timings);
  EXPECT_EQ(timing.latency, Millis{4 + 16});
  EXPECT_EQ(timing.period, Millis{16});

  node(spec, "sensor").period = graph::At<Nanos>{std::chrono::milliseconds{50}, {}};
  const graph::App both = graph::build_app(spec).value();
  const ChainTiming begun =
      evaluate_chain(both.graph, path(both, "sensor a display"), CostTable(both.graph, Millis{1}), timings);
  EXPECT_EQ(begun.latency, Millis{10 + 4 + 16}) << "what the sensor has sent waits for the next run";
  EXPECT_EQ(begun.period, Millis{50});
}

TEST_F(Evaluate, ANodeThatEmitsRarelySlowsTheChainDownToIt) {
  const ChainTiming timing = evaluate_chain(app_.graph, path(app_, "camera vio a b"), costs_, timings_);
  EXPECT_EQ(timing.latency, Millis{30 + 8 + 6});
  EXPECT_EQ(timing.period, Millis{100 + 40 + 30});
  EXPECT_EQ(evaluate_period(app_.graph, *app_.graph.find_node("vio"), timings_), Millis{40});
}

// Guards: what a node before it in its subchain leaves out was in no period of a chain that begins behind it.
TEST(EvaluateOutputPeriods, WhatComesBehindOneThatEmitsRarelyRunsAsRarely) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "c"}, {"a b c"});
  node(spec, "a").output_period = graph::At<Nanos>{std::chrono::milliseconds{700}, {}};
  spec.subchains = {graph::subchain("s", "a b c")};
  spec.objective.push_back(graph::response("b c", 1.0));
  const graph::App app = graph::build_app(spec).value();
  const std::vector<SubchainTiming> timings{{Millis{10}, Millis{6}}};
  EXPECT_EQ(evaluate_chain(app.graph, path(app, "b c"), CostTable(app.graph, Millis{1}), timings).period,
            Millis{10 + 700 + 6});
  EXPECT_EQ(evaluate_period(app.graph, *app.graph.find_node("a"), timings), Millis{10});
  EXPECT_EQ(evaluate_period(app.graph, *app.graph.find_node("b"), timings), Millis{700});
}

// A subchain that follows such outputs has their period; the longest time between two of them is a run longer.
TEST_F(Evaluate, AFollowerOfOneThatEmitsRarelyComesAsSeldomAndARunLater) {
  std::vector<SubchainTiming> timings = timings_;
  timings[1] = {Millis{100}, Millis{6}};
  timings[1].follows = SubchainId(0);
  const ChainTiming timing = evaluate_chain(app_.graph, path(app_, "camera vio a b"), costs_, timings);
  EXPECT_EQ(timing.latency, Millis{30 + 6});
  EXPECT_EQ(timing.period, Millis{100 + 40 + 30}) << "not 230";
}

// camera gives an output in every second run, b in every third one of its own, and vio each 100 ms.
TEST_F(Evaluate, RunsWithoutOutputSlowTheChainDown) {
  CostTable costs = costs_;
  const NodeId camera = *app_.graph.find_node("camera");
  costs.set_runs_per_output(camera, 2.0);
  EXPECT_EQ(evaluate_chain(app_.graph, path(app_, "camera"), costs, timings_).period, Millis{2 * 40});
  const ChainTiming timing = evaluate_chain(app_.graph, path(app_, "camera vio a b"), costs, timings_);
  EXPECT_EQ(timing.latency, Millis{30 + 8 + 6});
  EXPECT_EQ(timing.period, Millis{2 * 40 + 100 + 30}) << "vio runs on an output of camera";
  costs.set_runs_per_output(*app_.graph.find_node("a"), 2.0);
  costs.set_runs_per_output(*app_.graph.find_node("b"), 3.0);
  EXPECT_EQ(evaluate_chain(app_.graph, path(app_, "a b"), costs, timings_).period, Millis{2 * 3 * 8})
      << "b runs on an output of a";
  EXPECT_EQ(evaluate_period(app_.graph, camera, timings_), Millis{40});
}

TEST_F(Evaluate, AnUnscheduledNodeMayGiveFewerOutputsThanItRuns) {
  CostTable costs = costs_;
  costs.set_runs_per_output(*app_.graph.find_node("imu"), 4.0);
  const ChainTiming timing = evaluate_chain(app_.graph, path(app_, "imu a b motor"), costs, timings_);
  EXPECT_EQ(timing.latency, Millis{0.25 + 8 + 6});
  EXPECT_EQ(timing.period, Millis{4 * 5});
}

// fast is triggered by every fifth run of slow, which itself waits for what imu gives; behind that, what slow leaves
// out is not in the longest period alone.
TEST_F(Evaluate, AFollowerBehindOneThatIsNoneWaitsForTheOutputsThatItLeavesOut) {
  std::vector<SubchainTiming> timings{{Millis{5}, Millis{3}}, {Millis{25}, Millis{6}}};
  timings[1].follows = SubchainId(0);
  EXPECT_EQ(evaluate_chain(app_.graph, path(app_, "camera vio a b"), costs_, timings).latency, Millis{3 + 6});
  graph::AppSpec spec = graph::spec_of({"imu", "camera", "a"}, {"imu camera a"});
  node(spec, "imu").unscheduled = true;
  node(spec, "imu").period = graph::At<Nanos>{std::chrono::milliseconds{5}, {}};
  spec.objective.push_back(graph::response("imu camera a", 1.0));
  const graph::App behind = graph::build_app(spec).value();
  const CostTable costs(behind.graph, Millis{0.25});
  EXPECT_EQ(evaluate_chain(behind.graph, path(behind, "imu camera a"), costs, timings).latency,
            Millis{0.25 + 5 + 3 + (25 - 5) + 6});
}

// Where its triggers may come later than its period says, an input waits for them, and so does what the first one
// senses.
TEST_F(Evaluate, TheLongestGapIsWaitedFor) {
  std::vector<SubchainTiming> timings = timings_;
  timings[1].longest_gap = Millis{11};
  const ChainTiming second = evaluate_chain(app_.graph, path(app_, "camera vio a b"), costs_, timings);
  EXPECT_EQ(second.latency, Millis{30 + 11 + 6});
  EXPECT_EQ(second.period, Millis{100 + 40 + 30});
  const ChainTiming first = evaluate_chain(app_.graph, path(app_, "a b"), costs_, timings);
  EXPECT_EQ(first.latency, Millis{6});
  EXPECT_EQ(first.period, Millis{11});
}

TEST_F(Evaluate, PassingPartOfASubchainCountsAllOfIt) {
  const ChainTiming part = evaluate_chain(app_.graph, path(app_, "imu a"), costs_, timings_);
  const ChainTiming whole = evaluate_chain(app_.graph, path(app_, "imu a b"), costs_, timings_);
  EXPECT_EQ(part.response, whole.response);
}

}  // namespace
}  // namespace ctn::model
