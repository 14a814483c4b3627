// Correlative scan matching: which pose makes the points of a scan fall on those of earlier scans (E. Olson, "Real-Time
// Correlative Scan Matching", ICRA 2009).
//
// The earlier points are smeared into a grid around the expected pose, whose cells say how likely a hit there is. Every
// pose of a grid of poses around the expected one is tried, first coarsely, then finely around the best one; the score
// of a pose is the mean of what the points fall on. It is the logarithm of a likelihood: together with how likely the
// pose is by what was known before (odometry), it decides which pose is the best. So where walls do not say where the
// robot is (along a corridor), odometry does. Finely, values between the centres of cells are interpolated, and in the
// end poses between those that were tried, so that a pose is found to a fraction of a cell. Unlike iterated closest
// points (ICP), this needs no starting value that is nearly right, and takes a time that is known.
//
// How far poses are spread that the scan alone makes about as likely as the best one is the match's covariance: a
// corridor leaves it as wide as the window along its axis, and so does a second place that looks the same.
//
// Units: metres, radians. Thread safety: one thread an object.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "geometry.h"
#include "grid.h"
#include "pose_matrix.h"
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
    double score = 0.0;     // 0: no point falls on an earlier one; 1: all do, exactly
    PoseMatrix covariance;  // of the pose by the scan alone; along the axes of the map
  };

  static constexpr double kReach = 10.0;  // from the expected pose; points beyond do not count

  // Forgets the earlier points; the new ones will be around `expected`.
  void start(const Pose& expected);
  // Earlier points, seen from `pose`.
  void add(const Pose& pose, const std::vector<Point>& points);
  // `known`: information about the expected pose, along the axes of the map; none by default.
  Match match(const std::vector<Point>& points, const Window& window, const PoseMatrix& known = {});
  // The fine search alone, around a pose that is nearly right and not far from the one of start().
  Match refine(const std::vector<Point>& points, const Pose& around, const Window& window,
               const PoseMatrix& known = {});

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
  Match best_of(const Poses& poses, bool fine, const PoseMatrix& known);
  // The best pose between those of the fine search: the peak of parabolas through its neighbours, along each axis.
  Match polished(Match match, const PoseMatrix& known);
  // The logarithm of how likely a pose is, by the scan and by what was known, up to a constant.
  double judged(const Pose& pose, double score, const PoseMatrix& known) const;
  // The covariance of the poses that were tried last, each as likely as its score says.
  PoseMatrix spread_of(const Poses& poses) const;
  void take_near(const std::vector<Point>& points);
  void turn_points(double heading);

  Pose expected_;
  GridFrame frame_;
  std::vector<std::uint8_t> field_;
  std::vector<Point> near_;  // the points that count, seen from the robot
  Turned turned_;
  std::vector<float> scores_;  // of the poses that were tried last, in their order
  Work work_;
};

}  // namespace ctn::navigation
