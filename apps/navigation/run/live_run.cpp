#include "run/live_run.h"

#include <chrono>
#include <optional>
#include <thread>
#include <utility>

#include "catan/session.h"
#include "program/run_options.h"
#include "run/album.h"
#include "run/nodes.h"
#include "run/objective.h"
#include "run/replay.h"
#include "run/world_thread.h"

namespace ctn::navigation::run {
namespace {

constexpr std::chrono::seconds kMayBeginLate(10);
constexpr std::chrono::seconds kLeftOut(1);  // of what runs cost

// Takes longer than the world's thread may, so this is done here.
Status draw_all(WorldThread& robot, const std::optional<Album>& album) {
  while (const auto moment = robot.take_moment()) {
    if (Status drawn = album->draw(*moment); !drawn) return drawn;
  }
  return Done{};
}

void add_all(WorldThread& robot, std::optional<Replay>& replay) {
  while (const auto frame = robot.take_frame()) replay->add(*frame);
}

}  // namespace

Result<Outcome> run_live(const Options& options, const world::WorldFile& world,
                         const std::shared_ptr<DetectorChain>& detector, const LiveWatch& watch) {
  auto session = Session::open(options.app_file, program::session_options(options, watch.notice));
  if (!session) return session.error();
  Drive drive(world, options.seed);
  WorldThread robot(drive);
  Nodes nodes(robot, world.goal, detector);
  program::CostMeter meter(options.slowdown, kLeftOut);
  nodes.attach(*session, options.slowdown, meter);

  std::optional<Album> album;
  if (!options.pictures.empty()) {
    auto opened = Album::open(options.pictures, world, drive.world().scene().movers());
    if (!opened) return opened.error();
    album.emplace(std::move(opened).value());
    robot.keep_moments();
  }

  std::optional<Replay> replay;
  if (!options.replay.empty()) {
    replay.emplace(world, drive.world().scene().movers(), options.seconds);
    robot.keep_frames();
  }

  ObjectiveByTime objective;
  Outcome outcome = outcome_of_run(options, world);
  robot.start();
  if (Status started = session->start(); !started) return started.error();
  Status drawn = Done{};
  const std::chrono::duration<double> seconds(options.seconds);
  const auto at_last = std::chrono::steady_clock::now() + seconds + kMayBeginLate;
  while (robot.now() < seconds && outcome.signal == 0 && std::chrono::steady_clock::now() < at_last) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const Progress progress = robot.progress();
    if (progress.over) break;
    if (watch.signal) outcome.signal = watch.signal();
    if (watch.show) watch.show(progress);
    if (objective.due(robot.now())) objective.add(robot.now(), session->snapshot());
    add_all(robot, replay);
    drawn = draw_all(robot, album);
    if (!drawn) break;
  }
  outcome.snapshot = session->snapshot();
  outcome.objective_by_time = objective.values();
  Status stopped = session->stop();
  robot.stop();
  outcome.cost_ratios = meter.ratios();
  if (!stopped) return stopped.error();
  if (drawn) drawn = draw_all(robot, album);
  if (!drawn) return drawn.error();
  outcome.findings = drive.findings();
  outcome.world_thread = robot.use();
  if (replay) {
    add_all(robot, replay);
    if (Status written = replay->write(outcome, options.replay); !written) return written.error();
  }
  outcome.took_seconds = std::chrono::duration<double>(robot.now()).count();
  return outcome;
}

}  // namespace ctn::navigation::run
