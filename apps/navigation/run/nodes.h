// The app's nodes: what each does in a run, and the channels between them. The only file that knows both whoever runs
// them (a session, or a simulation) and the algorithms. Here the robot is told what to do: LP's velocity goes to the
// base when LP's run ends.
//
//   scan   reads the laser; hands on a scan that is new, and no scan twice
//   LM     the map around the robot, and the newest odometry
//   LP     the velocity
//   GL     the pose, for each batch of scans; keyframes go to GM only when there are new ones
//   GM     the map of everything
//   GP     the path to the goal or to the nearest frontier
//   NC     the point to head for, from the pose that GL gave last
//   preprocess, detect   where there is a detector: a picture of the camera, and what is found in it
//
// Values are shared and never change once they are written. In a virtual run each run charges what its work was worth
// (cost.h).
//
// Thread safety: construct and attach from one thread; a session then runs each node in a thread of its own.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "catan/session.h"
#include "catan/simulation.h"
#include "nodes/global_localizer.h"
#include "nodes/global_mapper.h"
#include "nodes/global_planner.h"
#include "nodes/handed_on.h"
#include "nodes/local_mapper.h"
#include "nodes/local_planner.h"
#include "nodes/navigation_command.h"
#include "nodes/scan_filter.h"
#include "program/calibration.h"
#include "run/detector_chain.h"
#include "run/hardware.h"

namespace ctn::navigation::run {

class Nodes {
 public:
  // `hardware` must outlive the session's threads (or the simulation), as must this object. `goal`: in the map's frame,
  // which begins as the world's; none: the robot explores. `detector`: null where there is none.
  Nodes(Hardware& hardware, const std::optional<Point>& goal, std::shared_ptr<DetectorChain> detector);

  // Gives the session all functions. Each run burns `slowdown` - 1 times its own CPU time more. `meter`: of what runs
  // cost; must outlive the session's threads.
  void attach(Session& session, double slowdown, program::CostMeter& meter);
  // The same in virtual time, where what a run does to the robot happens when the run ends.
  void attach(Simulation& simulation);

 private:
  using Body = std::function<void(Run&)>;
  struct Functions {
    const char* node;
    Body body;
    Body effect;  // on the robot, when the run ends; may be none
  };

  // Whether the detector's nodes compute anything, or only charge what that is worth (detector_chain.h).
  enum class Seeing { kReally, kCounted };
  using Picture = std::shared_ptr<const Prepared>;  // null where nothing is computed

  template <class Host>
  std::vector<Functions> functions(Host& host, Seeing seeing);
  template <class Host>
  void add_local(Host& host, std::vector<Functions>& functions);
  template <class Host>
  void add_global(Host& host, std::vector<Functions>& functions);
  template <class Host>
  void add_detector(Host& host, std::vector<Functions>& functions, Seeing seeing);

  Hardware& hardware_;
  std::optional<Point> goal_;
  ScanFilter filter_;
  LocalMapper local_mapper_;
  LocalPlanner local_planner_;
  GlobalLocalizer localizer_;
  GlobalMapper mapper_;
  GlobalPlanner planner_;
  NavigationCommand commander_;
  std::shared_ptr<DetectorChain> detector_;
  std::chrono::nanoseconds newest_scan_{-1};
  // What a run is to do to the robot when it ends; each is its node's own.
  std::optional<Motion> motion_;
  std::optional<Guidance> guidance_;
  std::optional<Planned> planned_;
  std::optional<Detected> detected_;
};

}  // namespace ctn::navigation::run
