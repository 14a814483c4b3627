// Policies against one another in the simulator: each schedules the same app on the same cores, with the same seeds of
// its load, so that what differs is what they do.
//
// A contender is a policy by its name (api/policies.h), or "plan:auto[:EFFORT][:no-FEATURE]...": the plan of
// `catan plan --planner auto`, made before from other draws of the load than it is then measured by, and never revised.
// Features that can be left out, to see what each is worth: priorities (frames everywhere), elastic (fixed frames),
// stealing, phases (triggers by time are at phase 0), outputs (no subchain is triggered by another's, unless the app
// says so).
//
// The seed also draws when unscheduled nodes begin: on real machines that is chance, and lasts.
//
// Units: milliseconds, as the names say. Thread safety: pure functions, but for files that a name mentions.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "cases.h"

namespace ctn::bench {

// What a figure is where no sample has reached its end, or the contender refused.
constexpr double kNotReached = std::numeric_limits<double>::infinity();

struct Match {
  int cores = 1;
  std::vector<std::uint64_t> seeds;  // not empty
  Nanos measured{0};                 // of virtual time, after the warm-up
};

struct Score {
  // By seed.
  std::vector<double> objective_ms;
  std::vector<double> p95_ms;  // of the response time of the chain that weighs most, of equals the first
  std::string refused;         // why; then all figures are kNotReached. Empty: it did not

  double mean_objective() const;
  double mean_p95() const;
};

// kCaller: `contender` is no name of a policy of this app's.
Status check_contender(const std::string& contender, const graph::App& app);

// Errors of the contender are in the score.
Score play(const std::string& contender, const Case& of, const Match& match);

// --- What scores come to

// The judged one's figure to the lowest of the others. Where neither has one it is 1, where only the judged one has it
// is 0, where only others have it is infinite.
double ratio_to_best(double judged, const std::vector<double>& others);

struct Ratios {
  std::size_t count = 0;
  std::size_t infinite = 0;
  double geometric_mean = 1.0;    // of those that are neither 0 nor infinite
  double within_a_percent = 0.0;  // the part that is at most 1.01
  double first = 0.0;             // the part that is at most 1
};
Ratios summary_of(const std::vector<double>& ratios);

}  // namespace ctn::bench
