// Finds the face in the camera's picture with a HAAR cascade: the windows of a picture pyramid go through stages of
// ever more features, and most leave early. So what it costs depends a little on the picture.
//
// Thread safety: one thread an object.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/objdetect.hpp>

#include "catan/result.h"

namespace ctn::face_tracking {

struct Found {
  cv::Rect box;  // in the flat picture
  int votes;     // windows that agreed
  double angle;  // of its centre from the camera's axis, radians
};

class Detector {
 public:
  // `cascade_file`: errors as for the footage.
  static Result<Detector> open(const std::string& cascade_file);

  // The face that most windows agree on, or nothing. `flat`: 8UC1.
  std::optional<Found> run(const cv::Mat& flat);

 private:
  explicit Detector(const cv::CascadeClassifier& cascade) : cascade_(cascade) {}

  cv::CascadeClassifier cascade_;
  std::vector<cv::Rect> boxes_;
  std::vector<int> votes_;
};

}  // namespace ctn::face_tracking
