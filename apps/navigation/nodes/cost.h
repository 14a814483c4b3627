// What a run costs in virtual time: its work, counted, times what a unit of it took where it was measured
// (navigation_nodes_bench; docs/navigation.md).
//
// Units: seconds. Thread safety: no state.
#pragma once

#include "types.h"

namespace ctn::navigation {

// In units that take about as long as one another within a node: an entry of a search takes a heap and eight
// neighbours.
inline double units(const Work& work) {
  constexpr double kExpanded = 64.0;
  return static_cast<double>(work.beams) + static_cast<double>(work.cells) + static_cast<double>(work.candidates) +
         kExpanded * static_cast<double>(work.expanded);
}

// `nanoseconds`: what a unit takes, by node. `slowdown`: how many times as long the board takes. `least`: what a run
// costs that has nothing to do, to be called and to take its inputs.
inline double cost(const Work& work, double nanoseconds, double slowdown, double least = 10e-6) {
  return slowdown * (least + units(work) * nanoseconds * 1e-9);
}

}  // namespace ctn::navigation
