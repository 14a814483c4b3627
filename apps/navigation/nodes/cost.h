// What a run of a node costs in virtual time: its counted work, times what a unit of it took where that was measured.
//
// So growth of the map, loop closures and modes come out of the work, and a run costs the same wherever it is
// simulated. docs/navigation.md says how well the factors fit, and how to measure them anew (navigation_nodes_bench).
//
// Units: seconds; factors in nanoseconds. Thread safety: no state.
#pragma once

#include <array>
#include <cstddef>

#include "work.h"

namespace ctn::navigation {

enum class Node {
  kScanFilter,
  kLocalMapper,
  kLocalPlanner,
  kGlobalLocalizer,
  kGlobalMapper,
  kGlobalPlanner,
  kNavigationCommand,
};
inline constexpr std::array<const char*, 7> kNodeNames{"scan", "LM", "LP", "GL", "GM", "GP", "NC"};  // in the app file

// Of a unit of each kind of work, and of a run that has nothing to do but to take its inputs.
struct CostFactors {
  double run = 0.0;
  double beam = 0.0;
  double cell = 0.0;
  double candidate = 0.0;
  double expanded = 0.0;
  double pose = 0.0;
};

// Measured with `navigation_nodes_bench` (map 2, seed 1, a drive of 500 s).
inline constexpr std::array<CostFactors, 7> kCostFactors{{
    {.run = 46'710},
    {.cell = 4.495},
    {.run = 35'914, .candidate = 5.721, .pose = 34.54},
    {.beam = 12.25, .cell = 0.532, .candidate = 0.837, .expanded = 220.4},
    {.run = 491'663, .beam = 168.9, .cell = 0.858},
    {.run = 136'163, .cell = 1.850, .expanded = 171.9},
    {.run = 2'030, .candidate = 13.14},
}};

inline double cost(const CostFactors& factors, const Work& work) {
  return 1e-9 *
         (factors.run + factors.beam * static_cast<double>(work.beams) +
          factors.cell * static_cast<double>(work.cells) + factors.candidate * static_cast<double>(work.candidates) +
          factors.expanded * static_cast<double>(work.expanded) + factors.pose * static_cast<double>(work.poses));
}

// Times a board's slowdown, if it is slower than where the factors were measured.
inline double cost(Node node, const Work& work) { return cost(kCostFactors[static_cast<std::size_t>(node)], work); }

}  // namespace ctn::navigation
