// What Render and Timewarp draw with, each on a screen of its own, so that neither waits for the other's picture
// (drawing/screen.h).
//
// Thread safety: open() before any other thread; then one thread for each of the two.
#pragma once

#include <memory>
#include <utility>

#include "catan/result.h"
#include "drawing/timewarp.h"
#include "drawing/views.h"
#include "run/options.h"
#include "run/surroundings.h"

namespace ctn::vr::run {

struct DrawingParts {
  std::unique_ptr<drawing::EyeView> render;
  std::unique_ptr<drawing::Timewarp> timewarp;

  // Errors: as EyeView::open().
  static Result<DrawingParts> open(const Surroundings& surroundings, const Options& options) {
    DrawingParts parts;
    auto render = drawing::EyeView::open(surroundings.room(), surroundings.frames(), drawing::Screen::kFirst);
    if (!render) return render.error();
    auto timewarp = drawing::Timewarp::open(
        surroundings.eye(), surroundings.frames(),
        options.translational ? drawing::Warp::kTranslational : drawing::Warp::kRotational, drawing::Screen::kSecond);
    if (!timewarp) return timewarp.error();
    parts.render = std::move(render).value();
    parts.timewarp = std::move(timewarp).value();
    return parts;
  }
};

}  // namespace ctn::vr::run
