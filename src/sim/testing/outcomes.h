// For tests: simulations on a machine where scheduling costs nothing, and what came of them.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "sim/simulation.h"

namespace ctn::sim {

inline Options on_ideal_machine(std::shared_ptr<const policy::Policy> policy, int cores = 1) {
  Options options{.policy = std::move(policy)};
  options.machine.cores = cores;
  options.machine.costs = MachineCosts::none();
  return options;
}

inline const NodeOutcome& node(const Outcome& outcome, const std::string& name) {
  for (const NodeOutcome& each : outcome.nodes) {
    if (each.name == name) return each;
  }
  ADD_FAILURE() << name;
  std::abort();
}

}  // namespace ctn::sim
