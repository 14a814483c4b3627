// catan watch: reads the flight recorder of a running app, and saves the last seconds when a response is late, or when
// the app's process is killed.
#include "watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "attach.h"
#include "base/text.h"
#include "command.h"
#include "config/quantity.h"
#include "flight/late_watch.h"
#include "flight/recording.h"
#include "os/linux/linux_os.h"
#include "os/linux/poller.h"
#include "os/linux/process.h"
#include "os/linux/signal_watch.h"
#include "scheduling_options.h"
#include "why/why.h"

namespace ctn::tool {
namespace {

constexpr Nanos kReadEvery = std::chrono::milliseconds{100};
constexpr Nanos kAfterwards = std::chrono::milliseconds{500};  // of what follows a late response are saved, too
constexpr Nanos kApart = std::chrono::seconds{10};             // at least, between two records of late responses
constexpr Nanos kToEnd = std::chrono::seconds{5};              // for a watch whose app has ended
constexpr int kNamesToTry = 1000;                              // where files of the names before are there already

struct WatchOptions {
  std::string target;
  bool since_start = false;  // responses from before the watch count, too
  WatchedApp of;
};

// One process that is watched, until it ends.
class Watcher {
 public:
  Watcher(os::Os& os, flight::Recording recording, const std::vector<flight::WatchedChain>& chains,
          const WatchOptions& options)
      : os_(os),
        recording_(std::move(recording)),
        options_(options.of),
        late_(recording_.app(), chains,
              std::max(options.since_start ? TimePoint{} : os.now(),
                       recording_.header().started + recording_.header().warm_up)) {}

  Status run();

 private:
  void look();
  void save_late();
  bool save(const char* what, const std::string& why);

