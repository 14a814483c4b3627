// The NC node: where LP should head now, from the global path and the newest pose.
//
// The robot's pose is the odometry's, corrected by GL. From the point of the path nearest to it, a point a little
// ahead is looked up, the carrot. LP gets the carrot in the odometry's frame, so that it needs no correction.
//
// Units: metres, nanoseconds. Thread safety: no state.
#pragma once

#include <chrono>

#include "geometry.h"
#include "global_localizer.h"
#include "global_planner.h"
#include "sensors.h"
#include "work.h"

namespace ctn::navigation {

struct Command {
  std::chrono::nanoseconds stamp{};  // of the odometry that it was made from
  bool stop = true;
  bool arrived = false;        // at the goal, not at a frontier
  Point carrot;                // in the odometry's frame
  double distance_left = 0.0;  // along the path
};

class NavigationCommand {
 public:
  static constexpr double kLookahead = 0.8;
  static constexpr double kArrived = 0.15;  // no farther from the end of the path, the robot has arrived

  struct Result {
    Command command;
    Work work;
  };
  Result run(const Path& path, const Localization& localization, const Odometry& odometry) const;
};

}  // namespace ctn::navigation
