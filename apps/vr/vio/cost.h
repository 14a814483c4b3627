// What a run of a node costs in virtual time: its counted work, times what a unit of it took where that was measured.
//
// So the number of features, turns that bring new ones into the picture, and updates with many of them come out of the
// work, and a run costs the same wherever it is simulated. docs/vr-vio.md says how well the factors fit, and how to
// measure them anew (vio_bench).
//
// Units: seconds; factors in nanoseconds. Thread safety: no state.
#pragma once

#include <array>
#include <cstddef>

#include "vio/work.h"

namespace ctn::vr {

enum class TrackingNode { kIntegrator, kCamera, kVio };
inline constexpr std::array<const char*, 3> kTrackingNodeNames{"Int", "Camera", "VIO"};  // in the app file

// Of a unit of each kind of work, and of a run that has nothing to do but to take its inputs.
struct TrackingFactors {
  double run = 0.0;
  double sample = 0.0;
  double moved = 0.0;
  double smoothed = 0.0;
  double cornered = 0.0;
  double window = 0.0;
  double vote = 0.0;
  double observation = 0.0;
  double multiply_add = 0.0;
};

// Measured with `vio_bench` (640 x 480, 60 s; the undistortion with EuRoC's pictures), on a machine that was not quiet.
inline constexpr std::array<TrackingFactors, 3> kTrackingFactors{{
    {.run = 250, .sample = 300},
    {.moved = 2.06, .smoothed = 0.58},
    {.sample = 4'718, .cornered = 10.8, .window = 1'703, .vote = 289, .multiply_add = 0.215},
}};

inline double cost(const TrackingFactors& factors, const Work& work) {
  return 1e-9 *
         (factors.run + factors.sample * static_cast<double>(work.samples) +
          factors.moved * static_cast<double>(work.moved) + factors.smoothed * static_cast<double>(work.smoothed) +
          factors.cornered * static_cast<double>(work.cornered) + factors.window * static_cast<double>(work.windows) +
          factors.vote * static_cast<double>(work.votes) +
          factors.observation * static_cast<double>(work.observations) +
          factors.multiply_add * static_cast<double>(work.multiply_adds));
}

// Times a board's slowdown, if it is slower than where the factors were measured.
inline double cost(TrackingNode node, const Work& work) {
  return cost(kTrackingFactors[static_cast<std::size_t>(node)], work);
}

}  // namespace ctn::vr
