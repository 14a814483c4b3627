#include "catan/session.h"

#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <utility>

#include "capi/callbacks.h"
#include "capi/failure.h"
#include "capi/options.h"
#include "capi/snapshot_json.h"

struct catan_session {
  ctn::Session session;
};

namespace ctn::capi {
namespace {

Result<SessionOptions> options_of(const catan_session_options* given) {
  const catan_session_options options = with_defaults(given, catan_session_options CATAN_SESSION_OPTIONS);
  SessionOptions result;
  if (options.policy != nullptr) result.policy = options.policy;
  if (options.cpus != nullptr) result.cpus.assign(options.cpus, options.cpus + options.cpu_count);
  result.record = text_of(options.record);
  result.note = text_of(options.note);
  result.stealing = options.no_stealing == 0;
  result.replan = options.no_replan == 0;
  if (options.frames < 0 || options.frames > 2) {
    return Error::caller("frames is none of 0, 1, 2", "write 0 for what the app file says, 1 for elastic, 2 for fixed");
  }
  if (options.frames != 0) result.fixed_frames = options.frames == 2;
  result.on_notice = notice_of(options.on_notice, options.on_notice_user);
  return result;
}

}  // namespace
}  // namespace ctn::capi

catan_session* catan_session_open(const char* app_file, const catan_session_options* options, catan_error** error) {
  std::unique_ptr<catan_session> handle;
  ctn::capi::guarded(error, [&]() -> ctn::Status {
    if (app_file == nullptr) return ctn::capi::missing("app_file");
    const ctn::Result<ctn::SessionOptions> chosen = ctn::capi::options_of(options);
    if (!chosen) return chosen.error();
    ctn::Result<ctn::Session> session = ctn::Session::open(app_file, *chosen);
    if (!session) return session.error();
    handle = std::make_unique<catan_session>(catan_session{std::move(*session)});
    return ctn::Done{};
  });
  return handle.release();
}

void catan_session_node(catan_session* session, const char* name, catan_node_function function, void* user) {
  if (session == nullptr) return;
  ctn::capi::guarded(nullptr, [&]() -> ctn::Status {
    session->session.node(ctn::capi::text_of(name), ctn::capi::body_of(function, user));
    return ctn::Done{};
  });
}

catan_status catan_session_start(catan_session* session, catan_error** error) {
  return ctn::capi::guarded(error, [&]() -> ctn::Status {
    return session == nullptr ? ctn::Status(ctn::capi::missing("session")) : session->session.start();
  });
}

catan_status catan_session_adopt_this_thread(catan_session* session, const char* node, catan_error** error) {
  return ctn::capi::guarded(error, [&]() -> ctn::Status {
    if (session == nullptr) return ctn::capi::missing("session");
    return session->session.adopt_this_thread(ctn::capi::text_of(node));
  });
}

char* catan_session_snapshot(const catan_session* session, catan_error** error) {
  char* copy = nullptr;
  ctn::capi::guarded(error, [&]() -> ctn::Status {
    if (session == nullptr) return ctn::capi::missing("session");
    const std::string text = ctn::capi::to_json(session->session.snapshot());
    copy = static_cast<char*>(std::malloc(text.size() + 1));
    if (copy == nullptr) throw std::bad_alloc();
    std::memcpy(copy, text.c_str(), text.size() + 1);
    return ctn::Done{};
  });
  return copy;
}

catan_status catan_session_stop(catan_session* session, catan_error** error) {
  return ctn::capi::guarded(error, [&]() -> ctn::Status {
    return session == nullptr ? ctn::Status(ctn::capi::missing("session")) : session->session.stop();
  });
}

void catan_session_free(catan_session* session) { delete session; }

void catan_free(void* memory) { std::free(memory); }
