#include "drawing/timewarp.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <string>
#include <utility>

#include "drawing/cameras.h"
#include "drawing/context.h"
#include "drawing/objects.h"

namespace ctn::vr::drawing {
namespace {

// Where the eye's pixel looks in the frame is linear in its place until it is divided by the third coordinate, so the
// corners of the target are enough.
const char* const kRotationVertexShader = R"(#version 300 es
uniform mat3 frame_from_eye;
out vec3 place;
void main() {
  vec2 at = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(at, 0.0, 1.0);
  place = frame_from_eye * vec3(at, 1.0);
}
)";
const char* const kRotationFragmentShader = R"(#version 300 es
precision highp float;
uniform sampler2D frame;
in vec3 place;
out vec4 colour;
void main() {
  vec2 at = place.xy / place.z;
  vec2 beyond = abs(at - 0.5);
  float shown = place.z > 0.0 && max(beyond.x, beyond.y) <= 0.5 ? 1.0 : 0.0;
  colour = vec4(shown * texture(frame, at).rgb, shown);
}
)";

// A vertex for each corner of a cell, in the order of strips that are drawn as triangles. `to_ray`: from a place in the
// frame to the ray there (1 / fx, 1 / fy, and what they are offset by).
// `place` is homogeneous, since it is linear in the frame, not in space.
std::string translation_vertex_shader() {
  return fmt::format(R"(#version 300 es
precision highp float;
uniform highp sampler2D frame;
uniform vec4 to_ray;
uniform mat4 eye_from_frame;
layout(location = 0) in vec2 pixel;
out vec3 place;
void main() {{
  vec2 size = vec2(textureSize(frame, 0));
  ivec2 nearest = min(ivec2(pixel), ivec2(size) - 1);
  float nearness = max(texelFetch(frame, nearest, 0).a, 0.5 / 255.0);
  float depth = {:.6f} / nearness;
  gl_Position = eye_from_frame * vec4(depth * (pixel * to_ray.xy + to_ray.zw), depth, 1.0);
  place = depth * vec3(pixel / size, 1.0);
}}
)",
                     kNearestDepth);
}
const char* const kTranslationFragmentShader = R"(#version 300 es
precision highp float;
uniform highp sampler2D frame;
in vec3 place;
out vec4 colour;
void main() { colour = vec4(texture(frame, place.xy / place.z).rgb, 1.0); }
)";

// From clip coordinates of a pinhole camera's target to rays (x, y, 1).
Eigen::Matrix3d ray_from_clip(const CameraModel& camera) {
  const double w = camera.width;
  const double h = camera.height;
  Eigen::Matrix3d matrix;
  matrix << w / 2.0 / camera.fx, 0.0, (w / 2.0 - 0.5 - camera.cx) / camera.fx,  //
      0.0, h / 2.0 / camera.fy, (h / 2.0 - 0.5 - camera.cy) / camera.fy,        //
      0.0, 0.0, 1.0;
  return matrix;
}

// From rays to places in the camera's picture, from 0 to 1.
Eigen::Matrix3d place_from_ray(const CameraModel& camera) {
  Eigen::Matrix3d matrix;
  matrix << camera.fx / camera.width, 0.0, (camera.cx + 0.5) / camera.width,  //
      0.0, camera.fy / camera.height, (camera.cy + 0.5) / camera.height,      //
      0.0, 0.0, 1.0;
  return matrix;
}

}  // namespace

struct Timewarp::Parts {
  std::unique_ptr<Context> context;
  CameraModel eye;
  CameraModel frames;
  Warp warp = Warp::kRotational;
  Target target;
  GLuint program = 0;
  GLuint texture = 0;   // the frame
  GLint uniform = 0;    // the matrix
  GLuint vertices = 0;  // the mesh; for rotations there is none
  GLsizei indices = 0;
  Pose world_from_frame;
  bool taken = false;

  void make_mesh(const Gl& gl);
};

void Timewarp::Parts::make_mesh(const Gl& gl) {
  const int columns = (frames.width + kCell - 1) / kCell;
  const int rows = (frames.height + kCell - 1) / kCell;
  std::vector<float> corners;
  std::vector<GLuint> order;
  const auto corner = [&](int column, int row) { return static_cast<GLuint>(row * (columns + 1) + column); };
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column) {
      corners.push_back(static_cast<float>(std::min(column * kCell, frames.width)));
      corners.push_back(static_cast<float>(std::min(row * kCell, frames.height)));
      if (row == rows || column == columns) continue;
      const GLuint a = corner(column, row);
      const GLuint b = corner(column + 1, row);
      const GLuint c = corner(column, row + 1);
      order.insert(order.end(), {a, b, c, c, b, corner(column + 1, row + 1)});
    }
  }
  indices = static_cast<GLsizei>(order.size());
  gl.GenVertexArrays(1, &vertices);
  gl.BindVertexArray(vertices);
  GLuint buffer = 0;
  gl.GenBuffers(1, &buffer);
  gl.BindBuffer(GL_ARRAY_BUFFER, buffer);
  gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(float)), corners.data(),
                GL_STATIC_DRAW);
  gl.GenBuffers(1, &buffer);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(order.size() * sizeof(GLuint)), order.data(),
                GL_STATIC_DRAW);
  gl.EnableVertexAttribArray(0);
  gl.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
}

