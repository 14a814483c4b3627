// A room whose walls, floor and ceiling are painted with random spots, and pictures of it, for tests of what needs
// pictures. Small and plain: the case study's own room is elsewhere.
//
// Units: metres, pixels. Thread safety: constant after construction.
#pragma once

#include <cstdint>

#include <opencv2/core.hpp>

#include "sensors.h"

namespace ctn::vr::testing {

class PaintedRoom {
 public:
  explicit PaintedRoom(std::uint64_t seed);

  // Grey, as a camera without distortion sees it from inside of the room; `noise`: grey levels, standard deviation.
  cv::Mat picture(const CameraModel& camera, const Pose& world_from_body, double noise, std::uint64_t noise_seed) const;

 private:
  cv::Mat paint_;  // repeated all over the walls
};

}  // namespace ctn::vr::testing
