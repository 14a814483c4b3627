// What the camera node does to a raw picture before anyone may use it: noise removed with edges kept, the lens's
// distortion removed, grey, local contrast evened out.
//
// Thread safety: one thread an object.
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace ctn::face_tracking {

class Preprocess {
 public:
  Preprocess();

  // `raw`: 8UC3 of the raw size. `flat`: 8UC1 of the flat size.
  void run(const cv::Mat& raw, cv::Mat& flat);

 private:
  cv::Mat map_;  // where each flat pixel is in the raw picture, fixed point
  cv::Mat map_fine_;
  cv::Ptr<cv::CLAHE> equaliser_;
  cv::Mat clean_;
  cv::Mat colour_;
  cv::Mat grey_;
};

}  // namespace ctn::face_tracking
