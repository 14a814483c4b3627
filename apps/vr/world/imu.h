// The headset's inertial unit: what gyroscope and accelerometer say of a trajectory, with white noise, and biases that
// were there when it was switched on and wander.
//
// A sample is the true value at its instant, plus the bias, plus noise whose standard deviation is density x
// sqrt(rate). A bias is a random walk with steps of walk x sqrt(1 / rate). Which noise a sample has follows from the
// seed and the sample's number, not from which ones were asked for.
//
// Units: seconds, rad/s, m/s^2. Thread safety: immutable; the trajectory must outlive it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sensors.h"
#include "world/trajectory.h"

namespace ctn::vr::world {

// Those of the ADIS16448, a consumer-grade unit, as the files of the EuRoC data set have them (imu0/sensor.yaml; Burri
// et al., "The EuRoC micro aerial vehicle datasets", 2016). The biases at the start are of the size that its ground
// truth has: some 0.08 rad/s and 0.1 m/s^2 about the worst axis in V1_02.
struct ImuNoise {
  double gyro_density = 1.6968e-4;        // rad/s/sqrt(Hz)
  double gyro_walk = 1.9393e-5;           // rad/s^2/sqrt(Hz)
  double accelerometer_density = 2.0e-3;  // m/s^2/sqrt(Hz)
  double accelerometer_walk = 3.0e-3;     // m/s^3/sqrt(Hz)
  double gyro_start = 0.03;               // rad/s: standard deviation of the bias at the start, about each axis
  double accelerometer_start = 0.05;      // m/s^2

  static ImuNoise none() { return {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}; }
};

class Imu {
 public:
  static constexpr double kRate = 200.0;

  Imu(const Trajectory& trajectory, std::uint64_t seed, const ImuNoise& noise = {}, double rate = kRate);

  // From time 0 to the trajectory's end.
  std::size_t size() const { return biases_.size(); }
  double time(std::size_t index) const { return static_cast<double>(index) / rate_; }

  // Precondition: index < size().
  ImuSample sample(std::size_t index) const;
  // What is true at the sample's instant.
  State truth(std::size_t index) const;

 private:
  const Trajectory& trajectory_;
  std::uint64_t seed_;
  ImuNoise noise_;
  double rate_;
  std::vector<std::array<double, 6>> biases_;  // of each sample: gyroscope, accelerometer
};

}  // namespace ctn::vr::world
