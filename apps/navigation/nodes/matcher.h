// Correlative scan matching: which pose makes the points of a scan fall on those of earlier scans.
//
// The earlier points are smeared into a grid around the expected pose, whose cells say how likely a hit there is. Every
// pose of a grid of poses around the expected one is tried, first coarsely, then finely around the best one; the score
// of a pose is the mean of the cells that the points fall into, less a little for its distance from the expected pose,
// which decides where walls do not (along a corridor). Unlike iterated closest points (ICP), this needs no starting
// value that is nearly right, and takes a time that is known.
//
// Units: metres, radians. Thread safety: one thread an object.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry.h"
#include "grid.h"
#include "work.h"

namespace ctn::navigation {

class Matcher {
 public:
  struct Window {
    double offset = 0.24;  // to each side, metres
    double turn = 0.21;    // to each side, radians
  };
  struct Match {
    Pose pose;
    double score = 0.0;  // 0: no point falls on an earlier one; 1: all do, exactly
  };

  static constexpr double kReach = 10.0;  // from the expected pose; points beyond do not count

  // Forgets the earlier points; the new ones will be around `expected`.
  void start(const Pose& expected);
  // Earlier points, seen from `pose`.
  void add(const Pose& pose, const std::vector<Point>& points);
  Match match(const std::vector<Point>& points, const Window& window);

  // The work since start().
  const Work& work() const { return work_; }

 private:
  // The points that count, turned by a heading, in cells of the grid.
  struct Turned {
    std::vector<double> x;
    std::vector<double> y;
  };

  double raw_score(double x, double y) const;
  Match best_of(const Pose& centre, double offset, double offset_step, double turn, double turn_step,
                const Window& window);
  void turn_points(double heading);

  Pose expected_;
  GridFrame frame_;
  std::vector<std::uint8_t> field_;
  std::vector<Point> near_;  // the points that count, seen from the robot
  Turned turned_;
  Work work_;
};

}  // namespace ctn::navigation
