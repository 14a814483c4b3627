#include "drawing/objects.h"

#include <fmt/format.h>

#include <array>

#include <Eigen/Geometry>

namespace ctn::vr::drawing {
namespace {

// Between these depths, in metres, something is drawn.
constexpr double kNearPlane = 0.05;
constexpr double kFarPlane = 40.0;

Result<GLuint> make_shader(const Gl& gl, GLenum kind, const std::string& source) {
  const GLuint shader = gl.CreateShader(kind);
  const char* text = source.c_str();
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  GLint compiled = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled != 0) return shader;
  std::array<char, 1000> log{};
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  return Error::environment(fmt::format("the driver of OpenGL cannot compile a shader: {}", log.data()),
                            "use Mesa's: sudo apt-get install libegl-mesa0 libgl1-mesa-dri");
}

}  // namespace

Result<GLuint> make_program(const Gl& gl, const std::string& vertex_shader, const std::string& fragment_shader) {
  const Result<GLuint> vertex = make_shader(gl, GL_VERTEX_SHADER, vertex_shader);
  if (!vertex) return vertex.error();
  const Result<GLuint> fragment = make_shader(gl, GL_FRAGMENT_SHADER, fragment_shader);
  if (!fragment) return fragment.error();
  const GLuint program = gl.CreateProgram();
  gl.AttachShader(program, *vertex);
  gl.AttachShader(program, *fragment);
  gl.LinkProgram(program);
  gl.DeleteShader(*vertex);
  gl.DeleteShader(*fragment);
  GLint linked = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked != 0) return program;
  std::array<char, 1000> log{};
  gl.GetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
  return Error::environment(fmt::format("the driver of OpenGL cannot link a program: {}", log.data()),
                            "use Mesa's: sudo apt-get install libegl-mesa0 libgl1-mesa-dri");
}

void Target::bind(const Gl& gl) const {
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  gl.Viewport(0, 0, width, height);
}

void Target::read(const Gl& gl, unsigned char* pixels) const {
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
}

GLuint make_texture(const Gl& gl, GLenum format, int width, int height, GLint filter) {
  GLuint texture = 0;
  gl.GenTextures(1, &texture);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.TexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

Result<Target> make_target(const Gl& gl, int width, int height, bool depth) {
  Target target;
  target.width = width;
  target.height = height;
  target.texture = make_texture(gl, GL_RGBA8, width, height, GL_LINEAR);
  gl.GenFramebuffers(1, &target.framebuffer);
  gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.texture, 0);
  if (depth) {
    GLuint buffer = 0;
    gl.GenRenderbuffers(1, &buffer);
    gl.BindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, buffer);
  }
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return target;
  return Error::environment(fmt::format("the driver of OpenGL cannot draw into {} x {} pixels", width, height),
                            "use smaller pictures, or Mesa's driver: sudo apt-get install libgl1-mesa-dri");
}

Eigen::Matrix4f projection_of(const CameraModel& camera) {
  // A pixel's centre is half a pixel from its border, where the target counts from.
  const double w = camera.width;
  const double h = camera.height;
  const double n = kNearPlane;
  const double f = kFarPlane;
  Eigen::Matrix4d projection;
  projection << 2.0 * camera.fx / w, 0.0, 2.0 * (camera.cx + 0.5) / w - 1.0, 0.0,  //
      0.0, 2.0 * camera.fy / h, 2.0 * (camera.cy + 0.5) / h - 1.0, 0.0,            //
      0.0, 0.0, (f + n) / (f - n), -2.0 * f * n / (f - n),                         //
      0.0, 0.0, 1.0, 0.0;
  return projection.cast<float>();
}

Eigen::Matrix4f view_of(const Pose& world_from_camera) {
  const Pose camera_from_world = inverse(world_from_camera);
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  view.topLeftCorner<3, 3>() = camera_from_world.orientation.toRotationMatrix();
  view.topRightCorner<3, 1>() = camera_from_world.position;
  return view.cast<float>();
}

}  // namespace ctn::vr::drawing
