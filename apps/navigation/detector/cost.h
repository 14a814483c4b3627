// The cost of a run of the detector chain in virtual time: each kind of its work, times the time that one of it took
// where it was measured (detector_bench; docs/navigation-detector.md).
//
// Units: seconds. Thread safety: no state.
#pragma once

#include "detector/work.h"

namespace ctn::navigation {

// Nanoseconds for one of each.
struct PictureCosts {
  double decoded = 3.1;
  double taps = 0.63;
  double moved = 3.4;
  double gradients = 12.0;
  double windows = 1000.0;
  double multiply_adds = 0.0155;
  double emitted = 1.05;
};

// `slowdown`: how many times as long the board takes.
inline double cost(const PictureWork& work, double slowdown, const PictureCosts& costs = {}) {
  const double nanoseconds =
      costs.decoded * static_cast<double>(work.decoded) + costs.taps * static_cast<double>(work.taps) +
      costs.moved * static_cast<double>(work.moved) + costs.gradients * static_cast<double>(work.gradients) +
      costs.windows * static_cast<double>(work.windows) +
      costs.multiply_adds * static_cast<double>(work.multiply_adds) + costs.emitted * static_cast<double>(work.emitted);
  return slowdown * nanoseconds * 1e-9;
}

}  // namespace ctn::navigation
