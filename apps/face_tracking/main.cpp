// The face tracking app: reads the command line, lets the session (or, in virtual time, the simulation) run, prints
// what was measured.

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <thread>
#include <utility>

#include <opencv2/core.hpp>

#include "footage.h"
#include "lens.h"
#include "nodes.h"
#include "options.h"
#include "outcome.h"
#include "program/terminal.h"
#include "virtual_run.h"
#include "world_thread.h"

namespace ctn::face_tracking {
namespace {

using program::StatusLine;

constexpr const char* kProgram = "face_tracking";
constexpr double kWarmUpLimit = 30.0;  // seconds

SessionOptions session_options(const Options& options) {
  SessionOptions result;
  result.policy = options.scheduler;
  result.cpus = options.cpus;
  result.record = options.record;
  result.note = note_of(options);
  result.on_notice = [](const std::string& notice) { program::note(kProgram, notice); };
  return result;
}

// Waits until the session is warm and then for the time to measure, or for a signal. False: it never got warm.
bool let_run(const Session& session, const Stopwatch& clock, Nodes& nodes, WorldThread& world, Outcome& outcome) {
  constexpr auto kStep = std::chrono::milliseconds(50);
  StatusLine status;
  double measuring_since = -1.0;
  for (int step = 0; program::signal_so_far() == 0; ++step) {
    std::this_thread::sleep_for(kStep);
    const double now = clock.now();
    if (measuring_since >= 0.0 && now - measuring_since >= outcome.options.seconds) break;
    if (step % 10 != 0 && measuring_since >= 0.0) continue;
    const Snapshot snapshot = session.snapshot();
    if (measuring_since < 0.0 && snapshot.warmed_up) {
      measuring_since = now;
      nodes.restart_sightings();
      world.begin_measuring();
    }
    if (measuring_since < 0.0 && now > kWarmUpLimit * outcome.options.slowdown) return false;
    status.show(status_line(now, snapshot, world.tracking()));
  }
  status.clear();
  outcome.seconds = measuring_since < 0.0 ? 0.0 : clock.now() - measuring_since;
  return true;
}

int print(const Outcome& outcome) {
  return program::print(outcome.options.json ? to_json(outcome) : to_text(outcome), outcome.signal);
}

int run(const Options& options) {
  const FootageFiles files{.faces = options.faces};
  auto detector = Detector::open(files.cascade());
  if (!detector) return program::fail(kProgram, detector.error());
  auto session = Session::open(options.app_file, session_options(options));
  if (!session) return program::fail(kProgram, session.error());
  auto footage = load_footage(files);
  if (!footage) return program::fail(kProgram, footage.error());

  const View view(std::move(footage).value(), options.seed);
  const Stopwatch clock;
  World world(Path(options.speed, options.seed), kHalfView);
  Nodes nodes(
      world, view, [&clock] { return clock.now(); }, std::move(detector).value(), options.seed);
  nodes.attach(*session, options.slowdown);

  Outcome outcome;
  outcome.options = options;
  WorldThread world_thread(world, clock);
  if (Status started = session->start(); !started) return program::fail(kProgram, started.error());
  const bool warm = let_run(*session, clock, nodes, world_thread, outcome);
  world_thread.stop();
  outcome.tracking = world_thread.tracking();
  outcome.sightings = nodes.sightings();
  outcome.snapshot = session->snapshot();
  outcome.signal = program::signal_so_far();
  if (Status stopped = session->stop(); !stopped) return program::fail(kProgram, stopped.error());
  if (!warm) {
    return program::fail(kProgram,
                         Error::environment(fmt::format("not warm after {:.0f} s", kWarmUpLimit * options.slowdown),
                                            "are the CPUs in use by others?"));
  }

  return print(outcome);
}

int run_in_virtual_time(const Options& options) {
  StatusLine status;
  const auto outcome = run_virtually(
      options, {.signal = program::signal_so_far, .show = [&status](const std::string& line) { status.show(line); }});
  status.clear();
  if (!outcome) return program::fail(kProgram, outcome.error());
  fmt::print(stderr, "face_tracking: {:.1f} s of virtual time in {:.1f} s, {:.2g} times as fast as real time\n",
             outcome->virtual_seconds, outcome->took_seconds, outcome->virtual_seconds / outcome->took_seconds);
  return print(*outcome);
}

}  // namespace
}  // namespace ctn::face_tracking

int main(int argc, char** argv) {
  using namespace ctn::face_tracking;
  return ctn::program::run_program(parse_options(argc, argv), [](const Options& options) {
    cv::setNumThreads(1);  // a node is one thread: no pool of OpenCV's beside it
    return options.virtual_time ? run_in_virtual_time(options) : run(options);
  });
}
