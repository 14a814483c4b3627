#include "foresight.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "footprint.h"

namespace ctn::navigation {
namespace {

constexpr double kBeyondHorizon = 2.0;  // seconds
constexpr double kForesightStep = 0.1;
constexpr double kDoubt = 0.1;          // m/s by which the place of what moves grows uncertain
constexpr double kMaxDoubt = 0.15;      // metres
constexpr double kHardShare = 0.85;     // of the circle around a thing, of which it may leave corners free
constexpr double kSideShare = 0.72;     // of the circle around a square: the one within
constexpr double kHardMargin = 0.02;    // metres
constexpr double kComeApart = 0.15;     // m/s
constexpr double kCourseMargin = 0.06;  // kept from courses, which are straight
constexpr double kComeNoNearer = 0.01;  // metres by which it may, for the sake of rounding
constexpr double kEndMargin = 0.15;     // beyond where they are known to end
constexpr double kStaticMargin = 0.04;  // kept from what does not move, when giving way
constexpr double kBackUp = -0.5;        // m/s
constexpr double kDecideLater = 0.8;    // seconds for which a velocity may also be kept
constexpr double kDecideLast = 1.4;

double approach(double value, double wanted, double change) {
  return value + std::clamp(wanted - value, -change, change);
}

}  // namespace

Foresight::Foresight(const LocalMap& map, const Odometry& odometry, double reaction, double caution,
                     const RobotLimits& limits)
    : map_(map),
      limits_(limits),
      reaction_(reaction),
      age_(std::max(0.0, std::chrono::duration<double>(odometry.stamp - map.stamp).count())),
      static_margin_(kStaticMargin),
      start_{odometry.pose, odometry.velocity} {
  for (const MovingObstacle& moving : map.moving) {
    const Point centre = moving.at(age_);
    const double apart = distance_from_outline(odometry.pose, centre);
    const double kept = moving.radius + kMargin;
    const double hard = kHardShare * moving.radius + kHardMargin;
    const double side = kSideShare * moving.radius + kHardMargin;
    if (apart > kept + kMaxDoubt + moving.pace * (kHorizon + moving.unseen) + limits.speed * kHorizon) continue;
    const double now = std::max(0.0, apart - kComeNoNearer);
    Thing thing{moving,
                kept,
                now,
                std::min(hard, now),
                std::min(side, now),
                moving.moves() ? caution : 1.0,
                std::min(moving.radius + kCourseMargin, now),
                moving.will_be_faster()};
    // Where the robot is beside the course, but nearer than it should be, it should come no nearer.
    const Point nearest = thing.on_course(position(odometry.pose), age_ + kHorizon);
    const double beside = distance_from_outline(odometry.pose, nearest) - kComeNoNearer;
    if (beside >= thing.side) thing.kept_from_course = std::min(thing.kept_from_course, beside);
    things_.push_back(thing);
  }
  if (things_.empty()) return;
  static_margin_ = margin_kept(map, start_.pose, {kStaticMargin, kInNoObstacle}, work_).value_or(-kStaticMargin);
}

// The place nearest to `point` to which it may have come so long after the scan. Where it is not seen it is no farther
// ahead than what is expected, but for its pace, and may be as far back as if it had turned when it was seen last.
Point Foresight::Thing::on_course(Point point, double seconds) const {
  const double way = moving.pace * (moving.unseen + seconds);
  const double gone = moving.speed() * moving.unseen;  // of it, if it went on
  const bool goes_to_its_end = moving.moves() && std::isfinite(moving.ahead);
  const double back =
      goes_to_its_end ? share * way - gone - 2.0 * std::max(0.0, moving.ahead - kEndMargin) : share * (way + gone);
  const Point from = point - moving.centre;
  const double along = from.x * moving.course.x + from.y * moving.course.y;
  return moving.centre + moving.course * std::clamp(along, -std::clamp(back, 0.0, moving.behind + kEndMargin),
                                                    std::clamp(share * (way - gone), 0.0, moving.ahead + kEndMargin));
}

void Foresight::advance(Moment& moment, const Velocity& wanted) const {
  const double linear = approach(moment.velocity.linear, wanted.linear, limits_.acceleration * kForesightStep);
  const double angular = approach(moment.velocity.angular, wanted.angular, limits_.turn_acceleration * kForesightStep);
  const double way = 0.5 * (moment.velocity.linear + linear) * kForesightStep;
  const double turn = 0.5 * (moment.velocity.angular + angular) * kForesightStep;
  const double heading = moment.pose.heading + 0.5 * turn;
  moment.pose.x += way * std::cos(heading);
  moment.pose.y += way * std::sin(heading);
  moment.pose.heading += turn;
  moment.velocity = {linear, angular};
  moment.seconds += kForesightStep;
}

Foresight::Met Foresight::meets(Moment& moment) {
  const double since = age_ + moment.seconds;
  for (const Thing& thing : things_) {
    work_.candidates += 2;
    double apart = distance_from_outline(moment.pose, thing.moving.at(since));
    if (thing.will_be_faster) {
      ++work_.candidates;
      apart = std::min(apart, distance_from_outline(moment.pose, thing.moving.at_its_pace(since)));
    }
    if (apart < thing.side) return Met::kThing;
    moment.grazes = moment.grazes || apart < thing.hard;
    moment.room = std::min(moment.room, apart - thing.side);
    // If it is nearer already than it should be, both should come apart.
    const double wanted = thing.kept + std::min(kMaxDoubt, kDoubt * moment.seconds);
    if (apart < std::min(wanted, thing.now + kComeApart * moment.seconds)) {
      moment.clear_until = std::min(moment.clear_until, moment.seconds);
    }
    const Point nearest = thing.on_course(position(moment.pose), since);
    const double beside = distance_from_outline(moment.pose, nearest) - thing.kept_from_course;
    moment.off_courses = moment.off_courses && beside >= 0.0;
    moment.room_beside_courses = std::min(moment.room_beside_courses, beside);
  }
  const bool stands = moment.velocity == Velocity{};
  double room = 0.0;
  return !stands && touches_static(map_, moment.pose, static_margin_, room, work_) ? Met::kWall : Met::kNothing;
}

Foresight::Met Foresight::follow(Moment& moment, const Velocity& wanted) {
  while (moment.seconds < kHorizon - 1e-9) {
    advance(moment, wanted);
    const Met met = meets(moment);
    if (met != Met::kNothing) return met;
  }
  return Met::kNothing;
}

// Whether something that goes on as it does comes upon the robot soon after the horizon.
bool Foresight::is_come_upon(const Pose& pose) const {
  return std::any_of(things_.begin(), things_.end(), [&](const Thing& thing) {
    if (!thing.moving.moves()) return false;
    const Point from = thing.moving.at(age_ + kHorizon);
    const Point ahead = thing.moving.at(age_ + kHorizon + kBeyondHorizon) - from;
    const double length = ahead.x * ahead.x + ahead.y * ahead.y;
    const Point off = position(pose) - from;
    const double share = length > 0.0 ? std::clamp((off.x * ahead.x + off.y * ahead.y) / length, 0.0, 1.0) : 0.0;
    return distance_from_outline(pose, from + ahead * share) < thing.kept;
  });
}

double Foresight::clear_for(const Velocity& velocity) {
  Moment end = start_;
  if (!things_.empty() && follow(end, velocity) != Met::kNothing) return std::min(end.seconds, end.clear_until);
  return std::min(kHorizon, end.clear_until);
}

Foresight::Safety Foresight::of(const Velocity& velocity) {
  if (things_.empty()) return {Level::kSafe};
  Safety best;
  const auto consider = [&](const Moment& end, Met met, bool backwards) {
    if (met == Met::kThing) best.contact_after = std::max(best.contact_after, end.seconds);
    if (met != Met::kNothing) return;
    const bool clear = end.off_courses && !is_come_upon(end.pose);
    const Level level = end.grazes                   ? Level::kGrazing
                        : end.clear_until < kHorizon ? Level::kTooNear
                        : !clear                     ? Level::kIfItGoesOn
                        : backwards                  ? Level::kByBackingUp
                                                     : Level::kSafe;
    if (level < best.level) return;
    const double room = level == Level::kIfItGoesOn ? end.room_beside_courses : end.room;
    best.room = level > best.level ? room : std::max(best.room, room);
    best.level = level;
  };
  Moment kept = start_;
  for (const double decide : {reaction_, kDecideLater, kDecideLast}) {
    while (kept.seconds < decide - 1e-9) {
      advance(kept, velocity);
      const Met met = meets(kept);
      if (met == Met::kNothing) continue;
      consider(kept, met, false);
      return best;
    }
    for (const Velocity& then : {Velocity{}, Velocity{limits_.speed, 0.0}, Velocity{kBackUp, 0.0}}) {
      Moment end = kept;
      const Met met = follow(end, then);
      consider(end, met, velocity.linear < 0.0 || then.linear < 0.0);
      if (best.level == Level::kSafe) return best;
    }
  }
  const Met met = follow(kept, velocity);
  consider(kept, met, velocity.linear < 0.0);
  return best;
}

}  // namespace ctn::navigation
