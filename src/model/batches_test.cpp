#include "model/batches.h"

#include <gtest/gtest.h>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::model {
namespace {

using std::chrono::milliseconds;

// Into the queue of map: scan, each fifth of whose runs gives an output; pose, every 5 ms; frame, in the same subchain.
struct Into {
  Into() {
    graph::AppSpec spec =
        graph::spec_of({"scan", "pose", "frame", "map", "base"}, {"scan map", "pose map", "frame map base"});
    node(spec, "pose").unscheduled = true;
    node(spec, "pose").period = graph::At<Nanos>{milliseconds{5}, {}};
    node(spec, "map").input = graph::InputKind::kQueue;
    node(spec, "base").external = true;
    spec.subchains.push_back(graph::subchain("mapping", "frame map"));
    spec.objective.push_back(graph::response("scan map base", 1.0));
    app = graph::build_app(spec).value();
    costs.emplace(app.graph, Millis{1});
    costs->set_runs_per_output(*app.graph.find_node("scan"), 5.0);
  }
  std::vector<BatchInput> inputs() const { return batch_inputs(app.graph, *costs, *app.graph.find_node("map")); }

  graph::App app;
  std::optional<CostTable> costs;
};

Millis every_10(SubchainId) { return Millis{10}; }

TEST(Batches, OnAverageAreWhatComesBetweenTwoRuns) {
  EXPECT_DOUBLE_EQ(mean_items(Into().inputs(), Millis{100}, every_10), 2.0 + 20.0 + 1.0);
  EXPECT_DOUBLE_EQ(mean_items(Into().inputs(), Millis{2}, every_10), 0.04 + 0.4 + 1.0);
}

TEST(Batches, AtMostAreOneMoreOfEachAndAsIfEachRunGaveOne) {
  EXPECT_DOUBLE_EQ(max_items(Into().inputs(), Millis{100}, every_10), 11.0 + 21.0 + 1.0);
  EXPECT_DOUBLE_EQ(max_items(Into().inputs(), Millis{2}, every_10), 2.0 + 2.0 + 1.0);
}

TEST(Batches, FitIntoQueues) {
  EXPECT_DOUBLE_EQ(max_items(Into().inputs(), Millis{1e9}, every_10), 2.0 * kMaxItems + 1.0);
}

TEST(Batches, OutputsOfExternalNodesAreNoItems) {
  graph::AppSpec spec = graph::spec_of({"sensor", "log"}, {"sensor log"});
  node(spec, "sensor").external = true;
  node(spec, "log").input = graph::InputKind::kQueue;
  spec.objective.push_back(graph::response("log", 1.0));
  const graph::App app = graph::build_app(spec).value();
  EXPECT_TRUE(batch_inputs(app.graph, CostTable(app.graph, Millis{1}), *app.graph.find_node("log")).empty());
}

}  // namespace
}  // namespace ctn::model
