#include "vio/testing/painted_room.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace ctn::vr::testing {
namespace {

constexpr int kPaintSide = 1024;
constexpr float kPixelsInMetre = 120.0F;
const Eigen::Array3f kLow(-3.0F, -2.5F, 0.0F);
const Eigen::Array3f kHigh(3.0F, 2.5F, 2.6F);

}  // namespace

PaintedRoom::PaintedRoom(std::uint64_t seed) : paint_(kPaintSide, kPaintSide, CV_8UC1, cv::Scalar(128)) {
  cv::RNG random(seed);
  for (int i = 0; i < 2500; ++i) {
    const cv::Point centre(random.uniform(0, kPaintSide), random.uniform(0, kPaintSide));
    const cv::Size size(random.uniform(3, 22), random.uniform(3, 22));
    cv::rectangle(paint_, cv::Rect(centre, size), cv::Scalar(random.uniform(20, 236)), cv::FILLED);
  }
  cv::GaussianBlur(paint_, paint_, cv::Size(0, 0), 1.2);
}

cv::Mat PaintedRoom::picture(const CameraModel& camera, const Pose& world_from_body, double noise,
                             std::uint64_t noise_seed) const {
  const Pose world_from_camera = transformed(world_from_body, camera.body_from_camera);
  const Eigen::Matrix3f rotation = world_from_camera.orientation.toRotationMatrix().cast<float>();
  const Eigen::Array3f origin = world_from_camera.position.cast<float>().array();
  cv::Mat map(camera.height, camera.width, CV_32FC2);
  for (int y = 0; y < camera.height; ++y) {
    auto* const row = map.ptr<cv::Vec2f>(y);
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3f in_camera(static_cast<float>((x - camera.cx) / camera.fx),
                                      static_cast<float>((y - camera.cy) / camera.fy), 1.0F);
      const Eigen::Array3f direction = (rotation * in_camera).array();
      int wall = 0;
      float nearest = std::numeric_limits<float>::max();
      for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(direction[axis]) < 1e-9F) continue;
        const float distance = ((direction[axis] > 0.0F ? kHigh : kLow)[axis] - origin[axis]) / direction[axis];
        if (distance >= nearest) continue;
        nearest = distance;
        wall = axis;
      }
      const Eigen::Array3f point = origin + nearest * direction;
      // Another piece of the paint for each wall.
      const float offset = 217.0F * static_cast<float>(2 * wall + (direction[wall] > 0.0F ? 1 : 0));
      const auto on_paint = [&](float metres) {
        const float at = std::fmod(kPixelsInMetre * (metres + 10.0F) + offset, static_cast<float>(kPaintSide - 1));
        return std::clamp(at, 0.0F, static_cast<float>(kPaintSide - 2));
      };
      row[x] = {on_paint(point[(wall + 1) % 3]), on_paint(point[(wall + 2) % 3])};
    }
  }
  cv::Mat picture;
  cv::remap(paint_, picture, map, cv::noArray(), cv::INTER_LINEAR);
  if (noise > 0.0) {
    cv::RNG random(noise_seed);
    cv::Mat grain(picture.size(), CV_16SC1);
    random.fill(grain, cv::RNG::NORMAL, 0.0, noise);
    cv::Mat sum;
    cv::add(picture, grain, sum, cv::noArray(), CV_16SC1);
    sum.convertTo(picture, CV_8UC1);
  }
  return picture;
}

}  // namespace ctn::vr::testing
