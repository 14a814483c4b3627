#include "run/album.h"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <system_error>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "run/drawing_parts.h"

namespace ctn::vr::run {
namespace {

cv::Mat picture_of(std::vector<std::uint8_t>& pixels, const CameraModel& camera) {
  cv::Mat picture;
  cv::cvtColor(cv::Mat(camera.height, camera.width, CV_8UC4, pixels.data()), picture, cv::COLOR_RGBA2BGR);
  return picture;
}

}  // namespace

Status draw_album(const Options& options, const Surroundings& surroundings, const std::vector<Photon>& photons,
                  const std::function<bool()>& ends) {
  std::error_code error;
  std::filesystem::create_directories(options.pictures, error);
  if (error) {
    return Error::environment("the folder " + options.pictures + " cannot be made", "name another with --pictures");
  }
  auto parts = DrawingParts::open(surroundings, options);
  if (!parts) return parts.error();
  auto truth_view = drawing::EyeView::open(surroundings.room(), surroundings.eye(), drawing::Screen::kFirst);
  if (!truth_view) return truth_view.error();
  std::chrono::seconds next(0);
  for (const Photon& photon : photons) {
    if (photon.tick < next) continue;
    if (ends()) break;
    const auto second = std::chrono::floor<std::chrono::seconds>(photon.tick);
    next = second + std::chrono::seconds(1);
    drawing::Frame frame;
    parts->render->draw(photon.picture.drawn, frame);
    parts->timewarp->take(frame);
    parts->timewarp->warp(photon.picture.warped);
    std::vector<std::uint8_t> pixels;
    parts->timewarp->read(pixels);
    cv::Mat both = picture_of(pixels, surroundings.eye());
    if (const auto truth = surroundings.true_eye(photon.tick)) {
      drawing::Frame true_frame;
      (*truth_view)->draw(*truth, true_frame);
      cv::hconcat(both, picture_of(true_frame.pixels, surroundings.eye()), both);
    }
    const auto path =
        std::filesystem::path(options.pictures) / fmt::format("second-{:04}.png", static_cast<int>(second.count()));
    if (!cv::imwrite(path.string(), both)) {
      return Error::environment(path.string() + " cannot be written", "name another folder with --pictures");
    }
  }
  return Done{};
}

}  // namespace ctn::vr::run
