// The GP node: a path on the global map, to a goal or to where the map ends.
//
// Obstacles are inflated by the robot's size; cells near them cost more, so that paths keep away where there is room.
// What the newest scan shows nearby is an obstacle, too, even if the map does not have it yet, or says that the place
// was free: a path leads round it. If that leaves no way at all, what the scan shows is taken to be passing by.
//
// Where the way has become a long one since the last run, what blocks the short one may be passing by, too: the path
// then leads on through it, and LP waits in front of it, but no longer than the way round takes longer. So the robot
// needs at most twice the time that it would have needed had it known (the rule for renting skis: Karlin, Manasse,
// Rudolph and Sleator, "Competitive snoopy caching", 1988). Then what blocks the way counts until the laser sees
// through it, also where the robot no longer looks at it.
//
// To a goal: A* over the cells, where unknown ones may be passed at a higher cost. Without a goal: Dijkstra's algorithm
// over all known free cells that can be reached gives the cost of the way to each frontier, a group of cells that
// border on the unknown (Yamauchi, 1997). Of those that are large enough for the robot to pass, the one with the least
// cost is taken, less what it promises to show (Burgard et al., 2005). If there is none, the robot has explored all
// that it can.
//
// Units: metres, nanoseconds. Thread safety: one thread an object.
#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "geometry.h"
#include "global_localizer.h"
#include "global_mapper.h"
#include "grid.h"
#include "work.h"

namespace ctn::navigation {

struct Path {
  enum class Outcome {
    kFound,
    kNothingLeft,  // no frontier can be reached: all is explored
    kNoWay,        // the goal cannot be reached
    kNoMap,        // nothing was planned yet
  };
  Outcome outcome = Outcome::kNoMap;
  std::chrono::nanoseconds stamp{};  // of the map
  std::vector<Point> points;         // in the map's frame, from the robot to the end, at most kSpacing apart
  bool to_goal = false;
  Anchor anchor;  // of the map

  static constexpr double kSpacing = 0.2;
};

class GlobalPlanner {
 public:
  static constexpr double kClearance = 0.42;  // that a path keeps from obstacles, where the robot is not nearer already
  static constexpr double kComfortable = 0.8;       // farther cells cost nothing extra
  static constexpr double kSmallestFrontier = 0.6;  // length
  static constexpr double kScanReach = 4.0;         // from the robot: farther hits of the newest scan do not count
  static constexpr double kWorthWaiting = 3.0;      // metres: a way round that is less longer is taken at once

  struct Result {
    Path path;
    Work work;
  };
  // From where the robot was at the newest scan.
  Result run(const GlobalMap& map, const Localization& localization, const std::optional<Point>& goal);
  // By the map alone.
  Result run(const GlobalMap& map, const Pose& robot, const std::optional<Point>& goal) const;

 private:
  bool waits_for(double seconds, std::chrono::nanoseconds now);

  // Cost of the last path, in metres in the open: a way that costs no more is not blocked. None: there was no path.
  std::optional<double> expected_;
  std::optional<std::chrono::nanoseconds> waits_since_;  // in front of what blocks the way
  std::vector<Point> blocked_;                           // what it waited for in vain, in the map's frame
};

}  // namespace ctn::navigation
