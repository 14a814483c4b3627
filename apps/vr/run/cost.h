// What Render and Timewarp cost in virtual time: so much for each pixel of what the wearer sees. (What tracking costs
// is in vio/cost.h.)
//
// Units: nanoseconds. Thread safety: no state.
#pragma once

#include <chrono>
#include <cmath>

#include "sensors.h"

namespace ctn::vr::run {

// Measured with `vr_drawing_bench`, without a GPU (docs/vr.md): medians of 320 x 240 to 640 x 480.
inline constexpr double kRenderPixel = 13.0;
inline constexpr double kRotationalPixel = 5.2;
inline constexpr double kTranslationalPixel = 14.5;

inline std::chrono::nanoseconds drawing_cost(double pixel, const CameraModel& eye) {
  return std::chrono::nanoseconds(std::llround(pixel * eye.width * eye.height));
}

}  // namespace ctn::vr::run
