#include "drawing/context.h"

#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

namespace ctn::vr::drawing {

struct Context::Egl {
  PFNEGLGETPROCADDRESSPROC get_proc_address = nullptr;
  PFNEGLGETERRORPROC get_error = nullptr;
  PFNEGLQUERYSTRINGPROC query_string = nullptr;
  PFNEGLGETPLATFORMDISPLAYPROC get_platform_display = nullptr;
  PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;  // may be missing
  PFNEGLINITIALIZEPROC initialize = nullptr;
  PFNEGLBINDAPIPROC bind_api = nullptr;
  PFNEGLCHOOSECONFIGPROC choose_config = nullptr;
  PFNEGLCREATECONTEXTPROC create_context = nullptr;
  PFNEGLDESTROYCONTEXTPROC destroy_context = nullptr;
  PFNEGLMAKECURRENTPROC make_current = nullptr;

  template <class Function>
  bool find(const char* name, Function& function) const {
    function = reinterpret_cast<Function>(get_proc_address(name));
    return function != nullptr;
  }
};

namespace {

const char* const kPackages = "install Mesa: sudo apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri";

Error cannot_draw(const std::string& what) {
  return Error::environment("cannot draw without a window: " + what, kPackages);
}

bool has_extension(const char* list, std::string_view name) {
  std::string_view rest = list != nullptr ? list : "";
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == name) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

}  // namespace

Result<std::unique_ptr<Context>> Context::open(Screen screen) { return open(screen, "libEGL.so.1"); }

Result<std::unique_ptr<Context>> Context::open(Screen screen, const std::string& library) {
  // Read when Mesa is loaded. The cache of compiled shaders would write to the user's home.
  ::setenv("LP_NUM_THREADS", "0", 1);
  ::setenv("MESA_SHADER_CACHE_DISABLE", "true", 0);
  // Loaded for as long as the process runs: drivers do not take being unloaded well.
  void* loaded = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (loaded == nullptr) return cannot_draw(fmt::format("{} is not there or cannot be loaded", library));
  auto egl = std::make_shared<Egl>();
  egl->get_proc_address = reinterpret_cast<PFNEGLGETPROCADDRESSPROC>(::dlsym(loaded, "eglGetProcAddress"));
  if (egl->get_proc_address == nullptr) return cannot_draw(library + " is no EGL");
  const bool complete =
      egl->find("eglGetError", egl->get_error) && egl->find("eglQueryString", egl->query_string) &&
      egl->find("eglGetPlatformDisplay", egl->get_platform_display) && egl->find("eglInitialize", egl->initialize) &&
      egl->find("eglBindAPI", egl->bind_api) && egl->find("eglChooseConfig", egl->choose_config) &&
      egl->find("eglCreateContext", egl->create_context) && egl->find("eglDestroyContext", egl->destroy_context) &&
      egl->find("eglMakeCurrent", egl->make_current);
  if (!complete) return cannot_draw(library + " is older than EGL 1.5");
  egl->find("eglQueryDevicesEXT", egl->query_devices);

  EGLDisplay display = EGL_NO_DISPLAY;
  const char* extensions = egl->query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  // Another driver than llvmpipe may have no second display; it has no such lock either.
  if (screen == Screen::kSecond && egl->query_devices != nullptr &&
      has_extension(extensions, "EGL_EXT_platform_device")) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (egl->query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_TRUE && count > 0) {
      display = egl->get_platform_display(EGL_PLATFORM_DEVICE_EXT, devices[0], nullptr);
    }
  }
  if (display == EGL_NO_DISPLAY) {
    if (!has_extension(extensions, "EGL_MESA_platform_surfaceless")) {
      return cannot_draw("EGL has no surfaceless platform here");
    }
    display = egl->get_platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  }
  if (display == EGL_NO_DISPLAY || egl->initialize(display, nullptr, nullptr) != EGL_TRUE) {
    return cannot_draw(fmt::format("EGL finds no driver (error 0x{:x})", egl->get_error()));
  }
  const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT,
                                     EGL_NONE};
  EGLConfig config = nullptr;
  EGLint configs = 0;
  egl->bind_api(EGL_OPENGL_ES_API);
  if (egl->choose_config(display, wanted.data(), &config, 1, &configs) != EGL_TRUE || configs == 0) {
    return cannot_draw("the driver has no OpenGL ES 3");
  }
  const std::array<EGLint, 3> version{EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
  std::unique_ptr<Context> context(new Context);
  context->egl_ = egl;
  context->display_ = display;
  context->context_ = egl->create_context(display, config, EGL_NO_CONTEXT, version.data());
  if (context->context_ == EGL_NO_CONTEXT) {
    return cannot_draw(fmt::format("the driver gives no context of OpenGL ES 3 (error 0x{:x})", egl->get_error()));
  }
  if (egl->make_current(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context->context_) != EGL_TRUE) {
    return cannot_draw("the driver cannot draw without a surface");
  }
  bool found = true;
#define CTN_VR_GL_FIND(name, type) found = egl->find("gl" #name, context->gl_.name) && found;
  CTN_VR_GL_FUNCTIONS(CTN_VR_GL_FIND)
#undef CTN_VR_GL_FIND
  if (found) context->renderer_ = reinterpret_cast<const char*>(context->gl_.GetString(GL_RENDERER));
  egl->make_current(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  if (!found) return cannot_draw("the driver lacks functions of OpenGL ES 3");
  return context;
}

Context::~Context() {
  if (context_ != nullptr) egl_->destroy_context(display_, context_);
}

Context::Current::Current(const Context& context) : context_(context) {
  context.egl_->bind_api(EGL_OPENGL_ES_API);  // a setting of the thread
  context.egl_->make_current(context.display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context.context_);
}

Context::Current::~Current() {
  context_.egl_->make_current(context_.display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

}  // namespace ctn::vr::drawing
