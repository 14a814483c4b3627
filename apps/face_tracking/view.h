// What the camera's sensor sees: the panorama behind, the face in front, and noise.
//
// Thread safety: render is const and may run in any thread; each thread brings its own picture.
#pragma once

#include <cstdint>

#include <opencv2/core.hpp>

#include "footage.h"
#include "world.h"

namespace ctn::face_tracking {

class View {
 public:
  View(Footage footage, std::uint64_t seed);

  // The raw picture at `time` (seconds), for a camera that sees the face as `sight` says. The film plays at its speed.
  // `noise` picks the sensor noise: two pictures of equal noise differ only in what is seen.
  void render(const Sight& sight, double time, std::uint64_t noise, cv::Mat& raw) const;

 private:
  void paste_face(const Face& face, double angle, cv::Mat& raw) const;

  Footage footage_;
  cv::Mat noise_;  // larger than the picture; each picture shows another part of it
};

}  // namespace ctn::face_tracking
