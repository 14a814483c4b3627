// Finds people who stand or walk: OpenCV's histograms of oriented gradients with the linear classifier that it brings
// along (Dalal and Triggs, 2005). The classifier is asked at each eighth pixel of the picture at 31 sizes, so people
// from a sixth of the picture's height up are found, and a run costs the same whatever the picture shows.
//
// `confidence` is the classifier's margin: 0.5 at least, 2 is certain in practice, and there is no upper end.
//
// Thread safety: one thread an object.
#pragma once

#include <opencv2/objdetect.hpp>

#include "detector/detector.h"

namespace ctn::navigation {

class PeopleDetector final : public Detector {
 public:
  static constexpr int kWidth = 768;
  static constexpr int kHeight = 576;
  static constexpr double kConfidenceMin = 0.5;

  // `size` of the pictures it takes. Smaller ones cost less, and small people are not found in them.
  explicit PeopleDetector(cv::Size size = {kWidth, kHeight});

  InputForm form() const override { return {size_, InputForm::Pixels::kBytes}; }
  PictureWork work() const override;
  std::string name(int label) const override;
  std::string identity() const override;
  Detections run(const Prepared& picture) override;

 private:
  cv::Size size_;
  cv::HOGDescriptor descriptor_;
  std::vector<cv::Rect> windows_;
  std::vector<double> margins_;
};

}  // namespace ctn::navigation
