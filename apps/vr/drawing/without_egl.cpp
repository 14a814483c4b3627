// What stands in for drawing where Catan was built without the headers of EGL.
#include "drawing/timewarp.h"
#include "drawing/views.h"

namespace ctn::vr::drawing {
namespace {

Error built_without() {
  return Error::environment(
      "this program was built without EGL, so it cannot draw",
      "sudo apt-get install libegl-dev libgles-dev libegl-mesa0 libgl1-mesa-dri, and build it again");
}

}  // namespace

struct EyeView::Parts {};
EyeView::~EyeView() = default;
Result<std::unique_ptr<EyeView>> EyeView::open(const world::Room&, const CameraModel&, Screen) {
  return built_without();
}
void EyeView::draw(const Pose&, Frame&) {}
const std::string& EyeView::renderer() const {
  static const std::string kNone;
  return kNone;
}

struct CameraView::Parts {};
CameraView::~CameraView() = default;
Result<std::unique_ptr<CameraView>> CameraView::open(const world::Room&, const CameraModel&, Screen) {
  return built_without();
}
void CameraView::draw(const Pose&, std::vector<std::uint8_t>&) {}

struct Timewarp::Parts {};
Timewarp::~Timewarp() = default;
Result<std::unique_ptr<Timewarp>> Timewarp::open(const CameraModel&, const CameraModel&, Warp, Screen) {
  return built_without();
}
void Timewarp::take(const Frame&) {}
void Timewarp::warp(const Pose&) {}
void Timewarp::read(std::vector<std::uint8_t>&) {}

}  // namespace ctn::vr::drawing
