// The pictures that the robot's camera takes: a film that is played over and over, ten frames a second.
//
// The film is decoded once, when it is opened, and kept as JPEG pictures, as a USB camera would send them: that of
// Debian's opencv-doc, 795 frames of 768 x 576, takes 87 MB so (1 GB as pixels) and about 1.5 s to open. Which frame is
// seen follows from the time alone, so a run at a time always sees the same picture.
//
// Units: nanoseconds since the robot started, pixels. Thread safety: constant once open; share it as you like. To open
// it, FFmpeg starts threads of its own, which have ended when open() returns.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "catan/result.h"

namespace ctn::navigation {

using EncodedPicture = std::vector<unsigned char>;

class Film {
 public:
  static constexpr const char* kDebian = "/usr/share/doc/opencv-doc/examples/data/vtest.avi";
  static constexpr int kFramesPerSecond = 10;
  static constexpr std::size_t kMaxBytes = std::size_t{512} << 20U;

  // Errors: there is no such file, it cannot be decoded, or it takes more than kMaxBytes. For Debian's film
  // (kEnvironment) the error says which package to install; another one was the caller's choice (kCaller).
  static Result<Film> open(const std::string& path = kDebian);

  std::size_t frames() const { return pictures_.size(); }  // one at least
  cv::Size size() const { return size_; }
  std::size_t bytes() const { return bytes_; }

  // Changes with the film's contents, and with nothing else.
  std::uint64_t fingerprint() const { return fingerprint_; }

  // Precondition: time >= 0.
  std::size_t frame_at(std::chrono::nanoseconds time) const;

  // Precondition: frame < frames().
  const EncodedPicture& picture(std::size_t frame) const { return pictures_[frame]; }

 private:
  Film() = default;

  std::vector<EncodedPicture> pictures_;
  cv::Size size_;
  std::size_t bytes_ = 0;
  std::uint64_t fingerprint_ = 0;
};

}  // namespace ctn::navigation
