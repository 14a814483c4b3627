// catan top: watches an app while it runs.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "attach.h"
#include "command.h"
#include "flight/recording.h"
#include "live_app.h"
#include "os/linux/linux_os.h"
#include "os/linux/poller.h"
#include "os/linux/signal_watch.h"
#include "record/reader.h"
#include "temporary_folder.h"
#include "top_screen.h"
#include "top_terminal.h"
#include "view/json.h"
#include "why/why.h"

namespace ctn::tool {
namespace {

constexpr Nanos kRefresh = std::chrono::milliseconds{500};
constexpr Nanos kOnceFor = std::chrono::seconds{1};

struct TopOptions {
  std::string target;
  bool once = false;
  bool json = false;
};

std::size_t term_of(const graph::App& app, std::size_t chain) {
  std::size_t term = 0;
  for (std::size_t seen = 0; term < app.objective.size(); ++term) {
    if (app.objective[term].metric == graph::Metric::kResponseTime && seen++ == chain) break;
  }
  return term;
}

// Why responses of a chain were late, of those that the recording still has, as lines for the screen.
Result<std::vector<std::string>> causes_of(os::Os& os, const flight::Recording& recording, std::size_t chain) {
  const auto folder = TemporaryFolder::make("catan-top");
  if (!folder) return folder.error();
  const std::string file = (*folder)->path() + "/kept.catan";
  if (Status saved = recording.save(file, "catan top asks why responses were late", os.host_facts()); !saved) {
    return saved.error();
  }
  const auto record = record::Reader::open(file);
  if (!record) return record.error();
  const auto analysis = why::analyse(*record, term_of(recording.app(), chain), {.worst = 0, .whole = true});
  if (!analysis) return analysis.error();
  std::vector<std::string> lines{fmt::format("WHY LATE: {} of {} responses took over {:.4g} ms, {}", analysis->late,
                                             analysis->responses, to_millis(analysis->late_over).count(),
                                             analysis->bound ? "the bound" : "their 99th percentile")};
  for (std::size_t kind = 0; kind < why::kCauseKinds; ++kind) {
    if (analysis->causes[kind] == 0) continue;
    lines.push_back(
        fmt::format("{:>6}  {}", analysis->causes[kind], why::to_string(static_cast<why::CauseKind>(kind))));
  }
  std::stable_sort(lines.begin() + 1, lines.end(), std::greater<>());
  return lines;
}

Result<LiveApp> watch(os::Os& os, const std::string& target) {
  Result<flight::Recording> recording = attach(os, target);
  if (!recording) return recording.error();
  keep_off_scheduled_cpus(os, recording->header().cpus);
  return LiveApp(std::move(*recording));
}

view::Picture look(os::Os& os, LiveApp& watched) {
  watched.refresh(os);
  return watched.picture(os);
}

Status show_once(os::Os& os, const TopOptions& options) {
  Result<LiveApp> watched = watch(os, options.target);
  if (!watched) return watched.error();
  view::Picture picture = look(os, *watched);
  if (picture.state == view::State::kRunning) {
    os.sleep_until(os.now() + kOnceFor);
    picture = look(os, *watched);
  }
  print(options.json ? view::to_json(picture) : top_text(picture));
  return Done{};
}

// Shows the app until the user or a signal ends it.
class Screen {
 public:
  Screen(os::Os& os, LiveApp watched, std::unique_ptr<TopTerminal> terminal)
      : os_(os), watched_(std::move(watched)), terminal_(std::move(terminal)) {
    state_.unicode = terminal_->unicode();
  }

