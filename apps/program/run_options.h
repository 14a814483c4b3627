// What sessions and simulations are opened with, by the options of an app that has schedulers to compare and note_of().
//
// Thread safety: pure functions.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "catan/session.h"
#include "catan/simulation.h"

namespace ctn::program {

// `on_notice`: as SessionOptions'; empty: nobody is told.
template <class Options>
SessionOptions session_options(const Options& options, std::function<void(const std::string&)> on_notice) {
  SessionOptions result;
  result.policy = options.policy;
  result.cpus = options.cpus;
  result.record = options.record;
  result.note = note_of(options);
  result.stealing = options.stealing;
  result.on_notice = std::move(on_notice);
  return result;
}

// Each run charges what it costs, which is multiplied by the machine's ratio where the options have one.
template <class Options>
SimulationOptions simulation_options(const Options& options) {
  SimulationOptions result;
  result.slowdown = options.slowdown;
  result.slowdowns = options.calibration.of(options.seed);
  result.policy = options.policy;
  result.cores = options.cores;
  result.seed = options.seed;
  result.stealing = options.stealing;
  result.record = options.record;
  result.note = note_of(options);
  return result;
}

}  // namespace ctn::program
