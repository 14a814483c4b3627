#include "catan/session.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <utility>

#include "api/snapshot_json.h"
#include "capi/callbacks.h"
#include "capi/failure.h"
#include "capi/options.h"

struct catan_session {
  ctn::Session session;
};

namespace ctn::capi {
namespace {

Result<SessionOptions> options_of(const catan_session_options* given) {
  const Result<catan_session_options> known =
      with_defaults(given, catan_session_options CATAN_SESSION_OPTIONS, offsetof(catan_session_options, frames),
                    "CATAN_SESSION_OPTIONS");
  if (!known) return known.error();
  const catan_session_options& options = *known;
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
  if (options.flight_recorder_mib != 0) result.flight_recorder_mib = std::max(options.flight_recorder_mib, 0);
  result.on_notice = notice_of(options.on_notice, options.on_notice_user);
  return result;
}

// `ask` writes what is asked for into Changes.
template <class Ask>
catan_status change(catan_error** error, catan_session* session, const Ask& ask) noexcept {
  return guarded(error, [&]() -> Status {
    if (session == nullptr) return missing("session");
    Changes changes;
    ask(changes);
    return session->session.change(changes);
  });
}

// What stands for no bound.
std::optional<double> bound_of(double value) { return value == 0.0 ? std::nullopt : std::optional(value); }

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

catan_status catan_session_tick(catan_session* session, const char* node, int64_t monotonic_ns, catan_error** error) {
  return ctn::capi::guarded(error, [&]() -> ctn::Status {
    if (session == nullptr) return ctn::capi::missing("session");
    const std::chrono::steady_clock::time_point at{std::chrono::nanoseconds{monotonic_ns}};
    return session->session.tick(ctn::capi::text_of(node), at);
  });
}

catan_status catan_session_set_cpus(catan_session* session, const int* cpus, size_t count, catan_error** error) {
  return ctn::capi::change(error, session, [&](ctn::Changes& changes) {
    changes.cpus.emplace(cpus, cpus == nullptr ? cpus : cpus + count);
  });
}

catan_status catan_session_set_weight(catan_session* session, const char* term, double weight, catan_error** error) {
  return ctn::capi::change(error, session, [&](ctn::Changes& changes) {
    changes.weights.push_back({ctn::capi::text_of(term), weight});
  });
}

catan_status catan_session_set_max(catan_session* session, const char* term, double max_ms, catan_error** error) {
  return ctn::capi::change(error, session, [&](ctn::Changes& changes) {
    changes.maxes.push_back({ctn::capi::text_of(term), ctn::capi::bound_of(max_ms)});
  });
}

catan_status catan_session_set_min_rate(catan_session* session, const char* node, double hertz, catan_error** error) {
  return ctn::capi::change(error, session, [&](ctn::Changes& changes) {
    changes.min_rates.push_back({ctn::capi::text_of(node), ctn::capi::bound_of(hertz)});
  });
}

char* catan_session_snapshot(const catan_session* session, catan_error** error) {
  char* copy = nullptr;
  ctn::capi::guarded(error, [&]() -> ctn::Status {
    if (session == nullptr) return ctn::capi::missing("session");
    const std::string text = ctn::api::to_json(session->session.snapshot());
    copy = static_cast<char*>(std::malloc(text.size() + 1));
    if (copy == nullptr) throw std::bad_alloc();
    std::memcpy(copy, text.c_str(), text.size() + 1);
    return ctn::Done{};
  });
  return copy;
}

catan_status catan_session_save_flight(const catan_session* session, const char* path, const char* why,
                                       catan_error** error) {
  return ctn::capi::guarded(error, [&]() -> ctn::Status {
    if (session == nullptr) return ctn::capi::missing("session");
    if (path == nullptr) return ctn::capi::missing("path");
    return session->session.save_flight(path, why == nullptr ? "asked" : why);
  });
}

catan_status catan_session_stop(catan_session* session, catan_error** error) {
  return ctn::capi::guarded(error, [&]() -> ctn::Status {
    return session == nullptr ? ctn::Status(ctn::capi::missing("session")) : session->session.stop();
  });
}

void catan_session_free(catan_session* session) { delete session; }

void catan_free(void* memory) { std::free(memory); }
