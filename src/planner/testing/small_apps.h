// Apps of one and two subchains whose formulas can be written down, for tests.
#pragma once

#include <chrono>
#include <cstddef>
#include <utility>

#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "model/cost.h"
#include "model/workload.h"
#include "planner/surrogate.h"
#include "trial/samples.h"
#include "trial/schedule.h"

namespace ctn::planner {

// All runs of a node cost the same.
inline model::Workload constant_work(const graph::App& app, const model::CostTable& costs) {
  model::Workload work(app.graph);
  for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
    model::NodeWork constant;
    constant.cost = costs[NodeId(i)];
    work.set(NodeId(i), std::move(constant));
  }
  return work;
}

// Two subchains, one after the other: a feeds b.
struct Two {
  graph::App app = [] {
    graph::AppSpec spec = graph::spec_of({"a", "b", "base"}, {"a b base"});
    node(spec, "base").external = true;
    spec.objective = {graph::response("a b base", 1.0)};
    return graph::build_app(spec).value();
  }();
  model::CostTable costs = [this] {
    model::CostTable table(app.graph, Millis{1});
    table.set(NodeId(1), model::CostProfile::constant(Millis{4}));
    return table;
  }();
  trial::Samples samples{app, constant_work(app, costs), Nanos{0}, 1};
  Surrogate surrogate{app, samples, costs, 0.0};
  double a = surrogate.mean_cost(SubchainId(0), 0);
  double b = surrogate.mean_cost(SubchainId(1), 0);

  static trial::Schedule schedule() {
    using std::chrono::milliseconds;
    trial::Place first{.core = 0, .priority = 2, .period = milliseconds{10}};
    trial::Place second{.core = 0, .priority = 1, .period = milliseconds{20}};
    return {.cores = 1, .subchains = {first, second}, .frames = {}, .pipelines = {}};
  }
};

// What draws for a display, as often as that ticks.
inline graph::App drawing() {
  graph::AppSpec spec = graph::spec_of({"draw", "display"}, {"draw display"});
  node(spec, "display").external = true;
  node(spec, "display").period = graph::At<Nanos>{Nanos{8'333'333}, {}};
  for (auto rate : {&graph::NodeSpec::min_rate, &graph::NodeSpec::max_rate}) {
    node(spec, "draw").*rate = graph::At<Rate>{Rate{120.0}, {}};
  }
  spec.objective = {graph::response("draw display", 1.0)};
  return graph::build_app(spec).value();
}

}  // namespace ctn::planner
