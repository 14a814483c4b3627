// What a run of a node did, counted. Its cost in virtual time is computed from this (cost.h).
//
// Thread safety: values.
#pragma once

#include <cstdint>

namespace ctn::vr {

struct Work {
  std::uint64_t samples = 0;        // of the inertial unit that were integrated
  std::uint64_t moved = 0;          // pixels that were undistorted
  std::uint64_t smoothed = 0;       // pixels of a pyramid's levels, with their derivatives
  std::uint64_t cornered = 0;       // pixels that were tried as corners
  std::uint64_t windows = 0;        // of features that were looked for: tracks times levels
  std::uint64_t votes = 0;          // tracks times the motions that they were compared with
  std::uint64_t observations = 0;   // of features that were triangulated, times iterations
  std::uint64_t multiply_adds = 0;  // of the filter's matrices

  Work& operator+=(const Work& more) {
    samples += more.samples;
    moved += more.moved;
    smoothed += more.smoothed;
    cornered += more.cornered;
    windows += more.windows;
    votes += more.votes;
    observations += more.observations;
    multiply_adds += more.multiply_adds;
    return *this;
  }
  bool operator==(const Work&) const = default;
};

}  // namespace ctn::vr
