// The Int node: where the body is now, and where it will be when a picture is shown.
//
// VIO tells of a state in the past: that of the last picture that it has worked through. From there on all samples of
// the inertial unit are integrated (imu_motion.h); each new sample moves the state by one step, and when VIO tells of a
// newer state the samples after it are integrated again from there.
//
// Units: sensors.h. Thread safety: one thread an object.
#pragma once

#include <cstddef>
#include <optional>

#include "sensors.h"
#include "vio/imu_motion.h"
#include "vio/work.h"

namespace ctn::vr {

struct MovingState {
  State state;
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  // without bias, in the body's frame
};

// World from body at `time`, if angular rate and velocity stay what they are. A time before the state's gives the
// state's pose, as does one that is no number; one that is later than kMaxPrediction, the pose at that limit.
inline constexpr double kMaxPrediction = 0.1;
Pose predicted(const MovingState& moving, double time);

class Integrator {
 public:
  static constexpr std::size_t kMaxSamples = 1000;  // 5 s at 200 Hz: VIO may be that late

  // The next sample. One that cannot be true is left out (imu_motion.h).
  Work add(const ImuSample& sample);

  // A state of VIO. One that is not finite or older than the one before is left out. If it is older than all samples
  // that are left, the body is taken to have stood still until the first of them.
  Work rebase(const State& filtered);

  // The newest state; nothing before VIO's first one.
  const std::optional<MovingState>& newest() const { return newest_; }

 private:
  void step(const ImuSample& to);

  ImuHistory history_{kMaxSamples};
  std::optional<State> base_;
  std::optional<MovingState> newest_;
  std::optional<ImuSample> last_;  // up to which was integrated
};

}  // namespace ctn::vr
