// The work of Timewarp: a frame that was drawn at one pose is shown as it would be seen at another, newer one.
//
// Rotational: each pixel of the eye's picture takes what the frame has along its ray, by the homography
// K_frame R_frame^T R_eye K_eye^-1; exact where only the orientation differs. Translational: the frame's depths make it
// a mesh of cells of kCell pixels, which is drawn from the new pose; exact in planes, stretched across their edges.
//
// Thread safety: one thread at a time, any one. See screen.h about threads of different priorities. open() is for
// one thread at a time, before other threads read the environment.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "catan/result.h"
#include "drawing/frame.h"
#include "drawing/screen.h"
#include "sensors.h"

namespace ctn::vr::drawing {

enum class Warp { kRotational, kTranslational };

class Timewarp {
 public:
  static constexpr int kCell = 8;

  // `eye`: what is to be shown; `frames`: the camera of all frames; both without distortion.
  static Result<std::unique_ptr<Timewarp>> open(const CameraModel& eye, const CameraModel& frames, Warp warp,
                                                Screen screen);
  ~Timewarp();

  // The frame that is warped from now on.
  void take(const Frame& frame);
  // Returns when the picture is complete. Precondition: a frame was taken.
  void warp(const Pose& world_from_eye);
  // The picture that was made last: red, green, blue, and 255 where the frame had something to show (black elsewhere),
  // row by row from the top.
  void read(std::vector<std::uint8_t>& pixels);

 private:
  struct Parts;
  explicit Timewarp(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace ctn::vr::drawing
