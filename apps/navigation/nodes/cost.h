// The cost of a run in virtual time: the units of its work, times the time that a unit took where it was measured
// (navigation_nodes_bench; docs/navigation.md).
//
// Units: seconds. Thread safety: no state.
#pragma once

#include "work.h"

namespace ctn::navigation {

// Work in units that take about equally long within a node. An expanded entry of a search counts for many, since it
// takes heap operations and a look at eight neighbours.
inline double units(const Work& work) {
  constexpr double kExpanded = 64.0;
  return static_cast<double>(work.beams) + static_cast<double>(work.cells) + static_cast<double>(work.candidates) +
         kExpanded * static_cast<double>(work.expanded);
}

// `nanoseconds`: the time that a unit of this node takes. `slowdown`: how many times as long the board takes. `min`:
// the cost, in seconds, of a run that has nothing to do but to take its inputs.
inline double cost(const Work& work, double nanoseconds, double slowdown, double min = 10e-6) {
  return slowdown * (min + units(work) * nanoseconds * 1e-9);
}

}  // namespace ctn::navigation
