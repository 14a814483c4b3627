#include "vio/standstill.h"

#include <cmath>
#include <cstddef>
#include <vector>

namespace ctn::vr {
namespace {

constexpr double kMinRate = 50.0;                 // samples a second, mean
constexpr double kMaxGyroBias = 0.2;              // rad/s
constexpr double kMaxGyroSpread = 0.03;           // rad/s, standard deviation
constexpr double kMaxAccelerometerBias = 0.5;     // m/s^2
constexpr double kMaxAccelerometerSpread = 0.25;  // m/s^2, standard deviation

}  // namespace

std::optional<State> standing_state(const ImuHistory& history, double time) {
  std::vector<ImuSample> samples;
  for (const ImuSample& sample : history.samples()) {
    if (sample.time > time - kStandstill && sample.time <= time) samples.push_back(sample);
  }
  if (static_cast<double>(samples.size()) < kMinRate * kStandstill) return std::nullopt;
  const auto count = static_cast<double>(samples.size());
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : samples) {
    rate += sample.angular_rate / count;
    force += sample.acceleration / count;
  }
  double rate_spread = 0.0;
  double force_spread = 0.0;
  for (const ImuSample& sample : samples) {
    rate_spread += (sample.angular_rate - rate).squaredNorm() / count;
    force_spread += (sample.acceleration - force).squaredNorm() / count;
  }
  if (rate.norm() > kMaxGyroBias || std::sqrt(rate_spread) > kMaxGyroSpread ||
      std::abs(force.norm() - kGravity) > kMaxAccelerometerBias || std::sqrt(force_spread) > kMaxAccelerometerSpread) {
    return std::nullopt;
  }
  State state;
  state.time = time;
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(force, Eigen::Vector3d::UnitZ());
  // Of all orientations with this up, the one whose yaw is zero.
  const Eigen::Matrix3d matrix = upright.toRotationMatrix();
  const double yaw = std::atan2(matrix(1, 0), matrix(0, 0));
  state.pose.orientation = Eigen::AngleAxisd(-yaw, Eigen::Vector3d::UnitZ()) * upright;
  state.gyro_bias = rate;
  return state;
}

}  // namespace ctn::vr
