#include "web/routes.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "web/answers.h"
#include "web/assets.h"
#include "web/change_request.h"
#include "web/document.h"
#include "web/http_library.h"
#include "web/metrics.h"
#include "web/request_head.h"

namespace ctn::web {
namespace {

// The HTTP library, without its sockets and threads.
class Library final : public httplib::Server {
 public:
  // The library takes a server without a socket for a stopped one, and ends its streams.
  void started(int socket) { svr_sock_ = socket; }
  void stopped() { svr_sock_ = INVALID_SOCKET; }
  // False: the connection must be closed.
  bool answer(httplib::Stream& stream, bool last) {
    bool closed = false;
    return process_request(stream, last, closed, nullptr) && !closed;
  }
};

int status_of(const Error& error) { return error.kind() == ErrorKind::kCaller ? 400 : 503; }

void fail(httplib::Response& response, int status, const std::string& body) {
  response.status = status;
  response.set_content(body, kJson);
}

}  // namespace

struct Routes::Impl {
  Impl(os::Os& system, Source& shown, const Limits& max, const StopSign& sign, bool control)
      : os(system),
        source(shown),
        limits(max),
        stop(sign),
        may_control(control),
        live(os, limits.step * 9 / 10, [this] { return source.live(); }),
        timeline(os, limits.step * 9 / 10, [this] { return source.timeline(); }),
        snapshot(os, limits.step * 9 / 10, [this] { return source.snapshot(); }),
        plan(os, limits.step * 9 / 10, [this] { return source.plan(); }) {
    route();
  }

  void route() {
    httplib::Headers headers;
    for (const auto& [name, value] : kSafety) headers.emplace(name, value);
    library.set_default_headers(headers);
    library.set_keep_alive_max_count(limits.requests);
    library.set_keep_alive_timeout(std::chrono::duration_cast<std::chrono::seconds>(limits.idle).count());
    library.set_payload_max_length(kMaxBody);
    show("/", kPage, "text/html; charset=utf-8");
    show("/style.css", kPageStyle, "text/css; charset=utf-8");
    show("/page.js", kPageScript, "text/javascript; charset=utf-8");
    show("/live", live);
    show("/timeline", timeline);
    show("/snapshot", snapshot);
    show("/plan", plan);
    library.Get("/control", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(may_control ? "{\"allowed\":true}\n" : "{\"allowed\":false}\n", kJson);
    });
    library.Get("/metrics", [this](const httplib::Request&, httplib::Response& response) {
      const Document::Text measured = snapshot.get();
      const Document::Text seen = live.get();
      response.set_content(metrics_text(*measured ? **measured : std::string(), *seen ? **seen : std::string()),
                           "text/plain; version=0.0.4; charset=utf-8");
    });
    library.Get("/events", [this](const httplib::Request&, httplib::Response& response) { stream(response); });
    library.Post("/control/change", [this](const httplib::Request& request, httplib::Response& response) {
      change(request.body, response);
    });
    library.Post("/whatif", [this](const httplib::Request& request, httplib::Response& response) {
      what_if(request.body, response);
    });
    library.set_error_handler([](const httplib::Request&, httplib::Response& response) {
      if (response.body.empty()) {
        fail(response, response.status, error_json("there is no such page, or the request is wrong", "see /"));
      }
    });
    library.set_exception_handler([](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
      fail(response, 500, error_json("this is a bug in catan", "report it"));
    });
  }

  void show(const char* path, const char* text, const char* type) {
    library.Get(
        path, [text, type](const httplib::Request&, httplib::Response& response) { response.set_content(text, type); });
  }

  void show(const char* path, Document& document) {
    library.Get(path, [&document](const httplib::Request&, httplib::Response& response) {
      const Document::Text text = document.get();
      if (!*text) return fail(response, status_of(text->error()), error_json(text->error()));
      response.set_content(**text, kJson);
    });
  }

  void change(const std::string& body, httplib::Response& response) {
    const Result<Changes> changes = parse_change(body);
    if (!changes) return fail(response, 400, error_json(changes.error()));
    const std::lock_guard lock(changing);
    if (const Status done = source.change(*changes); !done) {
      return fail(response, status_of(done.error()), error_json(done.error()));
    }
    for (Document* document : {&live, &snapshot, &plan}) document->forget();
    response.set_content("{\"done\":true}\n", kJson);
  }

  // One question at a time, since each takes CPU time.
  void what_if(const std::string& body, httplib::Response& response) {
    const Result<WhatIf> asked = parse_what_if(body);
    if (!asked) return fail(response, 400, error_json(asked.error()));
    const std::unique_lock lock(asking, std::try_to_lock);
    if (!lock) {
      response.set_header("Retry-After", "1");
      return fail(response, 429, error_json("another what-if question is being answered", "ask again in a second"));
    }
    const Result<std::string> answer = source.what_if(*asked);
    if (!answer) return fail(response, status_of(answer.error()), error_json(answer.error()));
    response.set_content(*answer, kJson);
  }

  void stream(httplib::Response& response) {
    const TimePoint until = os.now() + limits.stream;
    response.set_chunked_content_provider(
        "text/event-stream", [this, until, sent = std::uint64_t{0}](std::size_t, httplib::DataSink& sink) mutable {
          // That a client has gone is noticed when something is written to it.
          if (sent > 0) stop.wait(std::min(until, os.now() + limits.step));
          if (stop.given() || os.now() >= until) {
            sink.done();
            return true;
          }
          std::string text = sent == 0 ? "retry: 2000\n\n" : "";
          text += event_text("live", live);
          if (sent % 2 == 0) text += event_text("timeline", timeline);
          ++sent;
          return sink.write(text.data(), text.size());
        });
  }

  static std::string event_text(std::string_view name, Document& document) {
    const Document::Text text = document.get();
    return *text ? event_of(name, **text) : event_of("trouble", error_json(text->error()));
  }

  os::Os& os;
  Source& source;
  const Limits& limits;
  const StopSign& stop;
  const bool may_control;
  Document live;
  Document timeline;
  Document snapshot;
  Document plan;
  std::mutex changing;
  std::mutex asking;
  Library library;
};

Routes::Routes(os::Os& os, Source& source, const Limits& limits, const StopSign& stop, bool may_control, int listening)
    : impl_(std::make_unique<Impl>(os, source, limits, stop, may_control)) {
  impl_->library.started(listening);
}

Routes::~Routes() = default;

bool Routes::answer(httplib::Stream& stream, bool last) { return impl_->library.answer(stream, last); }

void Routes::end() { impl_->library.stopped(); }

}  // namespace ctn::web
