#include "world/imu.h"

#include <cassert>
#include <cmath>

#include "program/random.h"

namespace ctn::vr::world {
namespace {

constexpr std::uint64_t kWhite = 21;  // streams of random numbers: six axes from here on each
constexpr std::uint64_t kWalk = 31;
constexpr std::uint64_t kStart = 41;

}  // namespace

Imu::Imu(const Trajectory& trajectory, std::uint64_t seed, const ImuNoise& noise, double rate)
    : trajectory_(trajectory), seed_(seed), noise_(noise), rate_(rate) {
  assert(rate > 0.0);
  biases_.resize(static_cast<std::size_t>(std::floor(trajectory.duration() * rate)) + 1);
  const double share = std::sqrt(1.0 / rate);
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const bool gyro = axis < 3;
    const program::Noise walk(seed, kWalk + axis);
    double bias = (gyro ? noise.gyro_start : noise.accelerometer_start) * program::Noise(seed, kStart + axis).normal(0);
    for (std::size_t i = 0; i < biases_.size(); ++i) {
      biases_[i][axis] = bias;
      bias += (gyro ? noise.gyro_walk : noise.accelerometer_walk) * share * walk.normal(i);
    }
  }
}

ImuSample Imu::sample(std::size_t index) const {
  assert(index < size());
  const Motion motion = trajectory_.at(time(index));
  const double spread = std::sqrt(rate_);
  const auto white = [&](std::size_t axis) { return program::Noise(seed_, kWhite + axis).normal(index); };
  ImuSample sample;
  sample.time = time(index);
  sample.angular_rate = motion.angular_rate;
  sample.acceleration =
      motion.pose.orientation.conjugate() * (motion.acceleration + Eigen::Vector3d(0.0, 0.0, kGravity));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    sample.angular_rate[i] += biases_[index][axis] + noise_.gyro_density * spread * white(axis);
    sample.acceleration[i] += biases_[index][axis + 3] + noise_.accelerometer_density * spread * white(axis + 3);
  }
  return sample;
}

State Imu::truth(std::size_t index) const {
  assert(index < size());
  const Motion motion = trajectory_.at(time(index));
  const std::array<double, 6>& bias = biases_[index];
  return {time(index), motion.pose, motion.velocity, {bias[0], bias[1], bias[2]}, {bias[3], bias[4], bias[5]}};
}

}  // namespace ctn::vr::world
