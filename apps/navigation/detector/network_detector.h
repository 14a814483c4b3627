// Finds things in pictures with a network of the user's, of the YOLO family in Darknet's format, run by OpenCV's dnn
// module on the CPU.
//
// What the network emits becomes detections in the usual way: boxes that are at least kConfidenceMin sure, of those of
// a class that overlap by more than kOverlapMax the surest only. `confidence` is the network's: that there is
// something, times that it is of this class; 0 to 1.
//
// Thread safety: one thread an object.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/dnn.hpp>

#include "catan/result.h"
#include "detector/detector.h"

namespace ctn::navigation {

struct NetworkFiles {
  std::string description;           // FILE.cfg
  std::string weights;               // FILE.weights
  std::optional<std::string> names;  // of the classes, one a line
};

class NetworkDetector final : public Detector {
 public:
  static constexpr double kConfidenceMin = 0.25;
  static constexpr double kOverlapMax = 0.45;  // intersection over union

  // Also runs the network once, so that it is known to work and its buffers are there. Errors (kCaller): a file is not
  // there or is not what it should be, files that do not belong together, layers that OpenCV does not have.
  static Result<std::unique_ptr<NetworkDetector>> open(const NetworkFiles& files);

  InputForm form() const override { return {input_, InputForm::Pixels::kPlanes}; }
  PictureWork work() const override { return work_; }
  std::string name(int label) const override;
  std::string identity() const override { return identity_; }
  Detections run(const Prepared& picture) override;

 private:
  NetworkDetector() = default;
  Status check_outputs(const std::string& description, int classes);
  void forward(const cv::Mat& input);

  cv::dnn::Net network_;
  std::vector<std::string> output_names_;
  std::vector<cv::Mat> outputs_;
  cv::Size input_;
  std::vector<std::string> names_;
  PictureWork work_;
  std::string identity_;
};

}  // namespace ctn::navigation
