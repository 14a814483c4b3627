// Which way is up, and what the gyroscope's bias is, of a body that stands still.
//
// At rest the accelerometer measures gravity alone, so its mean tells roll and pitch (as far as its bias allows), and
// the mean of the gyroscope is its bias. Yaw and position cannot be known: both are zero.
//
// Units: sensors.h. Thread safety: no state.
#pragma once

#include <optional>

#include "sensors.h"
#include "vio/imu_motion.h"

namespace ctn::vr {

inline constexpr double kStandstill = 0.5;  // seconds that it takes

// Nothing if the body moved in the kStandstill seconds before `time`, or samples are missing.
std::optional<State> standing_state(const ImuHistory& history, double time);

}  // namespace ctn::vr
