#include "vio/integrator.h"

#include <algorithm>
#include <vector>

#include "vio/rotation.h"

namespace ctn::vr {

Pose predicted(const MovingState& moving, double time) {
  const double wanted = time - moving.state.time;
  if (!(wanted > 0.0)) return moving.state.pose;
  const double ahead = std::min(wanted, kMaxPrediction);
  return {(moving.state.pose.orientation * rotation(ahead * moving.angular_rate)).normalized(),
          moving.state.pose.position + ahead * moving.state.velocity};
}

void Integrator::step(const ImuSample& to) {
  newest_->state = moved(newest_->state, last_.value_or(to), to);
  newest_->angular_rate = to.angular_rate - newest_->state.gyro_bias;
  last_ = to;
}

Work Integrator::add(const ImuSample& sample) {
  Work work;
  if (!history_.add(sample)) return work;
  if (!newest_) return work;
  if (sample.time <= newest_->state.time) {
    last_ = sample;
    return work;
  }
  step(sample);
  work.samples = 1;
  return work;
}

Work Integrator::rebase(const State& filtered) {
  Work work;
  if (!is_finite(filtered) || (base_ && filtered.time <= base_->time)) return work;
  base_ = filtered;
  newest_ = MovingState{filtered, Eigen::Vector3d::Zero()};
  last_.reset();
  history_.forget_before(filtered.time);
  if (history_.samples().empty()) return work;
  const std::vector<ImuSample> steps = history_.between(filtered.time, history_.samples().back().time);
  last_ = steps.empty() ? history_.samples().back() : steps.front();
  newest_->angular_rate = last_->angular_rate - filtered.gyro_bias;
  if (steps.empty()) return work;
  for (std::size_t i = 1; i < steps.size(); ++i) step(steps[i]);
  work.samples = steps.size() - 1;
  return work;
}

}  // namespace ctn::vr
