// Whether the robot can keep clear of what moves, if it now drives at some velocity.
//
// What moves is expected to go on as it does (a velocity obstacle in time: Fiorini and Shiller, "Motion planning in
// dynamic environments using velocity obstacles", 1998), until it comes to where its course ended before; and to take
// up its pace again, where it is slower. It may also stop or turn back at any time, so that all of its course counts
// that it can reach by then; where its course is known to end ahead, it turns back no earlier than there. What stands
// may start at any time, in either direction. All of this begins when it was seen last, not now.
//
// The robot takes up the velocity as fast as its base can, keeps it until it can react or longer, and then does one of
// a few simple things: stops and waits, goes straight ahead as fast as it may, backs up, or goes on. A velocity is safe
// if one of these leads past everything: the robot need not know yet which it will choose, only that one is left
// (Fraichard and Asama, "Inevitable collision states", 2004).
//
// Units: metres, radians, seconds. Thread safety: one thread an object.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry.h"
#include "local_mapper.h"
#include "robot.h"
#include "sensors.h"
#include "work.h"

namespace ctn::navigation {

class Foresight {
 public:
  static constexpr double kHorizon = 3.0;
  static constexpr double kMargin = 0.1;  // kept from what moves
  // What that is, and doubt of where it will be, from a square as large as the robot; more room is worth nothing extra.
  static constexpr double kRoom = 0.3;

  // The better ones last.
  enum class Level : std::uint8_t {
    kContact,      // contact, whatever the robot does
    kGrazing,      // none with a box that does not turn a corner to the robot
    kTooNear,      // none, but it comes nearer than it should
    kIfItGoesOn,   // none, if all goes on as it does
    kByBackingUp,  // none, if the robot backs up
    kSafe,
  };
  struct Safety {
    Level level = Level::kContact;
    double contact_after = 0.0;  // with kContact: how long it can be put off
    // Metres: with kGrazing and kTooNear what is left of the room that there should be, with kIfItGoesOn what lacks of
    // it to courses, as a number below zero.
    double room = 0.0;
  };

  // `reaction`: until the robot can do something else. `caution` in [0, 1]: how far along its course what moves may
  // get, as a share of what it can; what stands may get all of it. `limits.speed`: forwards.
  Foresight(const LocalMap& map, const Odometry& odometry, double reaction, double caution, const RobotLimits& limits);

  // Whether anything that moves can come near within the horizon. If not, all velocities are safe.
  bool concerned() const { return !things_.empty(); }
  Safety of(const Velocity& velocity);
  // How long the robot keeps clear of all if it does nothing else but go on at this velocity; at most the horizon.
  double clear_for(const Velocity& velocity);

  const Work& work() const { return work_; }

 private:
  struct Thing {
    MovingObstacle moving;  // at the scan's instant
    // From the robot's outline to the centre:
    double kept;   // what should be
    double now;    // what is
    double hard;   // less is contact, if it turns a corner to the robot
    double side;   // less is contact
    double share;  // of the way along its course that it can have made since it was seen
    double kept_from_course;
    bool will_be_faster;

    Point on_course(Point point, double seconds) const;
  };
  struct Moment {
    Pose pose;
    Velocity velocity;
    double seconds = 0.0;
    bool off_courses = true;  // until now
    double clear_until = kHorizon;
    double room = kRoom;  // the least to any thing
    double room_beside_courses = 0.0;
    bool grazes = false;
  };
  enum class Met : std::uint8_t { kNothing, kWall, kThing };

  void advance(Moment& moment, const Velocity& wanted) const;
  Met meets(Moment& moment);
  bool is_come_upon(const Pose& pose) const;
  // Goes on at `wanted` until the horizon or until something is met.
  Met follow(Moment& moment, const Velocity& wanted);

  const LocalMap& map_;
  RobotLimits limits_;
  double reaction_;
  double age_;
  double static_margin_;
  Moment start_;
  std::vector<Thing> things_;
  Work work_;
};

}  // namespace ctn::navigation
