#include "serving.h"

#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <memory>
#include <utility>

#include "api/snapshot_json.h"
#include "base/text.h"
#include "command.h"
#include "os/linux/child_process.h"
#include "os/linux/descendants.h"
#include "os/linux/linux_os.h"
#include "os/linux/signal_watch.h"
#include "runtime/socket_path.h"

namespace ctn::tool {
namespace {

constexpr std::chrono::milliseconds kProgress{500};
// With programs that are asked to end, before they are made to.
constexpr std::chrono::seconds kEndTimeout{3};
// With those that were made to, before they are left to the system.
constexpr std::chrono::seconds kLastTimeout{2};
constexpr std::chrono::milliseconds kLook{5};

Result<std::vector<std::uint32_t>> user_numbers(const std::vector<std::string>& users) {
  std::vector<std::uint32_t> numbers;
  std::vector<Problem> problems;
  for (const std::string& user : users) {
    std::uint32_t number = 0;
    const auto [end, error] = std::from_chars(user.data(), user.data() + user.size(), number);
    if (error == std::errc{} && end == user.data() + user.size()) {
      numbers.push_back(number);
    } else {
      problems.push_back(
          {{}, "--allow-user", fmt::format("{} is no user's number", quote(user)), "write what `id -u` says"});
    }
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  // Who ran this through sudo means to use it.
  if (const char* const behind = std::getenv("SUDO_UID")) {
    std::uint32_t number = 0;
    const std::string text = behind;
    if (std::from_chars(text.data(), text.data() + text.size(), number).ec == std::errc{}) numbers.push_back(number);
  }
  return numbers;
}

// One serving, from the first signal that is caught to the last thread that is restored.
class Serving {
 public:
  Serving(const ServingOptions& options, os::Os& os, runtime::Server& server, os::SignalWatch& signals)
      : options_(options), os_(os), server_(server), signals_(signals) {}

  Result<Served> run();

 private:
  void start_watching();
  void start_companion();
  Status start_commands();
  Status watch_command(os::ChildProcess& command);
  void end_commands();
  bool all_ended() const;
  void command_ended(os::ChildProcess& command);
  void look();

  const ServingOptions& options_;
  os::Os& os_;
  runtime::Server& server_;
  os::SignalWatch& signals_;
  std::optional<os::ChildProcess> watcher_;
  std::deque<os::ChildProcess> commands_;
  std::optional<os::ChildProcess> companion_;
  std::size_t running_ = 0;
  bool ending_ = false;
  std::optional<TimePoint> warm_;
  Served served_;
};

Result<Served> Serving::run() {
  if (Status watched = server_.watch(signals_.descriptor(),
                                     [this] {
                                       served_.signal = signals_.next().value_or(served_.signal);
                                       if (served_.signal != 0) server_.stop();
                                     });
      !watched) {
    return watched.error();
  }
  server_.every(kProgress, [this] { look(); });
  if (Status started = server_.start(); !started) return started.error();
  start_watching();
  start_companion();
  if (Status started = start_commands(); !started) return started.error();
  server_.run();
  if (companion_) server_.forget(companion_->descriptor());
  companion_.reset();
  server_.end_scheduling();
  end_commands();
  const Status finished = server_.finish();
  if (watcher_) options_.watched->let_end(os_, *watcher_);
  if (!finished) return finished.error();
  return served_;
}

// What it is to see is worth having, but no reason not to serve.
void Serving::start_watching() {
  if (!options_.watched) return;
  Result<os::ChildProcess> started =
      options_.watched->start_watching(std::filesystem::absolute(server_.socket()).string());
  if (started) {
    watcher_.emplace(std::move(*started));
  } else {
    static_cast<void>(report_error(started.error()));
  }
}

void Serving::start_companion() {
  if (!options_.companion) return;
  Result<os::ChildProcess> started =
      os::ChildProcess::start(options_.companion(std::filesystem::absolute(server_.socket()).string()));
  if (!started) {
    static_cast<void>(report_error(started.error()));
    return;
  }
  companion_.emplace(std::move(*started));
  const Status watched = server_.watch(companion_->descriptor(), [this] {
    if (!companion_->wait()) return;
    server_.forget(companion_->descriptor());
    companion_.reset();
    note("the page is gone; the app is scheduled as before");
  });
  if (!watched) static_cast<void>(report_error(watched.error()));
}

Status Serving::start_commands() {
  if (!options_.commands.empty()) os::adopt_orphans();
  const std::string socket = std::filesystem::absolute(server_.socket()).string();
  std::vector<std::string> environment = options_.environment;
  environment.push_back(fmt::format("{}={}", runtime::kSocketVariable, socket));
  const auto output = options_.prints_data ? os::ChildProcess::Output::kErrors : os::ChildProcess::Output::kOurs;
  for (const std::vector<std::string>& arguments : options_.commands) {
    Result<os::ChildProcess> command = os::ChildProcess::start(arguments, environment, output);
    if (!command) return command.error();
    commands_.push_back(std::move(*command));
    if (Status watched = watch_command(commands_.back()); !watched) return watched;
    ++running_;
  }
  return Done{};
}

// Those that still run take their leave of the server, so it goes on listening. What they started ends with them.
void Serving::end_commands() {
  if (commands_.empty()) return;
  ending_ = true;
  for (const os::ProcessId process : os::descendants()) static_cast<void>(::kill(static_cast<int>(process), SIGTERM));
  const TimePoint deadline = os_.now() + kEndTimeout;
  while (!all_ended() && os_.now() < deadline) server_.run();
  // A program that is killed takes a moment to be gone, and may have started another just before.
  const TimePoint gone_by = os_.now() + kLastTimeout;
  for (auto left = os::descendants(); !left.empty() && os_.now() < gone_by; left = os::descendants()) {
    for (const os::ProcessId process : left) static_cast<void>(::kill(static_cast<int>(process), SIGKILL));
    os_.sleep_until(os_.now() + kLook);
  }
  commands_.clear();
  os::reap_orphans({});
}

bool Serving::all_ended() const {
  if (running_ > 0) return false;
  os::reap_orphans({});
  return os::descendants().empty();
}

Status Serving::watch_command(os::ChildProcess& command) {
  return server_.watch(command.descriptor(), [this, &command] { command_ended(command); });
}

void Serving::command_ended(os::ChildProcess& command) {
  const std::optional<os::Exit> exit = command.wait();
  if (!exit) return;
  server_.forget(command.descriptor());
  const int code = exit->signal != 0 ? 128 + exit->signal : exit->code;
  if (served_.exit_code == 0 && !ending_) served_.exit_code = code;
  if (--running_ == 0) server_.stop();
}

void Serving::look() {
  if (ending_) return server_.stop();  // for the deadline
  if (!warm_ && server_.warmed_up()) warm_ = os_.now();
  served_.warmed_up = warm_.has_value();
  const double measured = warm_ ? in_seconds(os_.now() - *warm_) : 0.0;
  if (options_.on_progress) options_.on_progress(server_.snapshot(), measured);
  if (options_.seconds && measured >= *options_.seconds) server_.stop();
}

}  // namespace

Result<Served> serve(config::AppFile file, const ServingOptions& options) {
  outlive_readers();
  const Result<std::vector<std::uint32_t>> users = user_numbers(options.users);
  if (!users) return users.error();
  Result<os::SignalWatch> signals = os::SignalWatch::start({SIGINT, SIGTERM, SIGHUP});
  if (!signals) return signals.error();
  const std::unique_ptr<os::Os> os = os::make_linux_os();
  Result<std::unique_ptr<runtime::Server>> server = runtime::Server::open(
      std::move(file), *os,
      {.scheduler = options.scheduler, .socket = options.socket, .users = *users, .describe = api::to_json});
  if (!server) return server.error();
  return Serving(options, *os, **server, *signals).run();
}

}  // namespace ctn::tool
