#include "view.h"

#include <cmath>
#include <utility>

#include "lens.h"

namespace ctn::face_tracking {
namespace {

constexpr double kFilmRate = 6.0;    // of the frames kept, per second
constexpr double kNoiseSigma = 4.0;  // grey levels
constexpr int kNoiseMargin = 64;

}  // namespace

View::View(Footage footage, std::uint64_t seed) : footage_(std::move(footage)) {
  noise_.create(kRawHeight + kNoiseMargin, kRawWidth + kNoiseMargin, CV_8SC3);
  cv::RNG random(seed);
  random.fill(noise_, cv::RNG::NORMAL, 0.0, kNoiseSigma);
}

void View::render(const Sight& sight, double time, std::uint64_t noise, cv::Mat& raw) const {
  raw.create(kRawHeight, kRawWidth, CV_8UC3);
  const int ring = footage_.panorama.cols;
  const double axis = -sight.pan * kRawPixelsPerRadian - 0.5 * kRawWidth;
  const int left = static_cast<int>(std::lround(axis - ring * std::floor(axis / ring))) % ring;
  const int first = std::min(kRawWidth, ring - left);
  footage_.panorama.colRange(left, left + first).copyTo(raw.colRange(0, first));
  if (first < kRawWidth) footage_.panorama.colRange(0, kRawWidth - first).copyTo(raw.colRange(first, kRawWidth));

  const auto frame = static_cast<std::size_t>(std::max(0.0, time * kFilmRate));
  paste_face(footage_.faces[frame % footage_.faces.size()], sight.angle, raw);

  const std::uint64_t mixed = noise * 0x9E3779B97F4A7C15U;
  const cv::Rect part(static_cast<int>((mixed >> 20U) % kNoiseMargin), static_cast<int>((mixed >> 40U) % kNoiseMargin),
                      kRawWidth, kRawHeight);
  cv::add(raw, noise_(part), raw, cv::noArray(), CV_8U);
}

void View::paste_face(const Face& face, double angle, cv::Mat& raw) const {
  const int size = face.pixels.cols;
  const cv::Rect whole(static_cast<int>(std::lround(raw_column(angle) - 0.5 * size)), (kRawHeight - size) / 2, size,
                       size);
  const cv::Rect seen = whole & cv::Rect(0, 0, kRawWidth, kRawHeight);
  if (seen.empty()) return;
  const cv::Rect part = seen - whole.tl();
  cv::Mat target = raw(seen);
  const cv::Mat pixels = face.pixels(part);
  const cv::Mat alpha = face.alpha(part);
  for (int y = 0; y < seen.height; ++y) {
    auto* out = target.ptr<unsigned char>(y);
    const auto* in = pixels.ptr<unsigned char>(y);
    const auto* weight = alpha.ptr<float>(y);
    for (int i = 0; i < 3 * seen.width; ++i) {
      const float blended = static_cast<float>(out[i]) + weight[i] * static_cast<float>(in[i] - out[i]);
      out[i] = static_cast<unsigned char>(blended + 0.5F);
    }
  }
}

}  // namespace ctn::face_tracking