Timewarp::Timewarp(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Timewarp::~Timewarp() = default;

Result<std::unique_ptr<Timewarp>> Timewarp::open(const CameraModel& eye, const CameraModel& frames, Warp warp,
                                                 Screen screen) {
  for (const CameraModel& camera : {eye, frames}) {
    if (const Status size = check_size(camera); !size) return size.error();
  }
  Result<std::unique_ptr<Context>> context = Context::open(screen);
  if (!context) return context.error();
  const Context::Current current(**context);
  const Gl& gl = (*context)->gl();
  auto parts = std::make_unique<Parts>();
  parts->eye = eye;
  parts->frames = frames;
  parts->warp = warp;
  const bool rotational = warp == Warp::kRotational;
  const Result<Target> target = make_target(gl, eye.width, eye.height, !rotational);
  if (!target) return target.error();
  parts->target = *target;
  const Result<GLuint> program = rotational ? make_program(gl, kRotationVertexShader, kRotationFragmentShader)
                                            : make_program(gl, translation_vertex_shader(), kTranslationFragmentShader);
  if (!program) return program.error();
  parts->program = *program;
  parts->uniform = gl.GetUniformLocation(*program, rotational ? "frame_from_eye" : "eye_from_frame");
  gl.UseProgram(*program);
  gl.Uniform1i(gl.GetUniformLocation(*program, "frame"), 0);
  if (!rotational) {
    // Corners of cells are corners of pixels, half a pixel from their centres.
    gl.Uniform4f(gl.GetUniformLocation(*program, "to_ray"), static_cast<float>(1.0 / frames.fx),
                 static_cast<float>(1.0 / frames.fy), static_cast<float>(-(frames.cx + 0.5) / frames.fx),
                 static_cast<float>(-(frames.cy + 0.5) / frames.fy));
    parts->make_mesh(gl);
  }
  parts->texture = make_texture(gl, GL_RGBA8, frames.width, frames.height, GL_LINEAR);
  parts->context = std::move(*context);
  return std::unique_ptr<Timewarp>(new Timewarp(std::move(parts)));
}

void Timewarp::take(const Frame& frame) {
  assert(frame.camera.width == parts_->frames.width && frame.camera.height == parts_->frames.height);
  const Context::Current current(*parts_->context);
  const Gl& gl = parts_->context->gl();
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D, parts_->texture);
  gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, frame.camera.width, frame.camera.height, GL_RGBA, GL_UNSIGNED_BYTE,
                   frame.pixels.data());
  parts_->world_from_frame = frame.world_from_camera;
  parts_->taken = true;
}

void Timewarp::warp(const Pose& world_from_eye) {
  assert(parts_->taken);
  const Context::Current current(*parts_->context);
  const Gl& gl = parts_->context->gl();
  parts_->target.bind(gl);
  gl.UseProgram(parts_->program);
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D, parts_->texture);
  if (parts_->warp == Warp::kRotational) {
    const Eigen::Matrix3d turn =
        (parts_->world_from_frame.orientation.conjugate() * world_from_eye.orientation).toRotationMatrix();
    const Eigen::Matrix3f matrix = (place_from_ray(parts_->frames) * turn * ray_from_clip(parts_->eye)).cast<float>();
    gl.UniformMatrix3fv(parts_->uniform, 1, GL_FALSE, matrix.data());
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
  } else {
    gl.Enable(GL_DEPTH_TEST);
    gl.ClearColor(0.0F, 0.0F, 0.0F, 0.0F);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    const Pose eye_from_frame = transformed(inverse(world_from_eye), parts_->world_from_frame);
    Eigen::Matrix4d placed = Eigen::Matrix4d::Identity();
    placed.topLeftCorner<3, 3>() = eye_from_frame.orientation.toRotationMatrix();
    placed.topRightCorner<3, 1>() = eye_from_frame.position;
    const Eigen::Matrix4f matrix = (projection_of(parts_->eye).cast<double>() * placed).cast<float>();
    gl.UniformMatrix4fv(parts_->uniform, 1, GL_FALSE, matrix.data());
    gl.BindVertexArray(parts_->vertices);
    gl.DrawElements(GL_TRIANGLES, parts_->indices, GL_UNSIGNED_INT, nullptr);
  }
  gl.Finish();
}

void Timewarp::read(std::vector<std::uint8_t>& pixels) {
  const Context::Current current(*parts_->context);
  pixels.resize(std::size_t{4} * static_cast<std::size_t>(parts_->eye.width) *
                static_cast<std::size_t>(parts_->eye.height));
  parts_->target.read(parts_->context->gl(), pixels.data());
}

}  // namespace ctn::vr::drawing
