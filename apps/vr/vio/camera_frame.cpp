#include "vio/camera_frame.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace ctn::vr {

Camera::Camera(const CameraModel& model)
    : model_(model), straight_(model.k1 == 0.0 && model.k2 == 0.0 && model.p1 == 0.0 && model.p2 == 0.0) {
  cv::setNumThreads(1);
  if (straight_) return;
  const cv::Matx33d camera(model.fx, 0.0, model.cx, 0.0, model.fy, model.cy, 0.0, 0.0, 1.0);
  const cv::Vec4d distortion(model.k1, model.k2, model.p1, model.p2);
  cv::initUndistortRectifyMap(camera, distortion, cv::noArray(), camera, cv::Size(model.width, model.height), CV_16SC2,
                              map_, map_fine_);
}

Result<CameraFrame> Camera::run(const cv::Mat& picture, double time) {
  if (!std::isfinite(time)) {
    return Error::caller("the time of a camera's picture is not a finite number", "give the time that it was taken at");
  }
  if (picture.cols != model_.width || picture.rows != model_.height) {
    return Error::caller(fmt::format("a picture of {} x {} pixels from a camera of {} x {}", picture.cols, picture.rows,
                                     model_.width, model_.height),
                         "give the camera's model the size of its pictures");
  }
  if (picture.type() != CV_8UC1 && picture.type() != CV_8UC3) {
    return Error::caller("a camera's picture has neither one nor three channels of 8 bit",
                         "convert it to CV_8UC1 or CV_8UC3");
  }
  CameraFrame frame;
  frame.time = time;
  cv::Mat grey = picture;
  if (picture.channels() == 3) {
    cv::Mat converted;
    cv::cvtColor(picture, converted, cv::COLOR_BGR2GRAY);
    grey = converted;
  }
  if (!straight_) {
    cv::Mat flat;
    cv::remap(grey, flat, map_, map_fine_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    grey = flat;
    frame.work.moved = grey.total();
  }
  // Each frame has its own pixels, since VIO may still look at those of the frame before.
  cv::buildOpticalFlowPyramid(grey, frame.pyramid, cv::Size(kWindow, kWindow), kPyramidLevels - 1, true,
                              cv::BORDER_REFLECT_101, cv::BORDER_CONSTANT, false);
  for (std::size_t level = 0; level < frame.pyramid.size(); level += 2) {
    frame.work.smoothed += frame.pyramid[level].total();
  }
  return frame;
}

}  // namespace ctn::vr
