// A picture that was drawn, and from where.
//
// Frames are values, read back from the drawing context, so that the thread which draws and the one which warps need
// no common context: contexts that share something may have to wait for each other (screen.h).
//
// Units: metres. Thread safety: values.
#pragma once

#include <cstdint>
#include <vector>

#include "sensors.h"

namespace ctn::vr::drawing {

// A point at this depth, or nearer, has a nearness of 255, twice as far 127.5, and so on.
inline constexpr double kNearestDepth = 0.2;

struct Frame {
  CameraModel camera;      // without distortion
  Pose world_from_camera;  // at which it was drawn; the camera's own place on the body is not looked at
  // For each pixel, row by row from the top: red, green, blue, nearness (255 kNearestDepth / depth along the camera's
  // z axis, rounded; 0: nothing was drawn there).
  std::vector<std::uint8_t> pixels;
};

}  // namespace ctn::vr::drawing
