// A head in a room of points, without pictures: a smooth trajectory with its exact inertial samples, and what a perfect
// tracker would see of the points, both with noise as ordered. For tests and benchmarks.
//
// The same options give the same values. Units: sensors.h. Thread safety: one thread an object.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "sensors.h"
#include "vio/feature_track.h"
#include "vio/filter.h"

namespace ctn::vr::testing {

// Looks along the body's x axis: the body's z is up when the head is upright.
Pose forward_camera();
// Such a camera, without distortion, that sees 77 degrees from side to side.
CameraModel camera_of(int width, int height);

struct SyntheticOptions {
  std::uint64_t seed = 1;
  double rest = 1.0;         // seconds of standing still at first
  double speed = 1.0;        // factor on all frequencies; 1: turns of up to 200 degrees a second
  double translation = 1.0;  // factor on all ways
  double pixel_noise = 1.0;
  double outliers = 0.0;          // share of the observations that are anywhere in the picture
  std::size_t points = 500;       // in the room
  std::size_t max_features = 50;  // in a picture
  ImuNoise imu{};
  Eigen::Vector3d gyro_bias{0.01, -0.02, 0.015};
  Eigen::Vector3d accelerometer_bias{0.05, -0.08, 0.06};
};

// Another way of the head, in place of the made-up one: twice continuously differentiable.
struct HeadPath {
  std::function<Pose(double)> pose;  // by time; world from body
};

class SyntheticHead {
 public:
  static constexpr double kImuPeriod = 0.005;

  explicit SyntheticHead(const SyntheticOptions& options, HeadPath path = {});

  const CameraModel& camera() const { return camera_; }
  // Without biases.
  State truth(double time) const;
  // Of the sample that was drawn last.
  State truth_with_biases(double time) const;
  // Without noise.
  ImuSample exact_sample(double time) const;

  // The next sample of 200 Hz; the first one is of time 0.
  ImuSample next_sample();
  // What is seen at `time`, which ascends from call to call.
  std::vector<Observation> observe(double time);

 private:
  struct Point {
    Eigen::Vector3d position;
    std::uint64_t feature = 0;  // while it is followed
  };

  Eigen::Vector3d position(double time) const;
  Eigen::Matrix3d orientation(double time) const;
  double start_up(double time) const;

  SyntheticOptions options_;
  HeadPath path_;
  CameraModel camera_;
  std::mt19937_64 random_;
  std::mt19937_64 picture_random_;
  std::normal_distribution<double> normal_;
  std::vector<double> phases_;
  std::vector<Point> points_;
  Eigen::Vector3d gyro_bias_;
  Eigen::Vector3d accelerometer_bias_;
  std::uint64_t samples_ = 0;
  std::uint64_t next_feature_ = 1;
};

}  // namespace ctn::vr::testing
