#include "vio/vio.h"

#include <cmath>

#include "vio/imu_motion.h"
#include "vio/rotation.h"
#include "vio/standstill.h"

namespace ctn::vr {
namespace {

constexpr double kMaxRestDisplacement = 0.7;  // pixels from keyframe to keyframe

}  // namespace

Vio::Vio(const CameraModel& model, const VioSettings& settings)
    : model_(model), filter_(model, settings.filter), tracker_(model, settings.tracker) {}

// Of the camera, from `before` to `now`, as the gyroscope measured it.
Eigen::Quaterniond Vio::turned_since(double before, double now) const {
  Eigen::Quaterniond body = Eigen::Quaterniond::Identity();
  const std::vector<ImuSample> steps = filter_.history().between(before, now);
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const double step = steps[i].time - steps[i - 1].time;
    if (step > kMaxStep) continue;
    const Eigen::Vector3d rate = 0.5 * (steps[i - 1].angular_rate + steps[i].angular_rate) - filter_.state().gyro_bias;
    body = (body * rotation(step * rate)).normalized();
  }
  const Eigen::Quaterniond& body_from_camera = model_.body_from_camera.orientation;
  return (body_from_camera.conjugate() * body.conjugate() * body_from_camera).normalized();
}

void Vio::start_if_at_rest(double time, const std::optional<double>& displacement) {
  if (!displacement || *displacement > kMaxRestDisplacement) {
    resting_since_.reset();
    return;
  }
  if (!resting_since_) resting_since_ = time;
  if (time - *resting_since_ < kStandstill) return;
  if (const std::optional<State> state = standing_state(filter_.history(), time)) {
    filter_.start(*state, {.tilt = 0.002, .gyro_bias = 0.005, .tilt_from_accelerometer = true});
  }
}

Vio::Result Vio::run(const CameraFrame& frame) {
  Result result;
  if (!std::isfinite(frame.time) || (frame_time_ && frame.time <= *frame_time_)) return result;
  const double before = frame_time_.value_or(frame.time);
  const bool keyframe = keyframes_.take(frame.time);
  const Tracker::Result tracked = tracker_.run(frame, turned_since(before, frame.time), keyframe);
  frame_time_ = frame.time;
  result.features = tracked.observations.size();
  result.work = tracked.work;
  if (!filter_.started()) {
    start_if_at_rest(frame.time, tracked.displacement);
    if (filter_.started()) result.state = filter_.state();
    return result;
  }
  const Filter::Outcome outcome = filter_.update(frame.time, tracked.observations, keyframe);
  result.used = outcome.used;
  result.work += outcome.work;
  if (outcome.taken) result.state = filter_.state();
  return result;
}

}  // namespace ctn::vr
