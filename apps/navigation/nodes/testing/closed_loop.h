// The nodes in a loop with a world, in virtual time, each at a fixed rate: for tests and benchmarks.
//
// Thread safety: one thread an object.
#pragma once

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "nodes/global_localizer.h"
#include "nodes/global_mapper.h"
#include "nodes/global_planner.h"
#include "nodes/local_mapper.h"
#include "nodes/local_planner.h"
#include "nodes/navigation_command.h"
#include "nodes/scan_filter.h"
#include "nodes/testing/plant.h"

namespace ctn::navigation::testing {

class ClosedLoop {
 public:
  // Calls `run`, which runs the node and returns what it did. May measure.
  using Around = std::function<void(const char* node, const std::function<Work()>& run)>;

  ClosedLoop(Plant& world, std::optional<Point> goal, Around around = {})
      : world_(world), goal_(goal), around_(std::move(around)) {
    if (!around_) around_ = [](const char*, const std::function<Work()>& run) { run(); };
  }

  // Until the robot has arrived or explored all, at most for `seconds`.
  void run(double seconds) {
    run(seconds, [] { return false; });
  }
  // Or until `enough`, which is asked before each step.
  void run(double seconds, const std::function<bool()>& enough) {
    const double until = world_.time() + seconds;
    while (world_.time() < until - 1e-9 && !arrived() && !explored() && !enough()) step();
  }

  bool arrived() const { return command_.arrived; }
  bool explored() const { return path_.outcome == Path::Outcome::kNothingLeft; }
  const Localization& localization() const { return localization_; }
  const GlobalMap& map() const { return *map_; }
  const Path& path() const { return path_; }
  const Command& command() const { return command_; }

 private:
  static constexpr double kStep = 0.04;

  void step() {
    std::shared_ptr<const CleanScan> scan;
    const Scan raw = world_.scan();
    around_("scan", [&] {
      ScanFilter::Result result = filter_.run(raw, world_.odometry());
      scan = std::move(result.scan);
      return result.work;
    });
    buffered_.push_back(scan);
    around_("LM", [&] {
      LocalMapper::Result result = local_mapper_.run(*scan);
      local_map_ = std::move(result.map);
      return result.work;
    });
    if (steps_ % 5 == 0) localize();
    if (steps_ % 25 == 0) plan();
    if (steps_ % 3 == 0) {
      around_("NC", [&] {
        const NavigationCommand::Result result = commander_.run(path_, localization_, world_.odometry());
        command_ = result.command;
        return result.work;
      });
    }
    Velocity velocity;
    around_("LP", [&] {
      const LocalPlanner::Result result = local_planner_.run(local_map_, local_map_.odometry, command_);
      velocity = result.velocity;
      return result.work;
    });
    world_.advance(kStep, velocity);
    ++steps_;
  }

  void localize() {
    around_("GL", [&] {
      GlobalLocalizer::Result result = localizer_.run(buffered_);
      localization_ = std::move(result.localization);
      return result.work;
    });
    buffered_.clear();
  }

  void plan() {
    around_("GM", [&] {
      GlobalMapper::Result result = mapper_.run(localization_);
      map_ = std::move(result.map);
      return result.work;
    });
    around_("GP", [&] {
      GlobalPlanner::Result result = planner_.run(*map_, localization_, goal_);
      path_ = std::move(result.path);
      return result.work;
    });
  }

  Plant& world_;
  std::optional<Point> goal_;
  Around around_;
  std::uint64_t steps_ = 0;
  ScanFilter filter_;
  LocalMapper local_mapper_;
  LocalPlanner local_planner_;
  GlobalLocalizer localizer_;
  GlobalMapper mapper_;
  GlobalPlanner planner_;
  NavigationCommand commander_;
  std::vector<SharedScan> buffered_;
  LocalMap local_map_;
  Localization localization_;
  SharedMap map_;
  Path path_;
  Command command_;
};

}  // namespace ctn::navigation::testing
