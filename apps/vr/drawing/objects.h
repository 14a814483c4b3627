// Programs, targets and textures of OpenGL. Private to drawing.
//
// Objects are deleted with their context, so that nothing here has a destructor. All functions want a current context.
#pragma once

#include <string>

#include <Eigen/Core>

#include "catan/result.h"
#include "drawing/gl.h"
#include "sensors.h"

namespace ctn::vr::drawing {

// Errors: kEnvironment, where a driver does not take a shader.
Result<GLuint> make_program(const Gl& gl, const std::string& vertex_shader, const std::string& fragment_shader);

struct Target {
  GLuint framebuffer = 0;
  GLuint texture = 0;  // RGBA, 8 bits, without mipmaps; filtered between pixels, clamped at its edges
  int width = 0;
  int height = 0;

  void bind(const Gl& gl) const;
  // The pixels, four bytes each; row 0 is that of the target's y = 0.
  void read(const Gl& gl, unsigned char* pixels) const;
};
Result<Target> make_target(const Gl& gl, int width, int height, bool depth);

GLuint make_texture(const Gl& gl, GLenum format, int width, int height, GLint filter);

// From the camera's frame to clip coordinates, such that row 0 of a target is the top of the picture. Only for cameras
// without distortion.
Eigen::Matrix4f projection_of(const CameraModel& camera);
// From the world's frame to that of the camera.
Eigen::Matrix4f view_of(const Pose& world_from_camera);

}  // namespace ctn::vr::drawing
