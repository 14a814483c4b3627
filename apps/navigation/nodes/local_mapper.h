// The LM node: what is near the robot, from scans and odometry alone.
//
// An occupancy grid of 6 m x 6 m moves with the robot in whole cells, in the odometry's frame. Each beam is evidence
// that the cells it passes are free and that the one it ends in is not; evidence fades, so that what moved away where
// the laser no longer looks is forgotten. Where the robot is, there is no obstacle. LP gets the distance from each cell
// to the nearest obstacle, with which it allows for the robot's size.
//
// What moves is tracked (motion_tracker.h) and given beside the map, with its velocity at the scan's instant. A beam
// that ends where the map knew a cell to be free, and no older obstacle beside it, tells that something has moved
// there. LP also gets the distances to what does not move, since it foresees where the rest will be.
//
// Units: metres, radians, seconds; stamps in nanoseconds. Thread safety: one thread an object.
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "geometry.h"
#include "grid.h"
#include "motion_tracker.h"
#include "scan_filter.h"
#include "sensors.h"
#include "work.h"

namespace ctn::navigation {

struct LocalMap {
  std::chrono::nanoseconds stamp{};  // the scan's
  Odometry odometry;                 // likewise
  GridFrame frame;                   // in the odometry's frame
  std::vector<float> clearance;
  std::vector<float> static_clearance;  // without what moves; empty: nothing does
  std::vector<MovingObstacle> moving;

  // If `point` is not on the map: farther than anything on it.
  double clearance_at(const Point& point) const;
  double static_clearance_at(const Point& point) const;
};

class LocalMapper {
 public:
  static constexpr double kSide = 6.0;
  static constexpr double kMemory = 20.0;  // seconds after which full evidence has faded to nothing
  static constexpr double kFarthestClearance = 1.0;

  struct Result {
    LocalMap map;
    Work work;
  };
  // A scan that is older than the one before is taken as if it were of the same time.
  Result run(const CleanScan& scan);

 private:
  void move_to(const Pose& pose);
  void fade(double seconds);
  // A beam of this length ends in the cell.
  void hit(int column, int row, double range);
  // Seconds since the instant, of entered_ or occupied_: exact to a sixteenth of a second after a week.
  double since(float instant) const { return now_ - static_cast<double>(instant); }
  bool beside_old_obstacle(int column, int row, double range) const;
  void clear_under(const Pose& pose, Work& work);
  void take_out(const MovingObstacle& moving, std::vector<std::uint8_t>& obstacles) const;

  GridFrame frame_;
  std::vector<float> evidence_;        // above 0: for an obstacle
  std::vector<std::uint32_t> marked_;  // the run that changed the cell last
  // In seconds, as now_: when something last came into the cell, which had been free; since when it is an obstacle.
  std::vector<float> entered_;
  std::vector<float> occupied_;
  double now_ = 0.0;
  std::uint32_t runs_ = 0;
  std::chrono::nanoseconds stamp_{};
  MotionTracker tracker_;
};

}  // namespace ctn::navigation
