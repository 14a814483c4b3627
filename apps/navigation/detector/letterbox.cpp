#include "detector/letterbox.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace ctn::navigation {

Letterbox::Letterbox(cv::Size picture, cv::Size input) : picture_(picture), input_(input) {
  assert(picture.width > 0 && picture.height > 0 && input.width > 0 && input.height > 0);
  const double scale =
      std::min(static_cast<double>(input.width) / picture.width, static_cast<double>(input.height) / picture.height);
  const int width = std::clamp(static_cast<int>(std::lround(scale * picture.width)), 1, input.width);
  const int height = std::clamp(static_cast<int>(std::lround(scale * picture.height)), 1, input.height);
  content_ = {(input.width - width) / 2, (input.height - height) / 2, width, height};
}

cv::Rect2d Letterbox::to_picture(const cv::Rect2d& box) const {
  const double across = static_cast<double>(picture_.width) / content_.width;
  const double down = static_cast<double>(picture_.height) / content_.height;
  const auto column = [&](double x) {
    return std::clamp((x - content_.x) * across, 0.0, static_cast<double>(picture_.width));
  };
  const auto row = [&](double y) {
    return std::clamp((y - content_.y) * down, 0.0, static_cast<double>(picture_.height));
  };
  return {cv::Point2d(column(box.x), row(box.y)), cv::Point2d(column(box.x + box.width), row(box.y + box.height))};
}

}  // namespace ctn::navigation
