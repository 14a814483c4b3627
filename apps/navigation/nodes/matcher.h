// Correlative scan matching: which pose makes the points of a scan fall on those of earlier scans.
//
// The earlier points are smeared into a grid around the expected pose, whose cells say how likely a hit there is. Every
// pose of a grid of poses around the expected one is tried, first coarsely, then finely around the best one; the score
// of a pose is the mean of what the points fall on, less a little for its distance from the expected pose, which
// decides where walls do not (along a corridor). Finely, values between the centres of cells are interpolated, so that
// a pose is found to less than a cell. Unlike iterated closest points (ICP), this needs no starting value that is
// nearly right, and takes a time that is known.
//
// Units: metres, radians. Thread safety: one thread an object.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "geometry.h"
#include "grid.h"
#include "work.h"

namespace ctn::navigation {

class Matcher {
 public:
  // Where a pose is looked for. The steps between the poses that are tried are kCoarse... or kFine... (matcher.cpp).
  struct Window {
    double offset = 0.32;  // to each side, metres
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
  // The fine search alone, around a pose that is nearly right and not far from the one of start().
  Match refine(const std::vector<Point>& points, const Pose& around, const Window& window);

  // The work since the last call.
  Work take_work() { return std::exchange(work_, {}); }

 private:
  // The points that count, turned by a heading, in cells of the grid.
  struct Turned {
    std::vector<double> x;
    std::vector<double> y;
  };

  // The poses that are tried.
  struct Poses {
    Pose centre;
    double offset;  // to each side
    double offset_step;
    double turn;
    double turn_step;
  };

  double coarse_score(double x, double y) const;
  double fine_score(double x, double y) const;
  Match best_of(const Poses& poses, bool fine, const Window& window);
  void take_near(const std::vector<Point>& points);
  void turn_points(double heading);

  Pose expected_;
  GridFrame frame_;
  std::vector<std::uint8_t> field_;
  std::vector<Point> near_;  // the points that count, seen from the robot
  Turned turned_;
  Work work_;
};

}  // namespace ctn::navigation
