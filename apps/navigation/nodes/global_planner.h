// The GP node: a path on the global map, to a goal or to where the map ends.
//
// Obstacles are inflated by the robot's size; cells near them cost more, so that paths keep away where there is room.
// To a goal: A* over the cells, where unknown ones may be passed at a higher cost. Without a goal: Dijkstra's algorithm
// over the known free cells, until it reaches a cell of a frontier, a group of cells that border on the unknown,
// which is large enough for the robot to pass: the nearest frontier (Yamauchi, 1997). If there is none, the robot has
// explored all that it can.
//
// Units: metres, nanoseconds. Thread safety: no state.
#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "geometry.h"
#include "global_mapper.h"
#include "grid.h"
#include "work.h"

namespace ctn::navigation {

struct Path {
  enum class Outcome {
    kFound,
    kNothingLeft,  // no frontier can be reached: all is explored
    kNoWay,        // the goal cannot be reached, or there is no map yet
  };
  Outcome outcome = Outcome::kNoWay;
  std::chrono::nanoseconds stamp{};  // of the map
  std::vector<Point> points;         // in the map's frame, from the robot to the end, at most kSpacing apart
  bool to_goal = false;

  static constexpr double kSpacing = 0.2;
};

class GlobalPlanner {
 public:
  static constexpr double kClearance = 0.42;  // that a path keeps from obstacles, where the robot is not nearer already
  static constexpr double kComfortable = 0.8;       // farther cells cost nothing extra
  static constexpr double kSmallestFrontier = 0.6;  // length

  struct Result {
    Path path;
    Work work;
  };
  Result run(const GlobalMap& map, const Pose& robot, const std::optional<Point>& goal) const;
};

}  // namespace ctn::navigation
