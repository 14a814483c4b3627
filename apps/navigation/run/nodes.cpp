#include "run/nodes.h"

#include <cmath>
#include <utility>

#include "detector/cost.h"
#include "nodes/cost.h"
#include "program/slowed.h"

namespace ctn::navigation::run {
namespace {

template <class T>
using Shared = std::shared_ptr<const T>;

constexpr std::chrono::nanoseconds kLittle = std::chrono::microseconds(10);

// What the run's work was worth on the machine where the units were measured; at least what it takes to look at the
// inputs.
void charge(Run& run, Node node, const Work& work) {
  run.charge(kLittle + std::chrono::nanoseconds(std::llround(1e9 * cost(node, work))));
}

void charge(Run& run, const PictureWork& work) {
  run.charge(kLittle + std::chrono::nanoseconds(std::llround(1e9 * cost(work, 1.0))));
}

void charge_little(Run& run) { run.charge(kLittle); }

}  // namespace

Nodes::Nodes(Hardware& hardware, const std::optional<Point>& goal, std::shared_ptr<DetectorChain> detector)
    : hardware_(hardware), goal_(goal), detector_(std::move(detector)) {}

template <class Host>
void Nodes::add_local(Host& host, std::vector<Functions>& functions) {
  auto& readings = host.template channel<Shared<Reading>>("laser", "scan");
  auto& scans = host.template channel<SharedScan>("scan", "LM");
  auto& buffered = host.template queue<SharedScan>("scan", "GL");
  auto& odometry = host.template channel<Odometry>("odometry", "LM");
  auto& surroundings = host.template channel<Shared<Surroundings>>("LM", "LP");
  auto& commands = host.template channel<Shared<Command>>("NC", "LP");

  const auto read_odometry = [this, &odometry](Run& run) {
    odometry.write(run, hardware_.odometry());
    charge_little(run);
  };
  const auto read_laser = [this, &readings](Run& run) {
    readings.write(run, hardware_.laser());
    charge_little(run);
  };
  const auto scan = [this, &readings, &scans, &buffered](Run& run) {
    const Shared<Reading>* reading = readings.read(run);
    if (reading == nullptr || (*reading)->scan.stamp == newest_scan_) {
      charge_little(run);
      return run.skip_output();
    }
    newest_scan_ = (*reading)->scan.stamp;
    ScanFilter::Result result = filter_.run((*reading)->scan, (*reading)->odometry);
    scans.write(run, result.scan);
    buffered.write(run, std::move(result.scan));
    charge(run, Node::kScanFilter, result.work);
  };
  const auto local_map = [this, &scans, &odometry, &surroundings](Run& run) {
    const SharedScan* newest = scans.read(run);
    if (newest == nullptr) {
      charge_little(run);
      return run.skip_output();
    }
    LocalMapper::Result result = local_mapper_.run(**newest);
    surroundings.write(
        run, std::make_shared<const Surroundings>(surroundings_of(std::move(result.map), odometry.read(run))));
    charge(run, Node::kLocalMapper, result.work);
  };
  const auto local_plan = [this, &surroundings, &commands](Run& run) {
    const Shared<Surroundings>* around = surroundings.read(run);
    if (around == nullptr) {
      charge_little(run);
      return run.skip_output();
    }
    const Shared<Command>* command = commands.read(run);
    const LocalPlanner::Result result =
        local_planner_.run(*(*around)->map, (*around)->odometry, command != nullptr ? **command : Command{});
    motion_ = Motion{{}, result.velocity, (*around)->map};
    charge(run, Node::kLocalPlanner, result.work);
  };
  functions.push_back({"laser", read_laser, {}});
  functions.push_back({"odometry", read_odometry, {}});
  functions.push_back({"scan", scan, {}});
  functions.push_back({"LM", local_map, {}});
  functions.push_back({"LP", local_plan, [this](Run&) {
                         if (motion_) hardware_.move(*std::exchange(motion_, std::nullopt));
                       }});
}

template <class Host>
void Nodes::add_global(Host& host, std::vector<Functions>& functions) {
  auto& buffered = host.template queue<SharedScan>("scan", "GL");
  auto& to_mapper = host.template channel<Shared<Fix>>("GL", "GM");
  auto& to_planner = host.template channel<Shared<Fix>>("GL", "GP");
  auto& to_commander = host.template channel<Shared<Fix>>("GL", "NC");
  auto& maps = host.template channel<SharedMap>("GM", "GP");
  auto& paths = host.template channel<Shared<Path>>("GP", "NC");
  auto& commands = host.template channel<Shared<Command>>("NC", "LP");

  const auto localize = [this, &buffered, &to_mapper, &to_planner, &to_commander](Run& run) {
    std::vector<SharedScan> scans;
    while (auto next = buffered.take(run)) scans.push_back(std::move(*next));
    if (scans.empty()) {
      charge_little(run);
      return run.skip_output();
    }
    GlobalLocalizer::Result result = localizer_.run(scans);
    const auto fix = std::make_shared<const Fix>(Fix{std::move(result.localization), scans.back()->odometry});
    to_commander.write(run, fix);
    to_planner.write(run, fix);
    if (result.news) to_mapper.write(run, fix);
    run.set_mode(static_cast<std::uint32_t>(result.mode));
    charge(run, Node::kGlobalLocalizer, result.work);
  };
  const auto map = [this, &to_mapper, &maps](Run& run) {
    const Shared<Fix>* fix = to_mapper.read(run);
    if (fix == nullptr) {
      charge_little(run);
      return run.skip_output();
    }
    GlobalMapper::Result result = mapper_.run((*fix)->localization);
    maps.write(run, std::move(result.map));
    charge(run, Node::kGlobalMapper, result.work);
  };
  const auto plan = [this, &to_planner, &maps, &paths](Run& run) {
    const Shared<Fix>* fix = to_planner.read(run);
    const SharedMap* newest = maps.read(run);
    if (fix == nullptr || newest == nullptr) {
      charge_little(run);
      return run.skip_output();
    }
    GlobalPlanner::Result result = planner_.run(**newest, (*fix)->localization, goal_);
    const auto path = std::make_shared<const Path>(std::move(result.path));
    planned_ = Planned{{}, path, *newest};
    paths.write(run, path);
    charge(run, Node::kGlobalPlanner, result.work);
  };
  const auto command = [this, &to_commander, &paths, &commands](Run& run) {
    const Shared<Fix>* fix = to_commander.read(run);
    const Shared<Path>* path = paths.read(run);
    if (fix == nullptr || path == nullptr) {
      charge_little(run);
      return run.skip_output();
    }
    const NavigationCommand::Result result = commander_.run(**path, (*fix)->localization, (*fix)->odometry);
    guidance_ = Guidance{{}, result.command.stamp, (*fix)->localization.pose_at((*fix)->odometry)};
    commands.write(run, std::make_shared<const Command>(result.command));
    charge(run, Node::kNavigationCommand, result.work);
  };
  functions.push_back({"GL", localize, {}});
  functions.push_back({"GM", map, {}});
  functions.push_back({"GP", plan, [this](Run&) {
                         if (planned_) hardware_.planned(*std::exchange(planned_, std::nullopt));
                       }});
  functions.push_back({"NC", command, [this](Run&) {
                         if (guidance_) hardware_.guided(*std::exchange(guidance_, std::nullopt));
                       }});
}

template <class Host>
void Nodes::add_detector(Host& host, std::vector<Functions>& functions, Seeing seeing) {
  auto& pictures = host.template channel<Picture>("preprocess", "detect");
  const auto preprocess = [this, &pictures, seeing](Run& run) {
    Picture picture;
    if (seeing == Seeing::kReally) {
      auto prepared = detector_->prepare(detector_->frame_at(hardware_.now()));
      if (!prepared) return run.skip_output();
      picture = std::make_shared<const Prepared>(std::move(prepared).value());
    }
    pictures.write(run, std::move(picture));
    charge(run, detector_->preprocess_work());
  };
  const auto detect = [this, &pictures, seeing](Run& run) {
    const Picture* picture = pictures.read(run);
    if (picture == nullptr) {
      charge_little(run);
      return run.skip_output();
    }
    if (seeing == Seeing::kReally) detector_->detect(**picture);
    detected_ = Detected{};
    charge(run, detector_->detect_work());
  };
  functions.push_back({"preprocess", preprocess, {}});
  functions.push_back({"detect", detect, [this](Run&) {
                         if (detected_) hardware_.detected(*std::exchange(detected_, std::nullopt));
                       }});
}

template <class Host>
std::vector<Nodes::Functions> Nodes::functions(Host& host, Seeing seeing) {
  std::vector<Functions> all;
  add_local(host, all);
  add_global(host, all);
  if (detector_) add_detector(host, all, seeing);
  return all;
}

void Nodes::attach(Session& session, double slowdown, program::CostMeter& meter) {
  for (Functions& functions : this->functions(session, Seeing::kReally)) {
    session.node(functions.node, meter.metered(functions.node, program::slowed(std::move(functions.body),
                                                                               std::move(functions.effect), slowdown)));
  }
}

void Nodes::attach(Simulation& simulation) {
  for (Functions& functions : this->functions(simulation, Seeing::kCounted)) {
    simulation.node(functions.node, functions.body);
    if (functions.effect) simulation.on_effect(functions.node, functions.effect);
  }
}

}  // namespace ctn::navigation::run
