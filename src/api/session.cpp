// The public session: the engine on Linux.
#include "catan/session.h"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "api/in_one_process.h"
#include "api/policies.h"
#include "api/session_access.h"
#include "config/app_file.h"
#include "os/linux/linux_os.h"
#include "runtime/engine.h"

namespace ctn {

class Session::Impl : public api::InOneProcess<runtime::Engine> {
 public:
  using InOneProcess::InOneProcess;
};

Result<Session> Session::open(const std::string& app_file, const SessionOptions& options) {
  Result<graph::App> app = config::load_app(app_file, config::RunBy::kFunctions);
  if (!app) return app.error();
  return SessionAccess::open(std::move(*app), options);
}

Result<Session> SessionAccess::open(graph::App app, const SessionOptions& options) {
  const auto policy = api::live_policy(options.policy, app);
  if (!policy) return policy.error();

  constexpr int kMaxMib = 4096;
  if (options.flight_recorder_mib < 0 || options.flight_recorder_mib > kMaxMib) {
    return Error::caller(fmt::format("a flight recorder cannot have {} MiB", options.flight_recorder_mib),
                         fmt::format("write 0 for none, or up to {}", kMaxMib));
  }

  std::optional<graph::FrameMode> frames;
  if (options.fixed_frames) {
    frames = *options.fixed_frames ? graph::FrameMode::kFixed : graph::FrameMode::kElastic;
  }
  std::unique_ptr<os::Os> system = os::make_linux_os();
  Result<std::unique_ptr<runtime::Engine>> engine =
      runtime::Engine::create(std::move(app), *system,
                              {.policy = *policy,
                               .cpus = os::CpuSet(options.cpus),
                               .record = options.record,
                               .note = options.note,
                               .stealing = options.stealing,
                               .replan = options.replan,
                               .frames = frames,
                               .flight_bytes = static_cast<std::size_t>(options.flight_recorder_mib) << 20U,
                               .on_notice = options.on_notice});
  if (!engine) return engine.error();
  return Session(std::make_unique<Session::Impl>("session", std::move(system), std::move(*engine)));
}

Session::Session(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

void Session::node(std::string_view name, std::function<void(Run&)> body) {
  if (impl_->here()) impl_->engine().wiring().set_body(name, std::move(body));
}

ChannelBase& Session::open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                                   MakeChannel make) {
  runtime::Wiring& wiring = impl_->engine().wiring();
  return impl_->here() ? wiring.open_channel(from, to, queue, type, make) : wiring.unconnected_channel(make);
}

Status Session::adopt_this_thread(std::string_view node) {
  return impl_->ask([&](runtime::Engine& engine) { return engine.adopt_this_thread(node); });
}

// The steady clock is the monotonic one.
Status Session::tick(std::string_view node, std::chrono::steady_clock::time_point at) {
  const TimePoint time{std::chrono::duration_cast<Nanos>(at.time_since_epoch())};
  return impl_->ask([&](runtime::Engine& engine) { return engine.tick(node, time); });
}

Status Session::start() {
  return impl_->ask([](runtime::Engine& engine) { return engine.start(); });
}

Status Session::stop() {
  if (!impl_->here()) return Done{};
  return impl_->engine().stop();
}

Status Session::change(const Changes& changes) {
  return impl_->ask([&](runtime::Engine& engine) { return engine.change(changes); });
}

Snapshot Session::snapshot() const { return impl_->here() ? impl_->engine().snapshot() : Snapshot{}; }

Status Session::save_flight(const std::string& path, const std::string& why) const {
  return impl_->ask([&](runtime::Engine& engine) { return engine.save_flight(path, why); });
}

}  // namespace ctn
