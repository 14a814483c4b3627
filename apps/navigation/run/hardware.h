// The robot as its nodes see it: a laser, wheels that count, and a base that is told how fast to move. One interface
// for the robot in virtual time and for the one that a thread of its own simulates. The nodes also tell it what they
// did, for the figures of the run (drive.h).
//
// Units: metres, radians; times in nanoseconds since the run began.
// Thread safety: laser() from one thread at a time, odometry(), move(), guided(), planned() and detected() likewise,
// each from its own; now() from any. No call waits for another thread.
#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include "nodes/global_planner.h"
#include "nodes/local_mapper.h"
#include "sensors.h"

namespace ctn::navigation::run {

// What the laser's driver gives: the newest scan, and where the wheels say the robot was at its instant.
struct Reading {
  Scan scan;
  Odometry odometry;
};

// LP told the base how to move.
struct Motion {
  std::chrono::nanoseconds at{};
  Velocity velocity;
  std::shared_ptr<const LocalMap> map;  // on which the velocity was chosen; null: not told, and no reaction is found
  // Of the scan that it goes back to, where the map is not told.
  std::optional<std::chrono::nanoseconds> stamp{};
};

// NC gave a command.
struct Guidance {
  std::chrono::nanoseconds at{};
  std::chrono::nanoseconds stamp{};  // of the odometry, and so of the scan, that the command goes back to
  Pose pose;                         // where GL took the robot to be at that instant
};

// GP gave a path.
struct Planned {
  std::chrono::nanoseconds at{};
  std::shared_ptr<const Path> path;
  SharedMap map;  // on which it was found
};

// The detector has looked at a picture.
struct Detected {
  std::chrono::nanoseconds at{};
};

class Hardware {
 public:
  virtual ~Hardware() = default;

  virtual std::chrono::nanoseconds now() const = 0;
  // Never null. There is a new one each 20 ms; until then the same is returned again.
  virtual std::shared_ptr<const Reading> laser() = 0;
  virtual Odometry odometry() = 0;

  // What happened just now; `at` is filled in.
  virtual void move(Motion motion) = 0;
  virtual void guided(Guidance guidance) = 0;
  virtual void planned(Planned planned) = 0;
  virtual void detected(Detected detected) = 0;
};

}  // namespace ctn::navigation::run
