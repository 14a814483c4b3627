// How the head moves: the truth that sensors and pictures of a world come from.
//
// HeadTrajectory is a person who stands in a room, walks from place to place and looks around: sums of smooth motions,
// in closed form. Gaze shifts and steps from place to place are minimum-jerk movements (fifth-order polynomials), as
// people's are (Flash and Hogan, 1985); a sway and, while walking, a bob are added; the head turns about the neck. So
// position and orientation have continuous second derivatives, and all that at() says is exactly consistent. The first
// second is at rest but for the sway.
//
// RecordedTrajectory follows poses that were recorded: a cumulative cubic B-spline through poses of equal distance in
// time (orientation on SO(3); Sommer et al., "Efficient derivative computation for cumulative B-splines on Lie groups",
// 2020). It is consistent in itself, and stays within a millimetre or so of what was recorded: where it drives a world,
// the spline is the truth.
//
// Units: metres, radians, seconds from 0 to duration(). Thread safety: immutable.
#pragma once

#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "sensors.h"

namespace ctn::vr::world {

struct Motion {
  Pose pose;                                               // world from body
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      // in the world's frame
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // in the world's frame; gravity is not in it
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  // in the body's frame
};

class Trajectory {
 public:
  Trajectory() = default;
  Trajectory(const Trajectory&) = delete;
  Trajectory& operator=(const Trajectory&) = delete;
  virtual ~Trajectory() = default;

  // Before 0 and after duration() the pose is that of the end, and nothing moves.
  virtual Motion at(double time) const = 0;
  virtual double duration() const = 0;
};

struct HeadOptions {
  std::uint64_t seed = 1;
  double duration = 60.0;
  // Where the neck may be, about the room's middle.
  double reach_x = 1.8;
  double reach_y = 1.6;
  double height = 1.55;                                     // of the neck
  double max_turn_rate = 200.0 * std::numbers::pi / 180.0;  // of the head, in rad/s; 0.5 at least
};

// The head's axes: x forwards, y to the left, z up.
class HeadTrajectory : public Trajectory {
 public:
  explicit HeadTrajectory(const HeadOptions& options);

  Motion at(double time) const override;
  double duration() const override { return options_.duration; }

 private:
  struct GazeShift {
    double start;
    double duration;
    double yaw;  // before
    double pitch;
    double yaw_by;
    double pitch_by;
  };
  struct Walk {
    double start;
    double duration;
    Eigen::Vector2d from;
    Eigen::Vector2d to;
  };

  void add_walks();
  void add_gaze_shifts();

  HeadOptions options_;
  std::vector<GazeShift> gaze_shifts_;  // in order of time, none before another one has ended; likewise walks
  std::vector<Walk> walks_;
  double phases_[18] = {};  // of the sway
};

struct TimedPose {
  double time = 0.0;
  Pose pose;
};

class RecordedTrajectory : public Trajectory {
 public:
  // `poses`: two at least, in order of time. The trajectory begins with the first of them. All positions are moved by
  // `offset`: recordings have other origins than rooms.
  explicit RecordedTrajectory(std::span<const TimedPose> poses,
                              const Eigen::Vector3d& offset = Eigen::Vector3d::Zero());

  Motion at(double time) const override;
  double duration() const override { return duration_; }

 private:
  double spacing_ = 0.0;
  double duration_ = 0.0;
  std::vector<Pose> controls_;  // one every spacing_, the first and the last of them twice more
};

}  // namespace ctn::vr::world
