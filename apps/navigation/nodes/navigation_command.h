// The NC node: where LP should head now, from the global path and the newest pose.
//
// The robot's pose is the odometry's, corrected by GL. On the path the point nearest to it is looked up, and from there
// the one a little ahead (the carrot), which LP gets in the odometry's frame, so that it needs no correction itself.
//
// Units: metres, seconds. Thread safety: no state.
#pragma once

#include "global_localizer.h"
#include "global_planner.h"
#include "types.h"

namespace ctn::navigation {

struct Command {
  double stamp = 0.0;  // of the odometry that it was made of
  bool stop = true;
  bool arrived = false;        // at the goal, not at a frontier
  Point carrot;                // in the odometry's frame
  double distance_left = 0.0;  // along the path
};

class NavigationCommand {
 public:
  static constexpr double kLookahead = 0.8;
  static constexpr double kArrived = 0.15;  // so near the end of the path counts as there

  struct Result {
    Command command;
    Work work;
  };
  Result run(const Path& path, const Localization& localization, const Odometry& odometry) const;
};

}  // namespace ctn::navigation
