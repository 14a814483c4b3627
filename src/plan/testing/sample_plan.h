// An app with one of each kind, and a valid plan for it, put together by hand; for tests.
//
//   core 0, shared   fast (scan, steer; at most 100 Hz)   f = 1, slice 6 ms
//                    slow (map)                           f = 1/4, slice 5 ms
//                    batch (log, a queue node)            f = 1.5, slice 6 ms; a run may be left over to the next frame
//                    2 ms idle, 5 % slack: frames of (6 + 5 + 6 + 2) / 0.95 = 20 ms
//   cores 1 and 2    see (grab, detect), 10 ms each: p = 10 / 0.95 ms, L = 20 ms; its bound of 25 ms is relaxed
#pragma once

#include <string>
#include <vector>

#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "model/cost.h"
#include "plan/plan.h"
#include "plan/predict.h"
#include "plan/promise.h"

namespace ctn::plan {

constexpr int kSampleCores = 3;
constexpr SubchainId kFast{0};
constexpr SubchainId kSlow{1};
constexpr SubchainId kSee{2};
constexpr SubchainId kBatch{3};

inline graph::AppSpec sample_spec() {
  graph::AppSpec spec = graph::spec_of({"scan", "steer", "map", "log", "grab", "detect", "base"},
                                       {"scan steer base", "scan map steer", "map log", "grab detect base"});
  node(spec, "base").external = true;
  node(spec, "log").input = graph::InputKind::kQueue;
  node(spec, "steer").max_rate = graph::At<Rate>{Rate{100.0}, {}};
  node(spec, "map").min_rate = graph::At<Rate>{Rate{10.0}, {}};
  spec.subchains = {graph::subchain("fast", "scan steer"), graph::subchain("slow", "map"),
                    graph::subchain("see", "grab detect")};
  spec.objective = {graph::response("scan steer base", 1.0), graph::response("grab detect base", 0.5),
                    graph::period("log", 0.25), graph::response("map steer", 0.1)};
  spec.objective[1].max = graph::At<Nanos>{std::chrono::milliseconds{25}, {}};
  spec.order = graph::split("fast slow log see");
  return spec;
}

inline graph::App sample_app() { return graph::build_app(sample_spec()).value(); }

inline model::CostTable sample_costs(const graph::App& app) {
  model::CostTable costs(app.graph, Millis{10});
  const auto set = [&](const char* name, double cost) {
    costs.set(*app.graph.find_node(name), model::CostProfile::constant(Millis{cost}));
  };
  set("scan", 2);
  set("steer", 4);
  set("map", 20);
  set("log", 4);
  return costs;
}

inline Plan sample_plan(const graph::App& app, const model::CostTable& costs) {
  Plan plan;
  plan.planner = "by hand";
  plan.quality = Quality::kFeasible;
  plan.gap = 0.125;
  plan.slack = 0.05;
  const Millis frame = Millis{6 + 5 + 6 + 2} / 0.95;
  plan.subchains = {{{0}, frame, frame, 1, 1.0, Millis{6}, 1},
                    {{0}, 4 * frame, 4 * frame, 4, 0.25, Millis{5}, 1},
                    {{1, 2}, Millis{10} / 0.95, Millis{20}, 1, 1.0, Millis{20}, 1},
                    {{0}, frame / 1.5, frame + Millis{4 - 6}, {}, 1.5, Millis{6}, 1}};
  plan.cores.resize(kSampleCores);
  CorePlan& shared = plan.cores[0];
  shared.frame = frame;
  shared.frame_min = Millis{10};
  shared.slots = {
      {kFast, Millis{0}, Millis{6}, 1, 0}, {kSlow, Millis{6}, Millis{5}, 4, 3}, {kBatch, Millis{11}, Millis{6}, {}, 0}};
  shared.idle = Millis{2};
  fill_predictions(plan, app, costs);
  return plan;
}

// The same app with fixed priorities on core 0, and slack of 0 so that sums are whole:
//   fast   every 20 ms                                R = 6 ms
//   slow   with each second output of `fast`          R = 20 + 2 x 6 = 32 ms
//   batch  10 ms after its own end                    R = 4 + what both take
inline Plan sample_priorities(const graph::App& app, const model::CostTable& costs) {
  Plan plan = sample_plan(app, costs);
  plan.slack = 0.0;
  plan.cores[0] = {};
  plan.cores[0].form = Form::kPriorities;
  plan.cores[0].members = {{kFast, 3, Millis{20}, Millis{5}, {}, {}, {}, Millis{6}},
                           {kSlow, 2, Millis{0}, Millis{0}, {}, {}, After{kFast, 2}, Millis{25}},
                           {kBatch, 1, Millis{15}, Millis{0}, {}, Millis{10}, {}, Millis{4}}};
  const std::vector<Promise> promises = promise(plan, app, costs).value();
  for (const SubchainId id : {kFast, kSlow, kBatch}) {
    SubchainPlan& subchain = plan.subchains[id.index()];
    const Millis cost = costs.subchain_total(app.graph, id);
    subchain = {{0}, promises[id.index()].period, promises[id.index()].execution, subchain.every, 1.0, cost, 1};
    if (subchain.every) subchain.every = 1;
  }
  plan.subchains[kSee.index()].period = Millis{10};
  fill_predictions(plan, app, costs);
  return plan;
}

}  // namespace ctn::plan
