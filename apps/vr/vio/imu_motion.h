// How a body moves by what its inertial unit measured: one step between two samples, and the samples of the last
// seconds.
//
// A step integrates orientation, velocity and position by the fourth-order Runge-Kutta method; angular rate and
// acceleration are taken to change linearly between the samples. Used by the integrator and by the filter.
//
// What a sensor should never send is refused: values that are not finite or beyond what any such sensor measures, and
// samples that are not later than the one before.
//
// Units: sensors.h. Thread safety: one thread an object.
#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "sensors.h"

namespace ctn::vr {

// The longest step. Where samples are missing for longer, nothing is known of the motion between them.
inline constexpr double kMaxStep = 0.1;

// `state` at to.time, by samples at its own time and at the end; their biases are the state's. Where `to` is more than
// kMaxStep later the body is taken to have stood still; where it is not later, `state` itself.
State moved(const State& state, const ImuSample& from, const ImuSample& to);

bool is_finite(const State& state);

class ImuHistory {
 public:
  // Keeps the newest `max_samples` samples.
  explicit ImuHistory(std::size_t max_samples) : max_samples_(max_samples) {}

  // False: it was refused.
  bool add(const ImuSample& sample);
  // Keeps one sample at `time` or before, from which to go on.
  void forget_before(double time);
  void clear() { samples_.clear(); }

  // The samples from `begin` to `end`, the first and the last of them at these very times: interpolated, or, where
  // there are none beyond, the nearest one. Empty if there are no samples at all, or `end` is not after `begin`.
  std::vector<ImuSample> between(double begin, double end) const;

  const std::deque<ImuSample>& samples() const { return samples_; }

 private:
  ImuSample at(double time) const;

  std::size_t max_samples_;
  std::deque<ImuSample> samples_;
};

}  // namespace ctn::vr