  Status run(os::SignalWatch& signals) {
    const auto poller = os::Poller::make();
    if (!poller) return poller.error();
    const os::Descriptor keyboard(dup(STDIN_FILENO));
    if (Status added = (*poller)->add(signals.descriptor(), 1); !added) return added;
    if (Status added = (*poller)->add(keyboard, 2); !added) return added;
    view::Picture picture = look(os_, watched_);
    TimePoint next = os_.now() + kRefresh;
    while (!signals.next()) {
      terminal_->draw(top_screen(picture, state_, terminal_->size()));
      const bool pressed = !(*poller)->wait(next).empty();
      while (const std::optional<int> key = terminal_->key()) {
        if (*key == 'q') return Done{};
        if (*key == 'w' && state_.open) {
          explain(picture);
        } else {
          press(state_, *key, picture.chains.size());
        }
      }
      if (pressed && hung_up()) return Done{};
      if (os_.now() < next) continue;
      next = os_.now() + kRefresh;
      // Read new events even while paused: the recording does not keep them for long.
      view::Picture newest = look(os_, watched_);
      if (!state_.paused) picture = std::move(newest);
    }
    return Done{};
  }

 private:
  // Says first that it is at work, since the recording may have minutes of events to look through.
  void explain(const view::Picture& picture) {
    state_.causes = {"WHY LATE: looking through the last minutes ..."};
    terminal_->draw(top_screen(picture, state_, terminal_->size()));
    Result<std::vector<std::string>> causes = causes_of(os_, watched_.recording(), state_.selected);
    state_.causes = causes ? std::move(*causes) : std::vector{"WHY LATE: " + causes.error().message()};
  }
  // Without this check a terminal that is gone would count as readable for ever, with no key to read.
  static bool hung_up() { return tcgetpgrp(STDIN_FILENO) < 0; }

  os::Os& os_;
  LiveApp watched_;
  std::unique_ptr<TopTerminal> terminal_;
  ScreenState state_;
};

Status show_screen(os::Os& os, const TopOptions& options) {
  if (isatty(STDOUT_FILENO) == 0 || isatty(STDIN_FILENO) == 0) {
    return Error::caller("there is no terminal to draw on", "use --once, which prints once; --json for programs");
  }
  auto signals = os::SignalWatch::start({SIGINT, SIGTERM, SIGHUP});
  if (!signals) return signals.error();
  Result<LiveApp> watched = watch(os, options.target);
  if (!watched) return watched.error();
  Result<std::unique_ptr<TopTerminal>> terminal = TopTerminal::open(stdout_has_colours());
  if (!terminal) return terminal.error();
  return Screen(os, std::move(*watched), std::move(*terminal)).run(*signals);
}

}  // namespace

void add_top_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<TopOptions>();
  CLI::App* command =
      cli.add_subcommand("top", "Watch an app while it runs: response times, subchains, cores, notices");
  command->footer(
      "Examples:\n"
      "  catan top                        the only app that Catan schedules on this machine\n"
      "  catan top robot                  by the name of the app\n"
      "  catan top app.yaml\n"
      "  catan top /run/catan/robot.sock  a server by its socket\n"
      "  catan top 4711                   a session in a process, by its number\n"
      "  catan top robot --once           prints once, after a second; --once --json for programs\n"
      "Keys: up, down and Enter open a chain; s, S sort subchains; p pauses; h says more; q ends it.\n"
      "The app does not notice that it is watched. docs/top.md explains all figures.\n"
      "Exit code: 0 the app was shown, 1 failure at run time, as where it cannot be watched, 2 no such app runs, or a "
      "mistake.");
  command->add_option("TARGET", options->target,
                      "A server's socket, an app file, the name of an app, or the number of a process");
  CLI::Option* once =
      command->add_flag("--once", options->once, "Print the figures after one second of watching, and end");
  command->add_flag("--json", options->json, "As one JSON document (docs/top.md)")->needs(once);
  command->callback([options, &exit_code] {
    const std::unique_ptr<os::Os> os = os::make_linux_os();
    const Status done = options->once ? show_once(*os, *options) : show_screen(*os, *options);
    exit_code = done ? kSuccess : report_error(done.error());
  });
}

}  // namespace ctn::tool
