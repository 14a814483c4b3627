// Which cameras can be drawn, and what must be drawn for them. No OpenGL.
//
// Units: pixels. Thread safety: pure.
#pragma once

#include "catan/result.h"
#include "sensors.h"

namespace ctn::vr::drawing {

inline constexpr int kMaxSide = 4096;  // of a picture, in pixels

// Errors: kCaller, where the picture is empty or too large.
Status check_size(const CameraModel& camera);

bool has_distortion(const CameraModel& camera);

// An eye without distortion that sees 90 degrees from side to side.
CameraModel eye_of(int width, int height);

// The camera that Render should draw for an eye: the same focal length, and `margin` (0.05: a twentieth) more on each
// side, so that a picture that is warped by a little still covers what the eye sees.
CameraModel with_margin(const CameraModel& eye, double margin);

// A camera without distortion that sees all that the lens shows, as finely as its middle. Errors: kCaller, where there
// is none that could be drawn.
Result<CameraModel> covering(const CameraModel& camera);

}  // namespace ctn::vr::drawing
