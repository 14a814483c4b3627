// What the wearer's eye and the headset's camera see of the room: the work of Render, and the pictures of the camera.
//
// Thread safety: one thread at a time, any one. See screen.h about threads of different priorities. open() is for
// one thread at a time, before other threads read the environment.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "catan/result.h"
#include "drawing/frame.h"
#include "drawing/screen.h"
#include "sensors.h"
#include "world/room.h"

namespace ctn::vr::drawing {

// Errors of all open(): kCaller, for pictures that cannot be drawn; kEnvironment, where nothing can be drawn here, with
// the packages to install.

class EyeView {
 public:
  // `camera`: without distortion.
  static Result<std::unique_ptr<EyeView>> open(const world::Room& room, const CameraModel& camera, Screen screen);
  ~EyeView();

  // Returns when the frame has been drawn and read back.
  void draw(const Pose& world_from_camera, Frame& frame);
  const std::string& renderer() const;  // as the driver names itself

 private:
  struct Parts;
  explicit EyeView(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

// Pictures as the camera takes them: grey, and distorted by its lens.
class CameraView {
 public:
  static Result<std::unique_ptr<CameraView>> open(const world::Room& room, const CameraModel& camera, Screen screen);
  ~CameraView();

  // Row by row from the top, one byte a pixel.
  void draw(const Pose& world_from_body, std::vector<std::uint8_t>& picture);

 private:
  struct Parts;
  explicit CameraView(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace ctn::vr::drawing
