#include "drawing/views.h"

#include <cstddef>
#include <utility>

#include "drawing/cameras.h"
#include "drawing/context.h"
#include "drawing/objects.h"
#include "drawing/room_drawing.h"
#include "lens.h"

namespace ctn::vr::drawing {
namespace {

std::size_t pixels_of(const CameraModel& camera) {
  return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
}

const char* const kWholeTarget = R"(#version 300 es
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)";

// Through the lens: where a pixel of the picture looks in one that was drawn without distortion.
const char* const kLensShader = R"(#version 300 es
precision highp float;
uniform sampler2D drawn;
uniform highp sampler2D rays;
out vec4 colour;
void main() {
  vec2 at = texelFetch(rays, ivec2(gl_FragCoord.xy), 0).xy;
  float grey = dot(texture(drawn, at).rgb, vec3(0.299, 0.587, 0.114));
  colour = vec4(grey, grey, grey, 1.0);
}
)";

}  // namespace

struct EyeView::Parts {
  std::unique_ptr<Context> context;
  CameraModel camera;
  RoomDrawing room;
};

EyeView::EyeView(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
EyeView::~EyeView() = default;

Result<std::unique_ptr<EyeView>> EyeView::open(const world::Room& room, const CameraModel& camera, Screen screen) {
  if (const Status size = check_size(camera); !size) return size.error();
  if (has_distortion(camera)) {
    return Error::caller("an eye's picture cannot be distorted", "leave k1, k2, p1 and p2 of its camera at 0");
  }
  Result<std::unique_ptr<Context>> context = Context::open(screen);
  if (!context) return context.error();
  const Context::Current current(**context);
  Result<RoomDrawing> drawing = RoomDrawing::make((*context)->gl(), room, camera);
  if (!drawing) return drawing.error();
  auto parts = std::make_unique<Parts>(Parts{std::move(*context), camera, *drawing});
  return std::unique_ptr<EyeView>(new EyeView(std::move(parts)));
}

void EyeView::draw(const Pose& world_from_camera, Frame& frame) {
  const Context::Current current(*parts_->context);
  const Gl& gl = parts_->context->gl();
  parts_->room.draw(gl, world_from_camera);
  frame.camera = parts_->camera;
  frame.world_from_camera = world_from_camera;
  frame.pixels.resize(4 * pixels_of(parts_->camera));
  parts_->room.target().read(gl, frame.pixels.data());
}

const std::string& EyeView::renderer() const { return parts_->context->renderer(); }

struct CameraView::Parts {
  std::unique_ptr<Context> context;
  CameraModel camera;
  RoomDrawing room;
  Target target;
  GLuint program = 0;
  GLuint rays = 0;
  std::vector<std::uint8_t> pixels;
};

CameraView::CameraView(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
CameraView::~CameraView() = default;

Result<std::unique_ptr<CameraView>> CameraView::open(const world::Room& room, const CameraModel& camera,
                                                     Screen screen) {
  if (const Status size = check_size(camera); !size) return size.error();
  const Result<CameraModel> drawn = covering(camera);
  if (!drawn) return drawn.error();
  Result<std::unique_ptr<Context>> context = Context::open(screen);
  if (!context) return context.error();
  const Context::Current current(**context);
  const Gl& gl = (*context)->gl();
  Result<RoomDrawing> drawing = RoomDrawing::make(gl, room, *drawn);
  if (!drawing) return drawing.error();
  const Result<Target> target = make_target(gl, camera.width, camera.height, false);
  if (!target) return target.error();
  const Result<GLuint> program = make_program(gl, kWholeTarget, kLensShader);
  if (!program) return program.error();

  std::vector<float> rays;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector2d plane = undistorted(camera, {x, y});
      rays.push_back(static_cast<float>((drawn->fx * plane.x() + drawn->cx + 0.5) / drawn->width));
      rays.push_back(static_cast<float>((drawn->fy * plane.y() + drawn->cy + 0.5) / drawn->height));
    }
  }
  const GLuint texture = make_texture(gl, GL_RG32F, camera.width, camera.height, GL_NEAREST);
  gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, camera.width, camera.height, GL_RG, GL_FLOAT, rays.data());
  gl.UseProgram(*program);
  gl.Uniform1i(gl.GetUniformLocation(*program, "drawn"), 0);
  gl.Uniform1i(gl.GetUniformLocation(*program, "rays"), 1);
  auto parts = std::make_unique<Parts>(Parts{std::move(*context), camera, *drawing, *target, *program, texture, {}});
  return std::unique_ptr<CameraView>(new CameraView(std::move(parts)));
}

void CameraView::draw(const Pose& world_from_body, std::vector<std::uint8_t>& picture) {
  const Context::Current current(*parts_->context);
  const Gl& gl = parts_->context->gl();
  parts_->room.draw(gl, transformed(world_from_body, parts_->camera.body_from_camera));
  parts_->target.bind(gl);
  gl.Disable(GL_DEPTH_TEST);
  gl.UseProgram(parts_->program);
  gl.ActiveTexture(GL_TEXTURE0 + 1);
  gl.BindTexture(GL_TEXTURE_2D, parts_->rays);
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D, parts_->room.target().texture);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  const std::size_t pixels = pixels_of(parts_->camera);
  parts_->pixels.resize(4 * pixels);
  parts_->target.read(gl, parts_->pixels.data());
  picture.resize(pixels);
  for (std::size_t i = 0; i < pixels; ++i) picture[i] = parts_->pixels[4 * i];
}

}  // namespace ctn::vr::drawing
