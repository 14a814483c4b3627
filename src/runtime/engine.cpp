#include "runtime/engine.h"

#include <fmt/format.h>

#include <utility>

#include "os/thread_limit.h"

namespace ctn::runtime {

Result<std::unique_ptr<Engine>> Engine::create(graph::App app, os::Os& os, EngineOptions options) {
  Result<os::CpuSet> cpus = choose_cpus(os, options.cpus);
  if (!cpus) return cpus.error();
  app = policy::as_run_by(*options.policy, std::move(app));
  std::unique_ptr<Engine> engine(new Engine(std::move(app), os, cpus->size()));
  Result<std::unique_ptr<Scheduler>> scheduler =
      Scheduler::create(engine->app_, os, std::move(options), std::move(*cpus), engine->memory_.region());
  if (!scheduler) return scheduler.error();
  engine->scheduler_ = std::move(*scheduler);
  engine->scheduler_->watch_channels(
      {.dropped = [&wiring = engine->wiring_] { return wiring.dropped(); },
       .misuses = [&wiring = engine->wiring_](TimePoint now) { return wiring.take_misuses(now); }});
  return engine;
}

Engine::Engine(graph::App app, os::Os& os, std::size_t cores)
    : app_(std::move(app)),
      os_(os),
      memory_(app_.graph, cores),
      wiring_(app_, os_, memory_.region()),
      nodes_(app_, os_, wiring_) {}

Engine::~Engine() { static_cast<void>(stop()); }

Status Engine::start() {
  if (state_ != State::kNew) return Error::caller("the session was started before", "open another");
  if (Status wired = wiring_.check(true); !wired) return wired;
  state_ = State::kRunning;
  if (Status started = os::within_thread_limit([this] { return prepare_and_start(); }); !started) {
    static_cast<void>(stop());
    return started;
  }
  nodes_.go();
  return Done{};
}

Status Engine::prepare_and_start() {
  if (Status ready = scheduler_->prepare(); !ready) {
    state_ = State::kNew;  // nothing to stop, and it may be started again
    return ready;
  }
  wiring_.close([this](const std::string& problem) { scheduler_->notice("too-late", problem); });
  for (const auto& [node, thread] : nodes_.spawn()) {
    if (Status joined = scheduler_->join(node, os_.current_process(), thread); !joined) return joined;
  }
  return scheduler_->start();
}

Status Engine::stop() {
  if ((scheduler_ && scheduler_->delivers_notices()) || nodes_.is_current()) {
    return Error::caller("a session cannot be stopped by a function that it calls",
                         "have the thread that started it stop it");
  }
  if (state_ != State::kRunning) return stopped_;
  state_ = State::kStopped;
  scheduler_->end_scheduling();
  nodes_.stop();
  stopped_ = scheduler_->finish();
  if (stopped_) stopped_ = wiring_.check(true);
  return stopped_;
}

Status Engine::adopt_this_thread(std::string_view node) {
  const std::optional<NodeId> id = app_.graph.find_node(node);
  if (!id || app_.graph.node(*id).external) {
    return Error::caller(fmt::format("app {} has no node '{}' of its own", app_.name, node),
                         "use a name from its nodes section that is not external");
  }
  return scheduler_->add_thread(*id, os_.current_process(), os_.current_thread());
}

}  // namespace ctn::runtime
