// The simulated robot in its world: it drives as commanded, its laser scans, its odometry drifts, and contact with
// walls and movers is found at its instant.
//
// Time passes in steps of 1 ms: advance() takes all steps that have ended by then. So the result does not depend on how
// often it is called, and is the same to the bit for the same file, options and commands. A command is in force from
// the first step that does not begin before it. Within a step the speeds change evenly, as the limits allow, and the
// robot follows an arc.
//
// Scans and odometry exist at multiples of 20 ms alone: reading one again gives the same one. A scan is computed
// when it is first read, from where the robot was at its instant; a scan that is never read costs nothing.
//
// While nothing is near, contact is not looked for until robot and movers can have covered the distance. Otherwise each
// step is checked, and in a step that ends in contact the instant is found by bisection.
//
// Units: metres, radians, m/s, rad/s; times as nanoseconds since the world began.
// Thread safety: one thread at a time. All worlds of a program should be used by one thread (scene.h).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry.h"
#include "grid.h"
#include "program/random.h"
#include "robot.h"
#include "scene.h"
#include "sensors.h"
#include "world_file.h"

namespace ctn::navigation::world {

inline constexpr std::chrono::nanoseconds kWorldStep = std::chrono::milliseconds(1);
inline constexpr std::chrono::nanoseconds kSensorPeriod = std::chrono::milliseconds(20);  // of laser and odometry
inline constexpr double kGoalRadius = 0.3;  // no farther from it, the robot has reached the goal
inline constexpr double kSeenCell = 0.1;    // side of a cell of the grid of what was seen

struct Laser {
  std::size_t beams = 721;
  double field = std::numbers::pi;
  double range = 30.0;
  double noise = 0.01;  // standard deviation of a range
};

enum class AfterContact {
  kStop,  // the robot stops, and cannot go further into a wall; a mover passes through the robot
  kEnd,   // the robot stops for good
};

struct WorldOptions {
  std::uint64_t seed = 1;  // of noise, drift, and the phases that the file leaves open
  RobotLimits limits;
  Laser laser;
  OdometryNoise drift;
  AfterContact after_contact = AfterContact::kStop;
};

struct Contact {
  std::chrono::nanoseconds at{};
  std::optional<std::size_t> mover;  // none: a wall
  Pose pose;
  double speed = 0.0;  // of the robot, just before
};

struct Score {
  std::vector<Contact> contacts;
  double travelled = 0.0;                              // length of the way, backwards included
  std::optional<std::chrono::nanoseconds> reached_at;  // the goal, for the first time
  double explored = 0.0;  // share of the free space that has been in the laser's view; in worlds without a goal
};

class World {
 public:
  struct Motion {  // of one step
    double speed = 0.0;
    double turn_rate = 0.0;
    double speed_after = 0.0;
    double turn_rate_after = 0.0;
  };

  World(const WorldFile& file, const WorldOptions& options);

  // The robot is to drive at this velocity from `time` on, or from now on if that is past, as far as its limits allow.
  // Advances the world to `time` first.
  void command(std::chrono::nanoseconds time, const Velocity& velocity);
  void advance(std::chrono::nanoseconds time);
  std::chrono::nanoseconds now() const { return kWorldStep * step_; }

  // The newest one that is not after `time`. The odometry begins at the true start. Advances the world to `time` first.
  // Precondition: time >= 0.
  const Scan& scan_at(std::chrono::nanoseconds time);
  const Odometry& odometry_at(std::chrono::nanoseconds time);

  // For scores and pictures; the robot does not know it.
  const Pose& truth() const { return pose_; }
  const Pose& truth_at(std::chrono::nanoseconds time);  // at the last multiple of 20 ms until then
  double speed() const { return speed_; }
  double turn_rate() const { return turn_rate_; }
  bool ended() const { return ended_; }
  Score score() const;
  double travelled() const { return travelled_; }
  const std::vector<Contact>& contacts() const { return contacts_; }

  const WorldFile& file() const { return file_; }
  const Scene& scene() const { return scene_; }
  const WorldOptions& options() const { return options_; }
  const std::optional<Explored>& explored() const { return explored_; }

 private:
  struct Command {
    std::int64_t from_step = 0;
    Velocity velocity;
  };
  struct Instant {
    Pose truth;
    Odometry odometry;
  };

  void step();
  // Which part of the step the robot drives before something stops it; 1: nothing does. If it already pushes against a
  // wall, no motion is left.
  double driven_share(Motion& motion);
  double distance_to(std::size_t obstacle, const Pose& pose, double time) const;
  double first_touch(std::size_t obstacle, const Motion& motion) const;
  void take_instant();
  void look_around();
  std::size_t instant_at(std::chrono::nanoseconds time);

  WorldFile file_;
  WorldOptions options_;
  Scene scene_;
  program::Noise range_noise_;
  program::Noise drift_noise_;
  std::int64_t step_ = 0;  // the next one
  Command current_;
  Command next_;  // in force from its step on
  Pose pose_;
  double speed_ = 0.0;
  double turn_rate_ = 0.0;
  double travelled_ = 0.0;
  // Driven and turned since the last odometry.
  double distance_since_ = 0.0;
  double turn_since_ = 0.0;
  std::vector<Instant> instants_;  // one every 20 ms
  Scan scan_;
  std::optional<std::size_t> scan_of_;  // the instant that `scan_` is of
  std::vector<char> touching_;          // obstacles: the movers, then the walls
  std::int64_t clear_until_ = 0;        // until this step nothing can touch the robot
  double closing_speed_ = 0.0;          // the highest speed at which robot and movers can come nearer
  std::vector<Contact> contacts_;
  bool ended_ = false;
  std::optional<std::chrono::nanoseconds> reached_at_;
  std::optional<Explored> explored_;
};

}  // namespace ctn::navigation::world
