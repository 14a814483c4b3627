#include "virtual_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "footage.h"
#include "lens.h"
#include "nodes.h"

namespace ctn::face_tracking {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kStep = std::chrono::milliseconds(500);

double seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

Result<Outcome> run_virtually(const Options& options, const Watch& watch) {
  const FootageFiles files{.faces = options.faces};
  auto detector = Detector::open(files.cascade());
  if (!detector) return detector.error();
  auto simulation = Simulation::open(options.app_file, {.costs = options.costs,
                                                        .slowdown = options.slowdown,
                                                        .policy = options.scheduler,
                                                        .cores = options.cores,
                                                        .seed = options.seed,
                                                        .record = options.record,
                                                        .note = note_of(options)});
  if (!simulation) return simulation.error();
  auto footage = load_footage(files);
  if (!footage) return footage.error();

  const View view(std::move(footage).value(), options.seed);
  const Stopwatch clock;
  const auto now = [&] { return seconds(simulation->now()); };
  World world(Path(options.speed, options.seed), kHalfView);
  Nodes nodes(world, view, now, std::move(detector).value(), options.seed);
  nodes.attach(*simulation);

  Outcome outcome;
  outcome.options = options;
  const nanoseconds warm = simulation->warm_from();
  const nanoseconds end = warm + nanoseconds(std::llround(options.seconds * 1e9));
  while (simulation->now() < end && outcome.signal == 0) {
    const nanoseconds until = simulation->now() < warm ? warm : end;
    if (Status ran = simulation->run_for(std::min(kStep, until - simulation->now())); !ran) return ran.error();
    world.advance(now());
    if (simulation->now() == warm) {
      nodes.restart_sightings();
      world.begin_measuring(now());
    }
    outcome.signal = watch.signal();
    watch.show(status_line(now(), simulation->snapshot(), world.tracking()));
  }
  if (Status finished = simulation->finish(); !finished) return finished.error();
  outcome.snapshot = simulation->snapshot();
  outcome.tracking = world.tracking();
  outcome.sightings = nodes.sightings();
  outcome.seconds = std::max(0.0, seconds(simulation->now() - warm));
  outcome.virtual_seconds = now();
  outcome.took_seconds = clock.now();
  return outcome;
}

}  // namespace ctn::face_tracking
