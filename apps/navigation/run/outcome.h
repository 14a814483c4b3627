// What one run of the program measured, and how it is printed.
//
// Thread safety: values, pure functions.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "catan/snapshot.h"
#include "program/figures.h"
#include "program/thread_use.h"
#include "run/drive.h"
#include "run/options.h"
#include "world/world_file.h"

namespace ctn::navigation::run {

struct Outcome {
  Options options;
  std::string world;  // its name
  bool explores = false;
  std::optional<double> shortest_way;  // to the goal, metres
  Findings findings;
  Snapshot snapshot;
  program::CostRatios cost_ratios;  // of a run in life
  ByTime objective_by_time;         // objective.h
  double took_seconds = 0.0;        // of real time; not in what is printed, which is the same each time
  std::optional<program::ThreadUse> world_thread;
  int signal = 0;  // that ended it early; 0: none
};

// Of a run that has not begun.
Outcome outcome_of_run(const Options& options, const world::WorldFile& world);

inline constexpr std::chrono::nanoseconds kStalenessBucket = std::chrono::seconds(5);
inline constexpr std::chrono::nanoseconds kDetectorBucket = std::chrono::seconds(10);

using program::Figure;
// What a drive came to, by what the world knows of it, without reactions. `shortest_way`: to the goal, metres.
std::vector<Figure> drive_figures(const Findings& found, bool explores, const std::optional<double>& shortest_way);
// In the order in which they are printed. What batches compute medians of.
std::vector<Figure> figures_of(const Outcome& outcome);

// Text: a figure by time, in rows of ten, each with the time at which it begins.
std::string rows_of(const std::string& name, const ByTime& values, std::chrono::nanoseconds width);

// JSON of the options that a run's outcome depends on.
std::string identity_of(const Options& options);
// The document that says what of that all runs of a batch have in common.
std::string common_of(const Options& options);

std::string to_json(const Outcome& outcome);
std::string to_text(const Outcome& outcome);

// One line for a terminal while it runs.
std::string status_line(const Progress& progress);

}  // namespace ctn::navigation::run
