#include "run/virtual_run.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "catan/simulation.h"
#include "program/run_options.h"
#include "run/album.h"
#include "run/nodes.h"
#include "run/objective.h"
#include "run/replay.h"

namespace ctn::navigation::run {
namespace {

using std::chrono::nanoseconds;

// Whether the run is over is looked at no more often, so that it does not depend on the step.
constexpr nanoseconds kLook = std::chrono::milliseconds(500);

class VirtualHardware final : public Hardware {
 public:
  VirtualHardware(Drive& drive, const Simulation& simulation) : drive_(drive), simulation_(simulation) {}

  nanoseconds now() const override { return simulation_.now(); }
  std::shared_ptr<const Reading> laser() override { return drive_.laser(now()); }
  Odometry odometry() override { return drive_.odometry(now()); }
  void move(Motion motion) override {
    motion.at = now();
    drive_.move(motion);
  }
  void guided(Guidance guidance) override {
    guidance.at = now();
    drive_.guided(guidance);
  }
  void planned(Planned planned) override {
    planned.at = now();
    drive_.planned(planned);
  }
  void detected(Detected detected) override {
    detected.at = now();
    drive_.detected(detected);
  }

 private:
  Drive& drive_;
  const Simulation& simulation_;
};

}  // namespace

Result<Outcome> run_virtually(const Options& options, const world::WorldFile& world,
                              const std::shared_ptr<DetectorChain>& detector, const Watch& watch) {
  const auto started = std::chrono::steady_clock::now();
  auto simulation = Simulation::open(options.app_file, program::simulation_options(options));
  if (!simulation) return simulation.error();
  Drive drive(world, options.seed);
  VirtualHardware hardware(drive, *simulation);
  Nodes nodes(hardware, world.goal, detector);
  nodes.attach(*simulation);

  std::optional<Album> album;
  if (!options.pictures.empty()) {
    auto opened = Album::open(options.pictures, world, drive.world().scene().movers());
    if (!opened) return opened.error();
    album.emplace(std::move(opened).value());
  }

  std::optional<Replay> replay;
  if (!options.replay.empty()) replay.emplace(world, drive.world().scene().movers(), options.seconds);

  ObjectiveByTime objective;
  Outcome outcome = outcome_of_run(options, world);
  const nanoseconds end(std::llround(options.seconds * 1e9));
  while (simulation->now() < end && outcome.signal == 0) {
    const nanoseconds now = simulation->now();
    if (now % kLook == nanoseconds(0) && drive.over()) break;
    const nanoseconds look = replay ? kFramePeriod : kLook;
    const nanoseconds until = std::min({now + watch.step, (now / look + 1) * look, end});
    if (Status ran = simulation->run_for(until - now); !ran) return ran.error();
    drive.advance(simulation->now());
    if (watch.signal) outcome.signal = watch.signal();
    if (watch.show) watch.show(drive.progress());
    if (objective.due(simulation->now())) objective.add(simulation->now(), simulation->snapshot());
    if (replay && simulation->now() % kFramePeriod == nanoseconds(0)) replay->add(frame_of(drive));
    if (!album || simulation->now() % kPicturePeriod != nanoseconds(0)) continue;
    if (Status drawn = album->draw(moment_of(drive)); !drawn) return drawn.error();
  }
  if (Status finished = simulation->finish(); !finished) return finished.error();
  outcome.findings = drive.findings();
  outcome.snapshot = simulation->snapshot();
  outcome.objective_by_time = objective.values();
  if (replay) {
    if (Status written = replay->write(outcome, options.replay); !written) return written.error();
  }
  outcome.took_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return outcome;
}

}  // namespace ctn::navigation::run
