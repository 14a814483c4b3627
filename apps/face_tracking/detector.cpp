#include "detector.h"

#include <algorithm>
#include <filesystem>

#include "lens.h"

namespace ctn::face_tracking {
namespace {

// The smallest face and the step between sizes set what the node costs (55 to 60 ms).
constexpr double kScaleStep = 1.11;
constexpr int kFaceMin = 50;
constexpr int kFaceMax = 200;
constexpr int kVotesMin = 7;

}  // namespace

Result<Detector> Detector::open(const std::string& cascade_file) {
  cv::CascadeClassifier cascade;
  if (!std::filesystem::exists(cascade_file) || !cascade.load(cascade_file)) {
    return Error::environment("cannot read the cascade " + cascade_file,
                              "it is part of the Debian package opencv-data: sudo apt-get install opencv-data");
  }
  return Detector(cascade);
}

std::optional<Found> Detector::run(const cv::Mat& flat) {
  cascade_.detectMultiScale(flat, boxes_, votes_, kScaleStep, kVotesMin, 0, {kFaceMin, kFaceMin}, {kFaceMax, kFaceMax});
  if (boxes_.empty()) return std::nullopt;
  const auto best = static_cast<std::size_t>(std::ranges::max_element(votes_) - votes_.begin());
  const cv::Rect& box = boxes_[best];
  return Found{box, votes_[best], flat_angle(box.x + 0.5 * box.width)};
}

}  // namespace ctn::face_tracking
