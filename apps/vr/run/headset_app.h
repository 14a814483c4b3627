// The app file of a run: that of headset.yaml, for the display's rate, the camera and the scheduler that are asked for.
//
// Thread safety: pure.
#pragma once

#include <chrono>
#include <string>

#include "run/options.h"

namespace ctn::vr::run {

inline constexpr std::chrono::nanoseconds kImuPeriod = std::chrono::milliseconds(5);  // of the simulated headset
// Who paces Timewarp and Render where the scheduler does not (run/pacer.h), and how often they look whether it is time:
// so often in each period of the display.
inline constexpr int kTimewarpLooks = 16;
inline constexpr int kRenderLooks = 8;
inline constexpr const char* kTimewarpPacer = "pace_timewarp";
inline constexpr const char* kRenderPacer = "pace_render";
inline constexpr const char* kDisplayNode = "display";
// The camera's own clock, where it has one.
inline constexpr const char* kExposure = "exposure";

// Whether pictures come at a rate of their own.
bool has_camera_clock(const Options& options);
std::chrono::nanoseconds camera_period(const Options& options);  // then
// Of the inertial unit: that of the data set, where there is one.
std::chrono::nanoseconds sample_period(const Options& options);

std::string app_text(const Options& options);

}  // namespace ctn::vr::run
