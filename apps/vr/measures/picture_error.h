// How wrong a picture is at the instant at which its photons reach the eye: the pose that it shows beside the true one.
//
// A picture that is drawn at one pose and turned to another shows what would be seen with the newer orientation from
// the older place; one that is also moved by its depths, what would be seen at the newer pose. `shown` below is that
// pose, which says everything, so that no picture is needed to measure.
//
// Units: metres, degrees, pixels. Thread safety: pure; Errors is for one thread.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "sensors.h"

namespace ctn::vr::measures {

// The pose that a picture shows, drawn at `drawn` and warped to `warped`.
Pose shown_by_rotation(const Pose& drawn, const Pose& warped);

// Rotation between what is shown and what is true, in degrees.
double rotation_error(const Pose& shown, const Pose& truth);

// How far the eye is from where the picture has it, in metres.
double translation_error(const Pose& shown, const Pose& truth);

// How far it is from `origin` along `direction` to what can be seen there, in lengths of `direction`; none: nothing.
using Depths = std::function<std::optional<double>(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)>;

// How far the points that the eye sees at its true pose are from where the picture has them, in pixels: the mean over a
// grid of columns x rows points of the eye's picture, at their true depths. Points that the picture has behind the eye
// are not counted; none, where that leaves no point. Poses are those of the eye's camera.
std::optional<double> pixel_error(const CameraModel& eye, const Pose& shown, const Pose& truth, const Depths& depths,
                                  int columns = 8, int rows = 6);

// Errors of many pictures.
class Errors {
 public:
  void add(double error) { errors_.push_back(error); }
  std::size_t count() const { return errors_.size(); }
  // 0 without errors.
  double mean() const;
  // The smallest error that at least that many percent do not exceed. Precondition: 0 < percent <= 100. 0 without
  // errors.
  double percentile(double percent) const;

 private:
  std::vector<double> errors_;
};

}  // namespace ctn::vr::measures
