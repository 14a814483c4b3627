#include "detector/film.h"

#include <fmt/format.h>

#include <cassert>
#include <filesystem>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "program/fingerprint.h"

namespace ctn::navigation {
namespace {

constexpr int kQuality = 90;  // of JPEG, of 100

Error cannot_play(const std::string& path, bool there) {
  if (path != Film::kDebian) {
    return there ? Error::caller("cannot decode the film " + path,
                                 "give a film that OpenCV can read, such as one in an AVI or MP4 file")
                 : Error::caller("no film " + path, "give the path of a film, or none for Debian's");
  }
  const std::string install = "sudo apt-get install --reinstall opencv-doc";
  if (there) return Error::environment("cannot decode the film " + path, "is it damaged? " + install);
  if (std::filesystem::exists(path + ".gz")) {
    return Error::environment("the film " + path + " is packed (.gz)", "unpack it: sudo gunzip -k " + path + ".gz");
  }
  return Error::environment("no film " + path,
                            "it is part of the Debian package opencv-doc: " + install +
                                "; where /etc/dpkg/dpkg.cfg.d/ excludes /usr/share/doc/*, let it through first");
}

}  // namespace

Result<Film> Film::open(const std::string& path) {
  cv::setNumThreads(1);
  std::error_code unreadable;
  const bool there = std::filesystem::is_regular_file(path, unreadable);
  cv::VideoCapture source;
  if (!there || !source.open(path, cv::CAP_FFMPEG)) return cannot_play(path, there);

  Film film;
  program::Fingerprint fingerprint;
  cv::Mat frame;
  while (source.read(frame)) {
    EncodedPicture picture;
    cv::imencode(".jpg", frame, picture, {cv::IMWRITE_JPEG_QUALITY, kQuality});
    picture.shrink_to_fit();
    film.bytes_ += picture.size();
    if (film.bytes_ > kMaxBytes) {
      return Error::caller(
          fmt::format("the film {} takes more than {} MiB in memory", path, kMaxBytes >> 20U),
          fmt::format("give one that is smaller, or shorter: its first {} frames fit", film.pictures_.size()));
    }
    film.size_ = frame.size();
    fingerprint.add(picture);
    film.pictures_.push_back(std::move(picture));
  }
  if (film.pictures_.empty()) return cannot_play(path, true);
  film.fingerprint_ = fingerprint.value();
  return film;
}

std::size_t Film::frame_at(std::chrono::nanoseconds time) const {
  assert(time.count() >= 0);
  constexpr std::chrono::nanoseconds kFrame = std::chrono::nanoseconds(std::chrono::seconds(1)) / kFramesPerSecond;
  return static_cast<std::size_t>(time / kFrame) % pictures_.size();
}

}  // namespace ctn::navigation
