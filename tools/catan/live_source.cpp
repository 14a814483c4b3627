#include "live_source.h"

#include <chrono>
#include <new>
#include <optional>
#include <utility>

#include "attach.h"
#include "live_whatif.h"
#include "os/linux/background.h"
#include "runtime/control.h"
#include "runtime/socket_path.h"
#include "view/json.h"

namespace ctn::tool {
namespace {

// Without reading for so long, events may have been overwritten: the recording is opened again and read from its oldest
// event on.
constexpr Nanos kReadAnewAfter = std::chrono::seconds{3};
// Between two searches for the app where there is none.
constexpr Nanos kLookAgainAfter = std::chrono::seconds{1};

bool is_same_run(const flight::Recording& one, const flight::Recording& other) {
  return one.process() == other.process() && one.header().started == other.header().started;
}

}  // namespace

Status LiveSource::look() {
  const std::lock_guard lock(mutex_);
  const Result<Watched*> found = watched();
  return found ? Status(Done{}) : Status(found.error());
}

std::optional<os::CpuSet> LiveSource::cpus() {
  const std::lock_guard lock(mutex_);
  return watched_ ? std::optional(watched_->app.recording().header().cpus) : std::nullopt;
}

void LiveSource::look_for_app(TimePoint now) {
  looked_at_ = now;
  Result<flight::Recording> found = attach(os_, target_);
  if (!found) {
    missing_ = found.error();
    return;
  }
  auto next = std::make_unique<Watched>(std::move(*found));
  // Prometheus's counters must not begin anew within one run.
  if (watched_ && is_same_run(watched_->app.recording(), next->app.recording())) {
    next->app.view().go_on_from(watched_->app.view().late_so_far());
  }
  watched_ = std::move(next);
}

Result<LiveSource::Watched*> LiveSource::watched() {
  const TimePoint now = os_.now();
  const bool ended = watched_ && watched_->app.has_ended();
  const bool paused = watched_ && now - read_at_ > kReadAnewAfter;
  const bool looked = looked_at_ && now - *looked_at_ < kLookAgainAfter;
  if ((!watched_ || ended || paused) && !looked) look_for_app(now);
  if (!watched_) return *missing_;  // else the app that has ended is still shown
  watched_->app.refresh(os_, &watched_->timeline);
  read_at_ = now;
  return watched_.get();
}

Result<std::string> LiveSource::live() {
  const std::lock_guard lock(mutex_);
  const Result<Watched*> seen = watched();
  if (!seen) return seen.error();
  return view::to_json((*seen)->app.picture(os_));
}

Result<std::string> LiveSource::timeline() {
  const std::lock_guard lock(mutex_);
  const Result<Watched*> seen = watched();
  if (!seen) return seen.error();
  return (*seen)->timeline.json(os_.now());
}

Result<std::string> LiveSource::plan() {
  const std::lock_guard lock(mutex_);
  const Result<Watched*> seen = watched();
  if (!seen) return seen.error();
  if ((*seen)->timeline.plan().empty()) {
    return Error::environment("there is no plan in force",
                              "wait until the app has started, or use a scheduler that plans");
  }
  return (*seen)->timeline.plan();
}

Result<runtime::ServerAddress> LiveSource::server() {
  const bool named = !target_.empty() && target_.find_first_not_of("0123456789") != std::string::npos;
  if (named) return address_of(target_);
  const std::lock_guard lock(mutex_);
  const Result<Watched*> seen = watched();
  if (!seen) return seen.error();
  const std::string& app = (*seen)->app.recording().app().name;
  return runtime::ServerAddress{.sockets = runtime::sockets_of_app(app), .app = app};
}

Result<std::string> LiveSource::snapshot() {
  const Result<runtime::ServerAddress> at = server();
  if (!at) return at.error();
  return runtime::ask_for_status(os_, *at);
}

Status LiveSource::change(const Changes& changes) {
  const Result<runtime::ServerAddress> at = server();
  if (!at) return at.error();
  return runtime::ask_to_change(os_, *at, changes);
}

Result<std::string> LiveSource::what_if(const web::WhatIf& asked) {
  Result<flight::Recording> found = attach(os_, target_);
  if (!found) return found.error();
  std::optional<Result<std::string>> answer;
  os_.spawn("what-if", [&] {
    os::yield_to_all();
    try {
      KnownSoFar known(found->app(), found->header());
      static_cast<void>(found->read_new(known));
      answer = tool::what_if(known, asked, os_);
    } catch (const std::bad_alloc&) {
      answer = Error::environment("there is not enough memory to plan that", "ask for fewer cores");
    }
  });  // the returned thread is joined here
  return std::move(*answer);
}

}  // namespace ctn::tool
