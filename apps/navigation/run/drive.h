// One run of the robot in its world, and what is measured of it. Knows the truth, which the nodes do not.
//
// The world is advanced from instant to instant of the sensors (20 ms), so that what is found does not depend on how
// often or by whom it is advanced. Besides contacts, way and exploration, which the world counts:
//
// Staleness. Each time NC gives a command: how old the odometry is that the command goes back to. Each time LP gives a
// velocity: how old the scan is. Both count from the instant of the scan, not from when it was read.
//
// Appearances. A mover appears at the first instant of the laser at which at least kBeamsToSee beams hit it in the
// robot's way: the strip straight ahead of the robot, kWayWidth wide, up to kWayLength from the robot's centre. The
// reaction is the first velocity of LP that was chosen on a local map which shows the mover there: a cell that is an
// obstacle no farther than kShownWithin from where a beam of the map's scan hit the mover in the strip. So the reaction
// time includes waiting for the laser to be read, computing, and how many scans the local map needs to believe what it
// sees, but not whether the velocity is a good one, nor whether another would have been chosen without the mover. A
// mover that leaves the strip for kGone may appear again; one that leaves it before any map showed it was missed.
//
// The drive ends when the goal is reached, or when GP has found nothing left to explore for kNothingLeftFor.
//
// Units: metres; times in nanoseconds since the run began. Thread safety: one thread at a time.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "run/hardware.h"
#include "run/measures.h"
#include "world/world.h"

namespace ctn::navigation::run {

struct Appearance {
  std::chrono::nanoseconds at{};
  std::size_t mover = 0;
  std::optional<std::chrono::nanoseconds> reaction;  // none: it was missed
  bool operator==(const Appearance&) const = default;
};

enum class Ending { kTime, kGoal, kExplored };

struct Findings {
  Ending ending = Ending::kTime;
  std::chrono::nanoseconds lasted{};
  std::vector<world::Contact> contacts;
  double way = 0.0;
  std::optional<std::chrono::nanoseconds> reached_at;
  double explored = 0.0;                                   // share of the free space
  std::optional<std::chrono::nanoseconds> explored_90_at;  // to half a second
  std::vector<AgeSample> guidance_ages;                    // of the odometry behind NC's commands
  std::vector<double> pose_errors;                         // metres, of the poses behind these commands
  std::vector<AgeSample> scan_ages;                        // of the scans behind LP's velocities
  std::vector<Appearance> appearances;                     // in the order of their times
  std::vector<std::chrono::nanoseconds> detections;        // when the detector gave an output
};

// How far a run has come.
struct Progress {
  std::chrono::nanoseconds at{};
  double way = 0.0;
  double explored = 0.0;
  std::size_t contacts = 0;
  bool over = false;
};

class Drive {
 public:
  static constexpr std::size_t kBeamsToSee = 3;
  static constexpr double kWayLength = 2.0;
  static constexpr double kWayWidth = 0.76;  // the robot's, and 0.1 m to each side
  static constexpr double kShownWithin = 0.06;
  static constexpr std::chrono::nanoseconds kGone = std::chrono::seconds(1);
  static constexpr std::chrono::nanoseconds kNothingLeftFor = std::chrono::seconds(10);

  Drive(const world::WorldFile& file, std::uint64_t seed);

  // Each advances the world to `time` first; times must not decrease.
  std::shared_ptr<const Reading> laser(std::chrono::nanoseconds time);
  Odometry odometry(std::chrono::nanoseconds time);
  void move(const Motion& motion);
  void guided(const Guidance& guidance);
  void planned(const Planned& planned);
  void detected(const Detected& detected);
  void advance(std::chrono::nanoseconds time);

  // Nothing that happens afterwards counts.
  bool over() const { return ended_at_.has_value(); }
  Findings findings() const;

  world::World& world() { return world_; }
  const Planned& plan() const { return plan_; }     // GP's newest
  const Motion& motion() const { return motion_; }  // LP's newest
  Progress progress() const;

 private:
  struct Watched {  // a mover
    bool in_way = false;
    std::chrono::nanoseconds last_seen{};
    std::optional<std::size_t> open;  // the appearance that waits for its reaction
  };

  void observe(std::chrono::nanoseconds instant);
  void look_for_movers(std::chrono::nanoseconds instant);
  // Where beams hit the mover in the robot's way at an instant of the laser, as seen from the robot.
  std::vector<Point> hits_in_way(std::size_t mover, std::chrono::nanoseconds instant);
  void end(Ending ending, std::chrono::nanoseconds at);

  world::World world_;
  std::chrono::nanoseconds next_instant_{};
  std::shared_ptr<const Reading> reading_;
  Planned plan_;
  Motion motion_;
  std::vector<Watched> movers_;
  std::optional<std::chrono::nanoseconds> nothing_left_since_;
  std::optional<std::chrono::nanoseconds> ended_at_;
  Findings findings_;
};

}  // namespace ctn::navigation::run
