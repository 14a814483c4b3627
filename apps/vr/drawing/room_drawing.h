// Draws the room (world/room.h) into a target of its own. Private to drawing.
//
// Thread safety: one thread at a time, with the context that it was made with current.
#pragma once

#include "catan/result.h"
#include "drawing/gl.h"
#include "drawing/objects.h"
#include "sensors.h"
#include "world/room.h"

namespace ctn::vr::drawing {

class RoomDrawing {
 public:
  // `camera`: without distortion.
  static Result<RoomDrawing> make(const Gl& gl, const world::Room& room, const CameraModel& camera);

  void draw(const Gl& gl, const Pose& world_from_camera) const;
  const Target& target() const { return target_; }

 private:
  CameraModel camera_;
  Target target_;
  GLuint program_ = 0;
  GLuint vertices_ = 0;  // the vertex array
  GLuint textures_ = 0;
  GLsizei indices_ = 0;
  GLint view_ = 0;
};

}  // namespace ctn::vr::drawing
