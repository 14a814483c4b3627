// What a run of a node did, counted. Its cost in virtual time is computed from this (cost.h).
//
// Thread safety: values.
#pragma once

#include <cstdint>

namespace ctn::navigation {

struct Work {
  std::uint64_t beams = 0;       // of scans that were read or filtered
  std::uint64_t cells = 0;       // of grids that were written or read one after the other
  std::uint64_t candidates = 0;  // points of scans, or of the robot's outline, that were looked up in a grid
  std::uint64_t expanded = 0;    // nodes of a graph search
  std::uint64_t poses = 0;       // of the robot, on its way along a trajectory that is tried

  Work& operator+=(const Work& more) {
    beams += more.beams;
    cells += more.cells;
    candidates += more.candidates;
    expanded += more.expanded;
    poses += more.poses;
    return *this;
  }
  bool operator==(const Work&) const = default;
};

}  // namespace ctn::navigation
