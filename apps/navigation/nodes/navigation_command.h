// The NC node: where LP should head now, from the global path and the newest pose.
//
// The robot's pose is the odometry's, corrected by GL. From the point of the path nearest to it, a point a little
// ahead is looked up, the carrot (that point itself, if the robot is far from it), and the path beyond, which LP needs
// where something that the global map lacks stands on the carrot. LP gets both in the odometry's frame, so that it
// needs no correction.
//
// Without a way, or with nothing left to explore, the robot is to look around: what closed the way on the map may have
// been passing by, and new keyframes show whether it is still there.
//
// Units: metres, nanoseconds. Thread safety: no state.
#pragma once

#include <chrono>
#include <vector>

#include "geometry.h"
#include "global_localizer.h"
#include "global_planner.h"
#include "sensors.h"
#include "work.h"

namespace ctn::navigation {

struct Command {
  std::chrono::nanoseconds stamp{};  // of the odometry that it was made from
  bool stop = true;
  bool look_around = false;    // turning on the spot; `stop` is true then, too
  bool arrived = false;        // at the goal, not at a frontier
  Point carrot;                // in the odometry's frame
  std::vector<Point> beyond;   // likewise: the path from the carrot on, as far as LP's map may reach
  double distance_left = 0.0;  // along the path
};

class NavigationCommand {
 public:
  static constexpr double kLookahead = 0.8;
  static constexpr double kBeyond = 3.0;    // from the robot: half the side of the local map
  static constexpr double kArrived = 0.15;  // no farther from the end of the path, the robot has arrived

  struct Result {
    Command command;
    Work work;
  };
  Result run(const Path& path, const Localization& localization, const Odometry& odometry) const;
};

}  // namespace ctn::navigation
