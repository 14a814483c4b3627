// The navigation app: reads the command line, lets the session (or, in virtual time, the simulation) run, prints what
// was measured.

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <utility>
#include <variant>

#include "run/batch.h"
#include "run/live_run.h"
#include "run/options.h"
#include "run/outcome.h"
#include "run/virtual_run.h"
#include "world/crowd.h"
#include "world/world_file.h"

namespace ctn::navigation::run {
namespace {

constexpr int kFailure = 1;
constexpr int kMistake = 2;

volatile std::sig_atomic_t g_signal = 0;

void remember_signal(int number) { g_signal = number; }

int fail(const Error& error) {
  fmt::print(stderr, "navigation: {}\n", error.message());
  return error.kind() == ErrorKind::kCaller ? kMistake : kFailure;
}

// The live line on a terminal; nothing where stderr is none.
class StatusLine {
 public:
  void show(const std::string& line) {
    if (terminal_) fmt::print(stderr, "\r\033[K{}", line);
  }
  void clear() {
    if (terminal_) fmt::print(stderr, "\r\033[K");
  }

 private:
  bool terminal_ = isatty(STDERR_FILENO) == 1;
};

int print(const std::string& text, int signal) {
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) return kFailure;
  return signal == 0 ? 0 : 128 + signal;
}

Result<world::WorldFile> world_of(const Options& options) {
  if (!options.world_file.empty()) return world::read_world(options.world_file);
  return world::make_crowd({.seed = options.seed});
}

Result<Outcome> run_once(const Options& options, StatusLine& status) {
  auto world = world_of(options);
  if (!world) return world.error();
  const auto signal = [] { return static_cast<int>(g_signal); };
  const auto show = [&status](const Progress& progress) { status.show(status_line(progress)); };
  if (options.virtual_time) return run_virtually(options, *world, {.signal = signal, .show = show});
  const auto notice = [](const std::string& text) { fmt::print(stderr, "navigation: {}\n", text); };
  return run_live(options, *world, {signal, show, notice});
}

int run_single(const Options& options) {
  StatusLine status;
  const auto outcome = run_once(options, status);
  status.clear();
  if (!outcome) return fail(outcome.error());
  if (options.virtual_time) {
    const double lasted = std::chrono::duration<double>(outcome->findings.lasted).count();
    fmt::print(stderr, "navigation: {:.1f} s of virtual time in {:.1f} s, {:.2g} times as fast as real time\n", lasted,
               outcome->took_seconds, lasted / outcome->took_seconds);
  }
  return print(options.json ? to_json(*outcome) : to_text(*outcome), outcome->signal);
}

int run_many(const Options& options) {
  StatusLine status;
  const auto batch = run_batch(
      options, [&status](const Options& one) { return run_once(one, status); },
      [&status](const std::string& line) {
        status.clear();
        fmt::print(stderr, "navigation: {}\n", line);
      });
  if (!batch) return fail(batch.error());
  return print(options.json ? to_json(*batch) : to_text(*batch), batch->signal);
}

}  // namespace
}  // namespace ctn::navigation::run

int main(int argc, char** argv) {
  using namespace ctn::navigation::run;
  const auto parsed = parse_options(argc, argv);
  if (const auto* leave = std::get_if<Leave>(&parsed)) {
    fmt::print(leave->code == 0 ? stdout : stderr, "{}", leave->text);
    return leave->code;
  }
  std::signal(SIGINT, remember_signal);
  std::signal(SIGTERM, remember_signal);
  const auto& options = std::get<Options>(parsed);
  return options.runs > 1 || !options.out.empty() ? run_many(options) : run_single(options);
}
