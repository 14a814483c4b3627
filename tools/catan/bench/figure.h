// One figure of `catan bench`: what was measured, its bare baseline from the same run, and the goal.
//
// Units: as `unit` says. Thread safety: plain values and pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "base/time.h"

namespace ctn::tool {

constexpr const char* kMicros = "us";
constexpr const char* kPercent = "%";

// None: no such limit.
struct Goal {
  std::optional<double> ratio;  // of the medians, at most
  std::optional<double> p50;    // at most
  std::optional<double> p99;    // at most
};

struct Figure {
  std::string name;   // "hand-over"
  std::string where;  // circumstances: "same core"; may be empty
  std::string unit = kMicros;
  Summary measured;
  std::string baseline_is;  // empty: there is none
  Summary baseline;
  Goal goal;

  // Of the medians; none without a baseline.
  std::optional<double> ratio() const;
  // None where there is no goal, or nothing was measured.
  std::optional<bool> met() const;
};

// A figure that could not be had.
struct Skipped {
  std::string name;
  std::string why;
};

struct Figures {
  std::vector<Figure> measured;
  std::vector<Skipped> skipped;
};

Summary summarize_micros(const std::vector<Nanos>& samples);

// "<= 1.3x, p99 <= 120"; empty where there is none.
std::string goal_text(const Goal& goal);

// A table, and what the baselines are.
std::string figures_text(const std::vector<Figure>& figures);

}  // namespace ctn::tool
