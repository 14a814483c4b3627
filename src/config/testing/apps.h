// Apps and compute times for tests.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <utility>

#include "config/app_file.h"
#include "config/cost_file.h"
#include "graph/app.h"

namespace ctn {

inline graph::App parse(const std::string& text) {
  Result<graph::App> app = config::parse_app(text, "test.yaml");
  if (!app) {
    ADD_FAILURE() << app.error().message();
    std::abort();
  }
  return std::move(*app);
}

// As the app file's `schedule: frames` makes it.
inline graph::App in_frames(graph::App app) {
  app.scheduler.schedule = graph::ScheduleKind::kFrames;
  return app;
}

// A cost file's text.
inline model::Workload parse_costs(const graph::App& app, const std::string& text) {
  Result<model::Workload> work = config::parse_workload(text, "test.costs.yaml", app);
  if (!work) {
    ADD_FAILURE() << work.error().message();
    std::abort();
  }
  return std::move(*work);
}

inline graph::App one_node_app() {
  return parse("catan: 1\napp: one\nnodes: { node: {} }\nedges: []\nobjective: [ { period: node, weight: 1 } ]\n");
}

// Two loops that know nothing of each other. A long `replan`, so that what is planned soon is planned for a reason.
inline graph::App two_loops_app() {
  return parse(R"(
catan: 1
app: loops
nodes: { fast: { max_rate: 100Hz }, slow: { max_rate: 20Hz } }
objective:
  - { response_time: [fast], weight: 1 }
  - { response_time: [slow], weight: 0.1 }
scheduler: { bootstrap: 1s, replan: 1000s }
)");
}

// One subchain of four nodes, as the face tracker's.
inline graph::App tracker_app() {
  return parse(R"(
catan: 1
app: tracker
nodes: { camera: { fallback_rate: 30Hz }, detect: {}, plan: {}, motor: {} }
edges: [ camera -> detect -> plan -> motor ]
subchains: { track: [camera, detect, plan, motor] }
objective: [ { response_time: [camera, detect, plan, motor], weight: 1 } ]
)");
}

// A fast loop, a slow one that feeds it, and a node that takes batches. `of_scan`, `of_map`: more keys of these nodes,
// each with a comma before it.
inline graph::App robot_app(const std::string& of_scan = "", const std::string& of_map = "") {
  return parse(R"(
catan: 1
app: robot
nodes:
  scan: { fallback_rate: 50Hz)" +
               of_scan + R"( }
  steer: {}
  map: { fallback_rate: 5Hz)" +
               of_map + R"( }
  log: { input: queue, fallback_rate: 20Hz }
edges: [ scan -> steer, scan -> map -> steer, scan -> log ]
subchains: { fast: [scan, steer] }
objective:
  - { response_time: [scan, steer], weight: 1 }
  - { response_time: [map, steer], weight: 0.05 }
  - { period: log, weight: 0.05 }
scheduler: { bootstrap: 1s }
)");
}

// Two nodes that share a core, the one twice as often as the other. Without slack, so that figures are round.
inline graph::App two_rates_app() {
  return parse(R"(
catan: 1
app: two
nodes: { a: { fallback_rate: 100Hz }, b: { fallback_rate: 50Hz } }
edges: [ a -> b ]
objective:
  - { response_time: [a], weight: 1 }
  - { response_time: [b], weight: 0.1 }
scheduler: { slack: 0%, bootstrap: 1s }
)");
}

// One subchain of four nodes, of which three have rates of their own.
inline graph::App own_rates_app() {
  return parse(R"(
catan: 1
app: own_rates
nodes: { scan: { fallback_rate: 20Hz }, LM: { fallback_rate: 5Hz }, LP: { fallback_rate: 10Hz }, push: {} }
edges: [ scan -> LM -> LP -> push ]
subchains: { local: [scan, LM, LP, push] }
objective: [ { response_time: [scan, LM, LP, push], weight: 1 } ]
scheduler: { slack: 0%, bootstrap: 1s }
)");
}
constexpr const char* kOwnRatesCosts = "scan: 2ms\nLM: 4ms\nLP: 3ms\npush: 1ms\n";

}  // namespace ctn
