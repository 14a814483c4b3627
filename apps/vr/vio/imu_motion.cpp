#include "vio/imu_motion.h"

#include <algorithm>
#include <cmath>

namespace ctn::vr {
namespace {

constexpr double kMaxAngularRate = 100.0;    // rad/s
constexpr double kMaxAcceleration = 1000.0;  // m/s^2

struct Derivative {
  Eigen::Vector4d orientation;  // x, y, z, w
  Eigen::Vector3d velocity;
  Eigen::Vector3d position;
};

Derivative derivative(const Eigen::Vector4d& orientation, const Eigen::Vector3d& velocity,
                      const Eigen::Vector3d& angular_rate, const Eigen::Vector3d& acceleration) {
  const Eigen::Quaterniond attitude(orientation);
  const Eigen::Quaterniond spin(0.0, angular_rate.x(), angular_rate.y(), angular_rate.z());
  return {0.5 * (attitude * spin).coeffs(), attitude.normalized() * acceleration - Eigen::Vector3d(0.0, 0.0, kGravity),
          velocity};
}

ImuSample between_samples(const ImuSample& before, const ImuSample& after, double time) {
  const double share = (time - before.time) / (after.time - before.time);
  return {time, before.angular_rate + share * (after.angular_rate - before.angular_rate),
          before.acceleration + share * (after.acceleration - before.acceleration)};
}

}  // namespace

State moved(const State& state, const ImuSample& from, const ImuSample& to) {
  const double step = to.time - state.time;
  if (!(step > 0.0)) return state;
  State next = state;
  next.time = to.time;
  if (step > kMaxStep) {
    next.velocity.setZero();
    return next;
  }
  const Eigen::Vector3d rates[3] = {from.angular_rate - state.gyro_bias,
                                    0.5 * (from.angular_rate + to.angular_rate) - state.gyro_bias,
                                    to.angular_rate - state.gyro_bias};
  const Eigen::Vector3d forces[3] = {from.acceleration - state.accelerometer_bias,
                                     0.5 * (from.acceleration + to.acceleration) - state.accelerometer_bias,
                                     to.acceleration - state.accelerometer_bias};
  const Eigen::Vector4d orientation = state.pose.orientation.coeffs();
  const Derivative a = derivative(orientation, state.velocity, rates[0], forces[0]);
  const Derivative b = derivative(orientation + 0.5 * step * a.orientation, state.velocity + 0.5 * step * a.velocity,
                                  rates[1], forces[1]);
  const Derivative c = derivative(orientation + 0.5 * step * b.orientation, state.velocity + 0.5 * step * b.velocity,
                                  rates[1], forces[1]);
  const Derivative d =
      derivative(orientation + step * c.orientation, state.velocity + step * c.velocity, rates[2], forces[2]);
  next.pose.orientation.coeffs() =
      orientation + step / 6.0 * (a.orientation + 2.0 * b.orientation + 2.0 * c.orientation + d.orientation);
  next.pose.orientation.normalize();
  next.velocity += step / 6.0 * (a.velocity + 2.0 * b.velocity + 2.0 * c.velocity + d.velocity);
  next.pose.position += step / 6.0 * (a.position + 2.0 * b.position + 2.0 * c.position + d.position);
  return next;
}

bool is_finite(const State& state) {
  return std::isfinite(state.time) && state.pose.orientation.coeffs().allFinite() && state.pose.position.allFinite() &&
         state.velocity.allFinite() && state.gyro_bias.allFinite() && state.accelerometer_bias.allFinite();
}

bool ImuHistory::add(const ImuSample& sample) {
  // Written so that what is not a number is refused, too.
  if (!std::isfinite(sample.time) || !(sample.angular_rate.norm() < kMaxAngularRate) ||
      !(sample.acceleration.norm() < kMaxAcceleration)) {
    return false;
  }
  if (!samples_.empty() && sample.time <= samples_.back().time) return false;
  if (samples_.size() == max_samples_) samples_.pop_front();
  samples_.push_back(sample);
  return true;
}

void ImuHistory::forget_before(double time) {
  while (samples_.size() > 1 && samples_[1].time <= time) samples_.pop_front();
}

ImuSample ImuHistory::at(double time) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), time,
                                      [](const ImuSample& sample, double at) { return sample.time < at; });
  if (after == samples_.begin() || after == samples_.end()) {
    ImuSample nearest = after == samples_.end() ? samples_.back() : samples_.front();
    nearest.time = time;
    return nearest;
  }
  return between_samples(*(after - 1), *after, time);
}

std::vector<ImuSample> ImuHistory::between(double begin, double end) const {
  if (samples_.empty() || !(end > begin)) return {};
  std::vector<ImuSample> found{at(begin)};
  for (auto next = std::upper_bound(samples_.begin(), samples_.end(), begin,
                                    [](double time, const ImuSample&sample) { return time < sample.time; });
       next != samples_.end() && next->time < end; ++next) {
    found.push_back(*next);
  }
  found.push_back(at(end));
  return found;
}

}  // namespace ctn::vr
