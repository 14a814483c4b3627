// The GM node: one occupancy grid of all that the robot has seen, from GL's keyframes.
//
// The grid (MRPT's) is built anew from all keyframes whenever there are new ones, since closing a loop may move any
// of them: the cost of a run grows with the way that the robot has gone, and with the area. Without new keyframes the
// last map stays. What moved is no obstacle, where another keyframe shortly before or after saw through (visibility.h):
// else it would close every doorway that it went along, until enough later keyframes have looked there.
//
// Units: metres, radians, nanoseconds. Thread safety: one thread an object. Maps are shared and never change.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry.h"
#include "global_localizer.h"
#include "grid.h"
#include "keyframe.h"
#include "visibility.h"
#include "work.h"

namespace ctn::navigation {

enum class Cell : std::uint8_t { kUnknown, kFree, kObstacle };

struct GlobalMap {
  std::chrono::nanoseconds stamp{};  // of the localization that it was made from
  GridFrame frame;                   // in the map's frame
  std::vector<Cell> cells;
  Anchor anchor;  // of the keyframes that it was made from

  Cell at(const Point& point) const {
    const int column = frame.column(point.x);
    const int row = frame.row(point.y);
    return frame.inside(column, row) ? cells[frame.index(column, row)] : Cell::kUnknown;
  }
};
using SharedMap = std::shared_ptr<const GlobalMap>;

class GlobalMapper {
 public:
  // Up to here neighbouring beams leave no cell of size kCell out. Farther hits are used by the matcher only.
  static constexpr double kReach = 8.0;

  struct Result {
    SharedMap map;  // never null; without cells before the first keyframe
    Work work;
  };

  GlobalMapper();
  Result run(const Localization& localization);

 private:
  SharedKeyframes used_;
  StillPoints still_;
  SharedMap map_;
};

}  // namespace ctn::navigation
