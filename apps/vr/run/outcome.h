// What one run of the program measured, and how it is printed.
//
// Thread safety: values, pure functions.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "catan/snapshot.h"
#include "program/figures.h"
#include "program/thread_use.h"
#include "run/clock.h"
#include "run/options.h"

namespace ctn::vr::run {

struct Outcome {
  Options options;
  std::vector<program::Figure> figures;
  Snapshot snapshot;
  program::CostRatios cost_ratios;  // of a run in life
  double took_seconds = 0.0;        // of real time; not in what is printed, which is the same each time
  std::optional<program::ThreadUse> display_thread;
  int signal = 0;  // that ended it early; 0: none
};

// Adds what follows from response times: those of the chains, with their floors where the clocks are known.
struct Clocks {
  Clock samples;
  Clock display;
  std::optional<Clock> exposures{};  // of a camera with a rate of its own
};
// `tracking`: what it took for the pictures (costs_of_tracking()); without any the camera's chain has no floor.
void add_responses(Outcome& outcome, const Clocks& clocks, const std::vector<std::chrono::nanoseconds>& tracking);

// JSON of the options that a run's outcome depends on.
std::string identity_of(const Options& options);
// The document that says what of that all runs of a batch have in common.
std::string common_of(const Options& options);

std::string to_json(const Outcome& outcome);
std::string to_text(const Outcome& outcome);

}  // namespace ctn::vr::run
