#include "detector/people_detector.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

namespace ctn::navigation {
namespace {

constexpr int kStride = 8;
constexpr double kLevelStep = 1.05;  // from one size to the next
constexpr double kGrouping = 2.0;    // windows that must agree

// The classifier was trained with people in the middle of its window: a margin all around belongs to it, not to them.
constexpr double kMarginAcross = 0.2;
constexpr double kMarginDown = 0.1;

cv::Rect2d person_in(const cv::Rect& window) {
  return {window.x + kMarginAcross * window.width, window.y + kMarginDown * window.height,
          (1.0 - 2.0 * kMarginAcross) * window.width, (1.0 - 2.0 * kMarginDown) * window.height};
}

}  // namespace

PeopleDetector::PeopleDetector(cv::Size size) : size_(size) {
  cv::setNumThreads(1);
  descriptor_.setSVMDetector(cv::HOGDescriptor::getDefaultPeopleDetector());
}

PictureWork PeopleDetector::work() const {
  const cv::Size window = descriptor_.winSize;
  PictureWork work;
  double scale = 1.0;
  for (int level = 0; level < descriptor_.nlevels; ++level, scale *= kLevelStep) {
    const auto width = static_cast<int>(std::lround(size_.width / scale));
    const auto height = static_cast<int>(std::lround(size_.height / scale));
    if (width < window.width || height < window.height) break;
    work.gradients += static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    work.windows += static_cast<std::uint64_t>((width - window.width) / kStride + 1) *
                    static_cast<std::uint64_t>((height - window.height) / kStride + 1);
  }
  return work;
}

std::string PeopleDetector::name(int) const { return "person"; }

std::string PeopleDetector::identity() const {
  return fmt::format("hog {}x{} {} {} {} {}", size_.width, size_.height, kStride, kLevelStep, kGrouping,
                     kConfidenceMin);
}

Detections PeopleDetector::run(const Prepared& picture) {
  assert(picture.input.size() == size_ && picture.input.type() == CV_8UC3);
  descriptor_.detectMultiScale(picture.input, windows_, margins_, 0.0, {kStride, kStride}, {0, 0}, kLevelStep,
                               kGrouping);
  Detections found{{}, work()};
  for (std::size_t i = 0; i < windows_.size(); ++i) {
    if (margins_[i] < kConfidenceMin) continue;
    const cv::Rect2d box = picture.letterbox.to_picture(person_in(windows_[i]));
    if (!box.empty()) found.things.push_back({0, margins_[i], box});
  }
  sort_by_confidence(found.things);
  return found;
}

}  // namespace ctn::navigation
