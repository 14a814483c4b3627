// The camera's geometry.
//
// The raw picture is that of a wide-angle lens: a column is an angle (a strip of a cylinder around the camera). The
// camera node flattens it to the picture of a pinhole camera, in which straight lines are straight and faces near the
// edge are as wide as the detector knows them.
//
// Units: pixels, radians. Angles grow to the left, as bearings do.
#pragma once

#include <cmath>
#include <numbers>

namespace ctn::face_tracking {

inline constexpr int kRawWidth = 960;
inline constexpr int kRawHeight = 720;
inline constexpr double kRawPixelsPerRadian = 820.0;

inline constexpr int kFlatWidth = 640;
inline constexpr int kFlatHeight = 480;
inline constexpr double kHalfView = 30.0 * std::numbers::pi / 180.0;
inline const double kFocalLength = 0.5 * kFlatWidth / std::tan(kHalfView);  // of the flat picture

inline double raw_column(double angle) { return 0.5 * kRawWidth - angle * kRawPixelsPerRadian; }
inline double flat_angle(double column) { return std::atan2(0.5 * kFlatWidth - column, kFocalLength); }

}  // namespace ctn::face_tracking
