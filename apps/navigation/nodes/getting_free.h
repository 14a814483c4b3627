// Whether the base does what it is told, and what to do if not: something holds the robot that the local map does not
// show, as it is behind the robot, where the laser sees nothing, or not where the map has it.
//
// If the wheels have counted nothing for most of a second in which the robot was to move, it is taken to be held from
// behind: it goes straight ahead for a foot's length, where the laser sees, and does not back up again for a while. If
// it was told to go straight ahead and that does not move it either, it goes back, and so on in turn. Where the map
// does not let it go ahead it stands (local_planner.h), gives up, and goes by the map again.
//
// Units: metres, radians, seconds. Thread safety: one thread an object.
#pragma once

#include <chrono>
#include <optional>

#include "geometry.h"
#include "sensors.h"

namespace ctn::navigation {

class GettingFree {
 public:
  static constexpr double kHeldFor = 0.8;  // longer than the base takes to begin to move, under any scheduler
  static constexpr double kWay = 0.25;     // after which the robot is free
  static constexpr double kGiveUp = 4.0;   // likewise
  static constexpr double kSpeed = 0.2;    // at which it gets free
  static constexpr double kNotBackFor = 10.0;

  // What the wheels have counted by now, and what the robot was told until now. Counts with stamps that are not later
  // than the last one's tell nothing, nor do those after a pause of more than a second.
  void feel(const Odometry& counted, const Velocity& told);

  // While it gets free, the speed at which it should go straight on: below 0 backwards.
  std::optional<double> speed() const { return speed_; }
  bool may_back_up() const { return not_back_for_ <= 0.0; }

 private:
  std::optional<std::chrono::nanoseconds> stamp_;
  double held_ = 0.0;  // seconds
  std::optional<double> speed_;
  Point from_;  // where it began to get free
  double getting_free_ = 0.0;
  double not_back_for_ = 0.0;
};

}  // namespace ctn::navigation
