#include "drawing/room_drawing.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "drawing/frame.h"

namespace ctn::vr::drawing {
namespace {

const char* const kRoomVertexShader = R"(#version 300 es
uniform mat4 view;
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 on_texture;
layout(location = 2) in float light;
out vec3 place;
out float shade;
void main() {
  gl_Position = view * vec4(position, 1.0);
  place = on_texture;
  shade = light;
}
)";

// What is left of the division by depth is its inverse.
std::string room_fragment_shader() {
  return fmt::format(R"(#version 300 es
precision highp float;
precision highp sampler2DArray;
uniform sampler2DArray surfaces;
in vec3 place;
in float shade;
out vec4 colour;
void main() {{
  colour = vec4(shade * texture(surfaces, place).rgb, {:.6f} * gl_FragCoord.w);
}}
)",
                     kNearestDepth);
}

struct Vertex {
  std::array<float, 3> position;
  std::array<float, 3> on_texture;  // and the number of the texture
  float light;
};

GLuint upload(const Gl& gl, const std::vector<world::Texture>& textures) {
  constexpr int kSide = world::Texture::kSide;
  constexpr int kLevels = 9;  // down to one pixel
  static_assert(1 << (kLevels - 1) == kSide);
  GLuint texture = 0;
  gl.GenTextures(1, &texture);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, texture);
  gl.TexStorage3D(GL_TEXTURE_2D_ARRAY, kLevels, GL_RGBA8, kSide, kSide, static_cast<GLsizei>(textures.size()));
  std::vector<std::uint8_t> pixels(std::size_t{4} * kSide * kSide, 255);
  for (std::size_t i = 0; i < textures.size(); ++i) {
    for (std::size_t pixel = 0; pixel < std::size_t{kSide} * kSide; ++pixel) {
      for (std::size_t j = 0; j < 3; ++j) pixels[4 * pixel + j] = textures[i].rgb[3 * pixel + j];
    }
    gl.TexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, static_cast<GLint>(i), kSide, kSide, 1, GL_RGBA, GL_UNSIGNED_BYTE,
                     pixels.data());
  }
  gl.GenerateMipmap(GL_TEXTURE_2D_ARRAY);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

}  // namespace

Result<RoomDrawing> RoomDrawing::make(const Gl& gl, const world::Room& room, const CameraModel& camera) {
  RoomDrawing drawing;
  drawing.camera_ = camera;
  const Result<Target> target = make_target(gl, camera.width, camera.height, true);
  if (!target) return target.error();
  drawing.target_ = *target;
  const Result<GLuint> program = make_program(gl, kRoomVertexShader, room_fragment_shader());
  if (!program) return program.error();
  drawing.program_ = *program;
  drawing.view_ = gl.GetUniformLocation(*program, "view");
  drawing.textures_ = upload(gl, room.textures());

  std::vector<Vertex> vertices;
  std::vector<std::uint16_t> indices;
  for (const world::Rectangle& rectangle : room.rectangles()) {
    const auto first = static_cast<unsigned>(vertices.size());
    for (const unsigned corner : {0U, 1U, 2U, 3U}) {
      const auto s = static_cast<float>(corner & 1U);
      const auto t = static_cast<float>(corner >> 1U);
      const Eigen::Vector3f at = rectangle.origin + s * rectangle.right + t * rectangle.down;
      vertices.push_back({{at.x(), at.y(), at.z()},
                          {s * rectangle.repeats.x(), t * rectangle.repeats.y(), static_cast<float>(rectangle.texture)},
                          rectangle.shade});
    }
    for (const unsigned corner : {0U, 1U, 2U, 2U, 1U, 3U}) {
      indices.push_back(static_cast<std::uint16_t>(first + corner));
    }
  }
  drawing.indices_ = static_cast<GLsizei>(indices.size());
  gl.GenVertexArrays(1, &drawing.vertices_);
  gl.BindVertexArray(drawing.vertices_);
  std::array<GLuint, 2> buffers{};
  gl.GenBuffers(2, buffers.data());
  gl.BindBuffer(GL_ARRAY_BUFFER, buffers[0]);
  gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)), vertices.data(),
                GL_STATIC_DRAW);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof(std::uint16_t)),
                indices.data(), GL_STATIC_DRAW);
  const auto attribute = [&](GLuint location, GLint size, std::size_t offset) {
    gl.EnableVertexAttribArray(location);
    gl.VertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, sizeof(Vertex), reinterpret_cast<const void*>(offset));
  };
  attribute(0, 3, offsetof(Vertex, position));
  attribute(1, 3, offsetof(Vertex, on_texture));
  attribute(2, 1, offsetof(Vertex, light));
  return drawing;
}

void RoomDrawing::draw(const Gl& gl, const Pose& world_from_camera) const {
  target_.bind(gl);
  gl.Enable(GL_DEPTH_TEST);
  gl.Enable(GL_CULL_FACE);  // the fronts of all rectangles face the room
  gl.ClearColor(0.0F, 0.0F, 0.0F, 0.0F);
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  gl.UseProgram(program_);
  const Eigen::Matrix4f view = projection_of(camera_) * view_of(world_from_camera);
  gl.UniformMatrix4fv(view_, 1, GL_FALSE, view.data());
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, textures_);
  gl.BindVertexArray(vertices_);
  gl.DrawElements(GL_TRIANGLES, indices_, GL_UNSIGNED_SHORT, nullptr);
}

}  // namespace ctn::vr::drawing