  os::Os& os_;
  flight::Recording recording_;
  const WatchedApp& options_;
  flight::LateWatch late_;
  std::optional<flight::LateResponse> pending_;
  TimePoint save_at_ = kNever;
  TimePoint quiet_until_{};
  int saved_ = 0;
  std::uint64_t left_out_ = 0;
};

Status Watcher::run() {
  Result<os::SignalWatch> signals = os::SignalWatch::start({SIGINT, SIGTERM, SIGHUP});
  if (!signals) return signals.error();
  const Result<std::unique_ptr<os::Poller>> poller = os::Poller::make();
  if (!poller) return poller.error();
  const os::Descriptor process = os::watch_process(os::ProcessId{recording_.process()});
  constexpr os::Poller::Key kSignal = 0;
  constexpr os::Poller::Key kProcess = 1;
  if (Status added = (*poller)->add(signals->descriptor(), kSignal); !added) return added;
  bool ended = !process.valid();
  if (!ended) {
    if (Status added = (*poller)->add(process, kProcess); !added) return added;
  }
  bool asked_to_end = false;
  while (!ended && !asked_to_end && !recording_.over()) {
    // Where no chain is watched there is nothing to do until the process ends.
    const TimePoint next = options_.on_late.empty() ? os_.now() + std::chrono::seconds{1} : os_.now() + kReadEvery;
    for (const os::Poller::Key key : (*poller)->wait(next)) {
      asked_to_end = asked_to_end || key == kSignal;
      ended = ended || key == kProcess;
    }
    look();
  }
  look();  // what came before the app ended
  if (pending_) save_late();
  if (ended && !recording_.over()) save("killed", "its process ended without stopping it");
  if (left_out_ > 0) {
    note(fmt::format("{} more responses were late, of which no record was saved", left_out_));
  }
  return Done{};
}

void Watcher::look() {
  if (options_.on_late.empty()) return;
  recording_.read_new(late_);
  const TimePoint now = os_.now();
  left_out_ += late_.take_count();
  if (const std::optional<flight::LateResponse> late = late_.take()) {
    if (!pending_ && now >= quiet_until_ && saved_ < options_.at_most) {
      pending_ = late;
      save_at_ = now + kAfterwards;
      --left_out_;
    }
  }
  if (pending_ && now >= save_at_) save_late();
}

void Watcher::save_late() {
  const flight::LateResponse late = *std::exchange(pending_, std::nullopt);
  const bool saved =
      save("late", fmt::format("a response of {} took {:.2f} ms, more than {:.2f} ms",
                               recording_.app().graph.path_name(recording_.app().objective[late.term].path),
                               to_millis(late.response).count(), to_millis(late.over).count()));
  if (!saved) {
    ++left_out_;
    return;
  }
  quiet_until_ = os_.now() + kApart;
  ++saved_;
}

// Into a new file: the name gets a number where it is taken. False: it cannot be had, which is told.
bool Watcher::save(const char* what, const std::string& why) {
  const os::HostFacts host = os_.host_facts();
  std::string when = host.utc;
  std::replace(when.begin(), when.end(), ':', '-');
  const std::string name = fmt::format("{}-{}-{}", as_file_name(recording_.app().name), what, when);
  for (int number = 1; number <= kNamesToTry; ++number) {
    const std::string file = number == 1 ? name : fmt::format("{}-{}", name, number);
    const std::string path = (std::filesystem::path(options_.folder) / (file + ".catan")).string();
    if (std::filesystem::exists(path)) continue;
    const Status done = recording_.save(path, why, host);
    if (done) {
      note(fmt::format("{}: the last seconds are in {}", why, path));
    } else {
      static_cast<void>(report_error(done.error()));
    }
    return done.ok();
  }
  return false;
}

// "CHAIN", "CHAIN>100" (milliseconds) or "CHAIN>100ms".
Result<flight::WatchedChain> watched_chain(const graph::App& app, const std::string& text) {
  const std::size_t last = text.rfind('>');
  std::optional<Nanos> over;
  if (last != std::string::npos) {
    const std::string limit(trimmed(text.substr(last + 1)));
    const bool plain = !limit.empty() && limit.find_first_not_of("0123456789.") == std::string::npos;
    const Result<Nanos> duration = config::parse_duration(plain ? limit + "ms" : limit);
    if (duration) over = *duration;
  }
  const Result<std::size_t> term = why::find_chain(app, over ? trimmed(text.substr(0, last)) : trimmed(text));
  if (!term) return about_option(term.error(), "--on-late");
  return flight::WatchedChain{*term, over};
}

int watch(const WatchOptions& options) {
  outlive_readers();
  const std::unique_ptr<os::Os> os = os::make_linux_os();
  Result<flight::Recording> recording = attach(*os, options.target);
  if (!recording) return report_error(recording.error());
  Result<std::vector<flight::WatchedChain>> chains = watched_chains(recording->app(), options.of.on_late);
  if (!chains) return report_error(chains.error());
  if (std::error_code unmade; !std::filesystem::create_directories(options.of.folder, unmade) && unmade) {
    return report_error(
        Error::environment(fmt::format("{} cannot be made: {}", printable(options.of.folder), unmade.message()),
                           "name another folder with --save-to"));
  }
  const Status watched = Watcher(*os, std::move(*recording), *chains, options).run();
  return watched ? kSuccess : report_error(watched.error());
}

}  // namespace

Status WatchedApp::check(const graph::App& app, int flight_recorder_mib) const {
  if (const auto chains = watched_chains(app, on_late); !chains) return chains.error();
  if (on_late.empty() || flight_recorder_mib > 0) return Done{};
  return Error::caller("--on-late needs the flight recorder, which --flight-recorder 0 turns off",
                       "leave out one of these options");
}

Result<std::vector<flight::WatchedChain>> watched_chains(const graph::App& app, const std::vector<std::string>& texts) {
  std::vector<flight::WatchedChain> chains;
  std::vector<Problem> problems;
  for (const std::string& text : texts) {
    const Result<flight::WatchedChain> chain = watched_chain(app, text);
    if (chain) {
      chains.push_back(*chain);
    } else {
      problems.push_back(chain.error().problems().front());
    }
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return chains;
}

void WatchedApp::add_to(CLI::App& command) {
  command
      .add_option(
          "--on-late", on_late,
          "Save the last seconds as a record when a response of this chain takes longer than MS milliseconds; without "
          "MS, than its bound; without a bound, than the plan promises. May be given several times")
      ->type_name("CHAIN[>MS]")
      ->allow_extra_args(false);
  command.add_option("--save-to", folder, "Where such records go, named after the app and the time")
      ->type_name("FOLDER")
      ->capture_default_str();
  command.add_option("--at-most", at_most, "Save at most this many records of late responses")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
}

Result<os::ChildProcess> WatchedApp::start_watching(const std::string& target) const {
  std::vector<std::string> arguments{"/proc/self/exe", "watch", target, "--since-start", "--save-to", folder};
  arguments.insert(arguments.end(), {"--at-most", std::to_string(at_most)});
  for (const std::string& chain : on_late) arguments.insert(arguments.end(), {"--on-late", chain});
  return os::ChildProcess::start(arguments);
}

void WatchedApp::let_end(os::Clock& clock, os::ChildProcess& watch) const {
  if (on_late.empty()) return;
  const TimePoint latest = clock.now() + kToEnd;
  while (!watch.wait() && clock.now() < latest) clock.sleep_until(clock.now() + std::chrono::milliseconds{10});
}

void add_watch_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<WatchOptions>();
  CLI::App* command = cli.add_subcommand("watch", "Save the last seconds of an app when it is late, or killed");
  command->footer(
      "Examples:\n"
      "  catan watch robot --on-late 'scan -> LM -> LP>150'   the app's name, its file or its server's socket\n"
      "  catan watch 4711 --on-late LP --save-to /var/tmp     a process; a chain by its last node, and its bound\n"
      "  catan watch                                          the only app that is scheduled here; only if it is "
      "killed\n"
      "catan serve always starts catan watch, and catan run where --on-late asks for it. It ends with the app, and\n"
      "costs the app nothing: it only reads what the app keeps in memory. docs/flight-recorder.md says more.\n"
      "Exit code: 0 the app or the watch has ended, 1 failure at run time, 2 no such app runs, or a mistake.");
  command->add_option("TARGET", options->target, "An app's name or file, a server's socket, or a process");
  command->add_flag("--since-start", options->since_start)->group("");
  options->of.add_to(*command);
  command->callback([options, &exit_code] { exit_code = watch(*options); });
}

}  // namespace ctn::tool
