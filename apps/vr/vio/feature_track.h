// What the filter learns of a picture: where in it features are that were seen before or are new.
//
// Units: the image plane of a pinhole camera without distortion, at distance 1: (x / z, y / z) in the camera's frame.
// Thread safety: values.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "sensors.h"

namespace ctn::vr {

struct Observation {
  std::uint64_t feature = 0;  // the same number in all pictures; a feature that was lost never comes back under its own
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
};

// Of a picture without distortion.
inline Eigen::Vector2d pinhole_point(const CameraModel& model, const Eigen::Vector2d& pixel) {
  return {(pixel.x() - model.cx) / model.fx, (pixel.y() - model.cy) / model.fy};
}
inline Eigen::Vector2d pinhole_pixel(const CameraModel& model, const Eigen::Vector2d& point) {
  return {model.fx * point.x() + model.cx, model.fy * point.y() + model.cy};
}

}  // namespace ctn::vr
