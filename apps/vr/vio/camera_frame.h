// The Camera node: makes of a camera's picture what VIO tracks features in.
//
// The lens's distortion is removed (maps are computed once), so that everything after it may take the camera for a
// pinhole with the same focal lengths and centre; then a pyramid of grey pictures with their derivatives is made, each
// level half the size of the one below, as OpenCV's pyramidal Lucas-Kanade tracker wants it.
//
// Units: pixels, seconds. Thread safety: one thread an object; frames share their pixels and are not changed any more.
// Sets OpenCV to use one thread.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "catan/result.h"
#include "sensors.h"
#include "vio/work.h"

namespace ctn::vr {

inline constexpr int kWindow = 21;        // side of the square around a feature in which it is looked for
inline constexpr int kPyramidLevels = 4;  // the picture itself is the first

struct CameraFrame {
  double time = 0.0;
  // Of each level its grey pixels, then its derivatives by x and y (cv::buildOpticalFlowPyramid).
  std::vector<cv::Mat> pyramid;
  Work work;

  const cv::Mat& picture() const { return pyramid.front(); }
};

class Camera {
 public:
  explicit Camera(const CameraModel& model);

  // `picture`: grey or blue, green and red, 8 bit each. Errors (kCaller): it is of another kind, or not of the model's
  // size; its time is not finite.
  Result<CameraFrame> run(const cv::Mat& picture, double time);

 private:
  CameraModel model_;
  bool straight_;  // nothing to undistort
  cv::Mat map_;    // where each pixel is in the camera's picture, fixed point
  cv::Mat map_fine_;
};

}  // namespace ctn::vr
