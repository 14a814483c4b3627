#include "preprocess.h"

#include <cmath>

#include "lens.h"

namespace ctn::face_tracking {
namespace {

// The diameter sets what the node costs (about 25 ms).
constexpr int kDenoiseDiameter = 9;
constexpr double kDenoiseColour = 20.0;
constexpr double kDenoiseSpace = 3.0;

}  // namespace

Preprocess::Preprocess() : equaliser_(cv::createCLAHE(2.0, {8, 8})) {
  cv::Mat columns(kFlatHeight, kFlatWidth, CV_32FC1);
  cv::Mat rows(kFlatHeight, kFlatWidth, CV_32FC1);
  for (int y = 0; y < kFlatHeight; ++y) {
    for (int x = 0; x < kFlatWidth; ++x) {
      const double right = x + 0.5 - 0.5 * kFlatWidth;
      const double down = y + 0.5 - 0.5 * kFlatHeight;
      columns.at<float>(y, x) = static_cast<float>(raw_column(-std::atan2(right, kFocalLength)) - 0.5);
      rows.at<float>(y, x) =
          static_cast<float>(0.5 * kRawHeight + kRawPixelsPerRadian * down / std::hypot(right, kFocalLength) - 0.5);
    }
  }
  cv::convertMaps(columns, rows, map_, map_fine_, CV_16SC2);
}

void Preprocess::run(const cv::Mat& raw, cv::Mat& flat) {
  cv::bilateralFilter(raw, clean_, kDenoiseDiameter, kDenoiseColour, kDenoiseSpace);
  cv::remap(clean_, colour_, map_, map_fine_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::cvtColor(colour_, grey_, cv::COLOR_BGR2GRAY);
  equaliser_->apply(grey_, flat);
}

}  // namespace ctn::face_tracking
