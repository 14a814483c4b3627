#include "detector/preprocess.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include <opencv2/calib3d.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace ctn::navigation {
namespace {

constexpr double kDenoiseColour = 20.0;  // levels that count as noise rather than as an edge
constexpr double kDenoiseSpace = 3.0;
const cv::Scalar kFilling(127.0, 127.0, 127.0);

std::uint64_t area(cv::Size size) {
  return static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
}

// Pixels in a round filter.
std::uint64_t taps_of(int diameter) {
  const int radius = diameter / 2;
  std::uint64_t taps = 0;
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) taps += x * x + y * y <= radius * radius ? 1U : 0U;
  }
  return taps;
}

// Empty if it cannot be decoded; OpenCV throws where the picture would be too large.
cv::Mat decoded(const EncodedPicture& picture) {
  if (picture.empty()) return {};
  try {
    return cv::imdecode(picture, cv::IMREAD_COLOR);
  } catch (const cv::Exception&) {
    return {};
  }
}

cv::Mat fitted(const cv::Mat& picture, const Letterbox& letterbox) {
  if (!letterbox.scales() && !letterbox.pads()) return picture;
  cv::Mat input =
      letterbox.pads() ? cv::Mat(letterbox.input(), CV_8UC3, kFilling) : cv::Mat(letterbox.input(), CV_8UC3);
  cv::Mat content = input(letterbox.content());
  const bool shrinks = letterbox.content().width < picture.cols;
  cv::resize(picture, content, content.size(), 0.0, 0.0, shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
  return input;
}

}  // namespace

Preprocess::Preprocess(const InputForm& form, const PreprocessSettings& settings) : form_(form), settings_(settings) {
  cv::setNumThreads(1);
}

PictureWork Preprocess::work(cv::Size picture) const {
  const Letterbox letterbox(picture, form_.size);
  PictureWork work;
  work.decoded = area(picture);
  if (settings_.denoise_diameter > 0) work.taps = area(picture) * taps_of(settings_.denoise_diameter);
  if (settings_.lens) work.moved += area(picture);
  if (letterbox.scales()) work.moved += std::max(area(picture), area(letterbox.content().size()));
  if (form_.pixels == InputForm::Pixels::kPlanes) work.moved += area(form_.size);
  return work;
}

std::string Preprocess::identity() const {
  const Lens lens = settings_.lens.value_or(Lens{0.0, 0.0, 0.0});
  return fmt::format("preprocess {}x{} {} {} {} {} {}", form_.size.width, form_.size.height,
                     static_cast<int>(form_.pixels), settings_.denoise_diameter, lens.focal_length, lens.k1, lens.k2);
}

Result<Prepared> Preprocess::run(const EncodedPicture& picture) {
  // Each run has its own pixels, since the detector may still look at those of the run before.
  cv::Mat pixels = decoded(picture);
  if (pixels.empty()) {
    return Error::environment(fmt::format("cannot decode a picture of {} bytes from the camera", picture.size()),
                              "pictures are JPEG, or another format that OpenCV can read");
  }
  if (settings_.denoise_diameter > 0) {
    cv::Mat clean;
    cv::bilateralFilter(pixels, clean, settings_.denoise_diameter, kDenoiseColour, kDenoiseSpace);
    pixels = std::move(clean);
  }
  if (settings_.lens) {
    if (of_maps_ != pixels.size()) make_maps(pixels.size());
    cv::Mat flat;
    cv::remap(pixels, flat, map_, map_fine_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    pixels = std::move(flat);
  }
  const Letterbox letterbox(pixels.size(), form_.size);
  const PictureWork did = work(pixels.size());
  cv::Mat input = fitted(pixels, letterbox);
  if (form_.pixels == InputForm::Pixels::kPlanes) input = cv::dnn::blobFromImage(input, 1.0 / 255.0, {}, {}, true);
  return Prepared{std::move(input), letterbox, did};
}

void Preprocess::make_maps(cv::Size picture) {
  const Lens& lens = *settings_.lens;
  const double focal_length = lens.focal_length * picture.width;
  const cv::Matx33d camera(focal_length, 0.0, 0.5 * (picture.width - 1), 0.0, focal_length, 0.5 * (picture.height - 1),
                           0.0, 0.0, 1.0);
  const cv::Vec4d distortion(lens.k1, lens.k2, 0.0, 0.0);
  cv::initUndistortRectifyMap(camera, distortion, cv::noArray(), camera, picture, CV_16SC2, map_, map_fine_);
  of_maps_ = picture;
}

}  // namespace ctn::navigation
