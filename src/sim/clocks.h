// Clocks that are not Catan's: those of external nodes that tick, and the timers of unscheduled nodes, as far as they
// are chance. All of it follows from a seed, and does not change while a simulation runs.
//
// Units: in the types. Thread safety: plain values and a pure function.
#pragma once

#include <cstdint>
#include <vector>

#include "base/ticks.h"
#include "graph/app.h"

namespace ctn::sim {

// How they are drawn.
struct ClockChance {
  std::uint64_t seed = 1;
  // In parts of a million: each clock is up to so much fast or slow, and unscheduled nodes begin at any phase. 0: all
  // clocks go at one rate, and unscheduled nodes begin a period after the start.
  double drift_ppm = 0.0;
};

// By NodeId.
struct Clocks {
  std::vector<Ticks> external;  // without a period where there is no clock
  std::vector<Ticks> timers;    // of unscheduled nodes: the first run, and how often; else without a period
};

Clocks draw_clocks(const graph::Graph& graph, const ClockChance& chance);

}  // namespace ctn::sim
