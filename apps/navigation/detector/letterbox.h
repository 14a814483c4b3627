// How a picture is fitted into the input of a detector: scaled until it fits, its shape kept, in the middle; what is
// left over on two sides is filled.
//
// Units: pixels. Thread safety: values.
#pragma once

#include <opencv2/core.hpp>

namespace ctn::navigation {

class Letterbox {
 public:
  // Both are at least one pixel wide and high.
  Letterbox(cv::Size picture, cv::Size input);

  cv::Size picture() const { return picture_; }
  cv::Size input() const { return input_; }

  // Where the picture is in the input.
  const cv::Rect& content() const { return content_; }
  bool scales() const { return content_.size() != picture_; }
  bool pads() const { return content_.size() != input_; }

  // From the input's pixels to the picture's, cut off at its edges. The content's corners are the picture's corners.
  cv::Rect2d to_picture(const cv::Rect2d& box) const;

 private:
  cv::Size picture_;
  cv::Size input_;
  cv::Rect content_;
};

}  // namespace ctn::navigation
