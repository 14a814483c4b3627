// A context for drawing with OpenGL ES 3, without a window: EGL on Mesa's surfaceless platform. Private to drawing.
//
// EGL is loaded while the program runs; where it is missing, open() says which packages to install.
//
// With Mesa's software renderer (llvmpipe) what is drawn costs CPU time of the thread that draws: open() sets
// LP_NUM_THREADS=0 in the environment before Mesa is loaded, since llvmpipe has a pool of threads otherwise, which no
// scheduler knows of.
//
// Thread safety: open() for one thread at a time, before other threads read the environment; a context for one thread
// at a time, any one.
#pragma once

#include <memory>
#include <string>

#include "catan/result.h"
#include "drawing/gl.h"
#include "drawing/screen.h"

namespace ctn::vr::drawing {

class Context {
 public:
  // Errors: kEnvironment.
  static Result<std::unique_ptr<Context>> open(Screen screen);
  // The same with another library than libEGL.so.1.
  static Result<std::unique_ptr<Context>> open(Screen screen, const std::string& library);

  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ~Context();

  // While one is there, the calling thread draws with the context.
  class Current {
   public:
    explicit Current(const Context& context);
    ~Current();
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;

   private:
    const Context& context_;
  };

  const Gl& gl() const { return gl_; }
  // Whether the two may wait for each other.
  bool shares_screen_with(const Context& other) const { return display_ == other.display_; }
  const std::string& renderer() const { return renderer_; }  // as the driver names itself

 private:
  struct Egl;
  Context() = default;

  std::shared_ptr<const Egl> egl_;
  void* display_ = nullptr;
  void* context_ = nullptr;
  Gl gl_;
  std::string renderer_;
};

}  // namespace ctn::vr::drawing
