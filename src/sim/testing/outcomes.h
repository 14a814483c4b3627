// For tests: simulations on a machine where scheduling costs nothing, and what came of them.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>

#include "config/testing/apps.h"
#include "sim/simulation.h"

namespace ctn::sim {

inline Options on_ideal_machine(std::shared_ptr<const policy::Policy> policy, int cores = 1) {
  Options options{.policy = std::move(policy)};
  options.machine.cores = cores;
  options.machine.costs = MachineCosts::none();
  return options;
}

// Of a machine where scheduling costs nothing, unless it is not `ideal`.
inline std::unique_ptr<Simulation> simulation_of(const graph::App& app, const std::string& costs,
                                                 const std::string& policy, int cores = 1, std::uint64_t seed = 1,
                                                 bool ideal = true) {
  Options options = on_ideal_machine(*policy::make_policy(policy), cores);
  if (!ideal) options.machine.costs = {};
  auto made = Simulation::create(app, std::make_unique<DrawnCosts>(app, parse_costs(app, costs), seed), options);
  if (!made) {
    ADD_FAILURE() << made.error().message();
    std::abort();
  }
  return std::move(*made);
}

// 20 s, once all is measured.
inline Outcome simulate(const graph::App& app, const std::string& costs, const std::string& policy, int cores = 1) {
  auto simulation = simulation_of(app, costs, policy, cores);
  simulation->run_for(simulation->warm_from() - TimePoint{} + std::chrono::seconds{20});
  return simulation->outcome();
}

inline const NodeOutcome& node(const Outcome& outcome, const std::string& name) {
  for (const NodeOutcome& each : outcome.nodes) {
    if (each.name == name) return each;
  }
  ADD_FAILURE() << name;
  std::abort();
}

// camera 2, detect 10, motor 1: one subchain, one after the other on one core.
constexpr const char* kRow = R"(
catan: 1
app: row
nodes: { camera: { fallback_rate: 50Hz }, detect: {}, motor: {} }
edges: [ camera -> detect -> motor ]
subchains: { row: [camera, detect, motor] }
objective: [ { response_time: [camera, detect, motor], weight: 1, max: 30ms } ]
scheduler: { slack: 0%, bootstrap: 1s }
)";
constexpr const char* kRowCosts = "camera: 2ms\ndetect: 10ms\nmotor: 1ms\n";

}  // namespace ctn::sim
