#include "vio/testing/synthetic.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "vio/rotation.h"

namespace ctn::vr::testing {
namespace {

constexpr double kHalfLength = 3.0;  // of the room, along x
constexpr double kHalfWidth = 2.5;
constexpr double kHeight = 2.6;
constexpr double kStep = 1e-4;  // of numeric derivatives: errors of 1e-7

double wave(double amplitude, double frequency, double phase, double time) {
  return amplitude * std::sin(2.0 * std::numbers::pi * frequency * time + phase);
}

}  // namespace

Pose forward_camera() { return {looking_forward(), {0.05, 0.02, -0.01}}; }

CameraModel camera_of(int width, int height) {
  CameraModel model;
  model.width = width;
  model.height = height;
  model.fx = model.fy = 0.625 * width;
  model.cx = 0.5 * (width - 1);
  model.cy = 0.5 * (height - 1);
  model.body_from_camera = forward_camera();
  return model;
}

SyntheticHead::SyntheticHead(const SyntheticOptions& options, HeadPath path)
    : options_(options),
      path_(std::move(path)),
      random_(options.seed),
      picture_random_(options.seed + 1000),
      gyro_bias_(options.gyro_bias),
      accelerometer_bias_(options.accelerometer_bias) {
  camera_.body_from_camera = forward_camera();
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int i = 0; i < 12; ++i) phases_.push_back(2.0 * std::numbers::pi * uniform(random_));
  for (std::size_t i = 0; i < options_.points; ++i) {
    // One draw a line, here and below: in which order arguments are evaluated is the compiler's choice.
    const double z = kHeight * uniform(random_);
    const double y = kHalfWidth * (2.0 * uniform(random_) - 1.0);
    const double x = kHalfLength * (2.0 * uniform(random_) - 1.0);
    Eigen::Vector3d point(x, y, z);
    // Two thirds lie on the walls, the others on what stands in the room.
    switch (i % 6) {
      case 0:
        point.x() = kHalfLength;
        break;
      case 1:
        point.x() = -kHalfLength;
        break;
      case 2:
        point.y() = kHalfWidth;
        break;
      case 3:
        point.y() = -kHalfWidth;
        break;
      default:
        point.z() *= 0.5;
    }
    points_.push_back({point});
  }
}

// Time that the head has moved for: it speeds up within two seconds, twice continuously differentiable.
double SyntheticHead::start_up(double time) const {
  const double moving = time - options_.rest;
  if (moving <= 0.0) return 0.0;
  constexpr double kSpeedUp = 2.0;
  const double share = moving / kSpeedUp;
  if (share >= 1.0) return options_.speed * (moving - 0.5 * kSpeedUp);
  // The integral of 10 s^3 - 15 s^4 + 6 s^5.
  return options_.speed * kSpeedUp * (2.5 * std::pow(share, 4) - 3.0 * std::pow(share, 5) + std::pow(share, 6));
}

Eigen::Vector3d SyntheticHead::position(double time) const {
  if (path_.pose) return path_.pose(time).position;
  const double t = start_up(time);
  return options_.translation * Eigen::Vector3d(wave(0.9, 0.11, phases_[0], t) + wave(0.15, 0.43, phases_[1], t),
                                                wave(0.7, 0.13, phases_[2], t) + wave(0.12, 0.51, phases_[3], t),
                                                wave(0.15, 0.19, phases_[4], t) + wave(0.03, 0.9, phases_[5], t)) +
         Eigen::Vector3d(0.0, 0.0, 1.5);
}

Eigen::Matrix3d SyntheticHead::orientation(double time) const {
  if (path_.pose) return path_.pose(time).orientation.toRotationMatrix();
  const double t = start_up(time);
  // At most 2.64 + 0.85 rad/s: 200 degrees a second.
  const double yaw = wave(1.2, 0.35, phases_[6], t) + wave(0.15, 0.9, phases_[7], t) + wave(1.0, 0.02, phases_[8], t);
  const double pitch = wave(0.3, 0.27, phases_[9], t);
  const double roll = wave(0.15, 0.31, phases_[10], t);
  return (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

State SyntheticHead::truth(double time) const {
  State state;
  state.time = time;
  state.pose = {Eigen::Quaterniond(orientation(time)), position(time)};
  state.velocity = (position(time + kStep) - position(time - kStep)) / (2.0 * kStep);
  return state;
}

State SyntheticHead::truth_with_biases(double time) const {
  State state = truth(time);
  state.gyro_bias = gyro_bias_;
  state.accelerometer_bias = accelerometer_bias_;
  return state;
}

ImuSample SyntheticHead::exact_sample(double time) const {
  const Eigen::Matrix3d body_from_world = orientation(time).transpose();
  const Eigen::Vector3d acceleration =
      (position(time + kStep) - 2.0 * position(time) + position(time - kStep)) / (kStep * kStep);
  const Eigen::Matrix3d turned = orientation(time - kStep).transpose() * orientation(time + kStep);
  return {time, rotation_vector(Eigen::Quaterniond(turned)) / (2.0 * kStep),
          body_from_world * (acceleration + Eigen::Vector3d(0.0, 0.0, kGravity))};
}

ImuSample SyntheticHead::next_sample() {
  const auto noise = [&](double deviation) {
    const double z = normal_(random_);
    const double y = normal_(random_);
    const double x = normal_(random_);
    return Eigen::Vector3d(deviation * Eigen::Vector3d(x, y, z));
  };
  ImuSample sample = exact_sample(kImuPeriod * static_cast<double>(samples_++));
  const double root = std::sqrt(kImuPeriod);
  gyro_bias_ += noise(options_.imu.gyro_walk * root);
  accelerometer_bias_ += noise(options_.imu.accelerometer_walk * root);
  sample.angular_rate += gyro_bias_ + noise(options_.imu.gyro / root);
  sample.acceleration += accelerometer_bias_ + noise(options_.imu.accelerometer / root);
  return sample;
}

std::vector<Observation> SyntheticHead::observe(double time) {
  constexpr double kMargin = 8.0;  // pixels
  const Pose camera_from_world = inverse(transformed(truth(time).pose, camera_.body_from_camera));
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Observation> observations;
  const auto see = [&](Point& point, bool follow_only) {
    if (follow_only != (point.feature != 0)) return;
    const Eigen::Vector3d seen = transformed(camera_from_world, point.position);
    const Eigen::Vector2d pixel =
        seen.z() > 0.3 ? pinhole_pixel(camera_, seen.hnormalized()) : Eigen::Vector2d(-1.0, -1.0);
    if (pixel.x() < kMargin || pixel.y() < kMargin || pixel.x() > camera_.width - kMargin ||
        pixel.y() > camera_.height - kMargin) {
      point.feature = 0;
      return;
    }
    if (observations.size() >= options_.max_features) return;
    if (point.feature == 0) point.feature = next_feature_++;
    const double v = normal_(picture_random_);
    const double u = normal_(picture_random_);
    Eigen::Vector2d noisy = pixel + options_.pixel_noise * Eigen::Vector2d(u, v);
    if (uniform(picture_random_) < options_.outliers) {
      noisy = {uniform(picture_random_) * camera_.width, uniform(picture_random_) * camera_.height};
    }
    observations.push_back({point.feature, pinhole_point(camera_, noisy)});
  };
  for (Point& point : points_) see(point, true);
  for (Point& point : points_) see(point, false);
  return observations;
}

}  // namespace ctn::vr::testing
