#include "local_planner.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <vector>

#include "footprint.h"

namespace ctn::navigation {
namespace {

constexpr double kWindow = 0.25;  // seconds within which a velocity must be reached
constexpr int kSpeeds = 13;       // 4 cm/s from one to the next
constexpr int kTurns = 61;        // 1.4 degrees/s
constexpr int kTurnsIfConcerned = 31;
constexpr double kHorizon = 1.5;
constexpr double kStep = 0.05;      // at full speed, a cell
constexpr int kStepsJudged = 20;    // the pose after so many steps is compared with the target
constexpr double kTurnFirst = 1.2;  // towards a target farther to the side, the robot turns on the spot
constexpr double kTightMargin = 0.04;
constexpr double kLookAround = 0.5;  // rad/s
constexpr double kBackwards = -0.2;
constexpr double kGivingWay = -0.5;      // m/s, backwards
constexpr double kWorthIt = 0.03;        // metres by which going tight or backwards must be better than standing
constexpr double kBearingWeight = 0.25;  // metres per radian
constexpr double kRoomWeight = 0.4;      // metres per metre
constexpr double kRoom = 0.6;            // more room than this is worth nothing extra
// Metres that a velocity must be better by if it is only there to give way: backwards; or faster than the target asks.
constexpr double kBackwardsCost = 0.15;
constexpr double kTooFastCost = 0.5;  // per m/s
constexpr double kGoCost = 0.2;       // without a target: per m/s
constexpr double kTurnCost = 0.05;    // of turning otherwise than told, without a target: per rad/s
constexpr double kPutOffCost = 0.3;   // of going on towards what moves, if that would be contact at once
constexpr double kStayCost = 1.0;     // the same without a target: there is nothing to be lost by giving way early
// Where contact cannot be avoided: of how long a velocity keeps clear by itself. The robot keeps it for an instant
// only, after which most others leave it as much time as this one; going on as long as that is so, it would never
// brake.
constexpr double kOnItsOwnWeight = 0.2;
constexpr double kCloseWeight = 20.0;     // metres per metre of room to what moves, where there is too little
constexpr double kBesideWeight = 3.0;     // likewise beside its course
constexpr std::size_t kTriedFirst = 40;   // velocities; of the others, when none of these is safe, only every sixth
constexpr double kWheelsShare = 0.15;     // of what the wheels counted
constexpr double kWheelsShareGain = 2.0;  // more for each second in which what was told may not have come to be
constexpr double kMaxWheelsShare = 0.6;
constexpr double kMaxGap = 1.0;     // seconds between two runs
constexpr double kPatience = 4.0;   // seconds that the robot waits with all caution
constexpr double kImpatient = 5.0;  // until it has the least
constexpr double kMinCaution = 0.15;

struct Limits {
  double margin;
  double slowest;
  double fastest;
  int turns = kTurns;
};

struct Choice {
  Velocity velocity;  // standing still, if none is allowed
  double score = -std::numeric_limits<double>::infinity();
  Foresight::Level safety = Foresight::Level::kSafe;

  bool moves() const { return std::abs(velocity.linear) >= 0.02 || std::abs(velocity.angular) >= 0.05; }
};

struct Option {
  Velocity velocity;
  double score;
  bool coarse;  // one of those that are always tried
};

double room_weight(Foresight::Level level) {
  switch (level) {
    case Foresight::Level::kGrazing:
    case Foresight::Level::kTooNear:
      return kCloseWeight;
    case Foresight::Level::kIfItGoesOn:
      return kBesideWeight;
    case Foresight::Level::kContact:
    case Foresight::Level::kByBackingUp:
    case Foresight::Level::kSafe:
      break;
  }
  return 0.0;
}

// Where to: a point, or without one to turn at some rate.
struct Aim {
  std::optional<Point> target;
  double fastest = 0.0;
  double turn = 0.0;
};

class DynamicWindow {
 public:
  DynamicWindow(const LocalMap& map, const Odometry& odometry, const Aim& aim)
      : map_(map), odometry_(odometry), aim_(aim) {}

  Choice choose(const Limits& limits) {
    Choice best;
    visit(limits, [&](const Velocity& velocity, bool) {
      const double score = judge(velocity, limits.margin);
      if (score > best.score) best = {velocity, score, Foresight::Level::kSafe};
    });
    return best;
  }

  // The best one that is safe, or as safe as any.
  Choice choose(const Limits& limits, Foresight& foresight) {
    std::vector<Option> options{{{}, judge({}, limits.margin), true}};
    visit(limits, [&](const Velocity& velocity, bool coarse) {
      const double score = judge(velocity, limits.margin) -
                           kTooFastCost * std::max(0.0, velocity.linear - aim_.fastest) -
                           (velocity.linear < 0.0 ? kBackwardsCost : 0.0);
      if (std::isfinite(score)) options.push_back({velocity, score, coarse});
    });
    std::stable_sort(options.begin(), options.end(),
                     [](const Option& a, const Option& b) { return a.score > b.score; });
    Choice best;
    best.safety = Foresight::Level::kContact;
    double put_off = -1.0;
    for (std::size_t i = 0; i < options.size(); ++i) {
      const Option& option = options[i];
      if (best.safety == Foresight::Level::kSafe && option.score <= best.score) break;
      if (i >= kTriedFirst && !option.coarse) continue;
      const Foresight::Safety safety = foresight.of(option.velocity);
      if (safety.level < best.safety) continue;
      const double clear_for = foresight.clear_for(option.velocity);
      if (safety.level == Foresight::Level::kContact) {
        const double after = safety.contact_after + kOnItsOwnWeight * clear_for;
        if (after <= put_off) continue;
        put_off = after;
      }
      // What it leaves for later to give way.
      const double left = 1.0 - clear_for / Foresight::kHorizon;
      const double score =
          option.score - (aim_.target ? kPutOffCost : kStayCost) * left + room_weight(safety.level) * safety.room;
      const bool better = safety.level > best.safety || safety.level == Foresight::Level::kContact;
      if (better || score > best.score) best = {option.velocity, score, safety.level};
    }
    return best;
  }

  // The first of the margins that the robot keeps where it is.
  std::optional<double> margin_kept_of(std::initializer_list<double> margins) {
    return margin_kept(map_, odometry_.pose, margins, work_);
  }
  bool allows(const Velocity& velocity, double margin) { return std::isfinite(judge(velocity, margin)); }

  const Work& work() const { return work_; }

 private:
  template <typename Visit>
  void visit(const Limits& limits, const Visit& visit) const {
    const double speed = std::clamp(odometry_.velocity.linear, limits.slowest, limits.fastest);
    const double turn = odometry_.velocity.angular;
    const double slowest = std::max(limits.slowest, speed - LocalPlanner::kLimits.acceleration * kWindow);
    const double fastest = std::min(limits.fastest, speed + LocalPlanner::kLimits.acceleration * kWindow);
    const double right =
        std::max(-LocalPlanner::kLimits.turn_rate, turn - LocalPlanner::kLimits.turn_acceleration * kWindow);
    const double left =
        std::min(LocalPlanner::kLimits.turn_rate, turn + LocalPlanner::kLimits.turn_acceleration * kWindow);
    for (int i = 0; i < kSpeeds; ++i) {
      for (int j = 0; j < limits.turns; ++j) {
        visit({slowest + (fastest - slowest) * i / (kSpeeds - 1), right + (left - right) * j / (limits.turns - 1)},
              i % 2 == 0 && j % 3 == 0);
      }
    }
  }

  double judge(const Velocity& velocity, double margin) {
    Pose pose = odometry_.pose;
    Pose judged = pose;
    double room = kRoom;
    const int steps = static_cast<int>(std::lround(kHorizon / kStep));
    for (int step = 1; step <= steps; ++step) {
      const double heading = pose.heading + 0.5 * velocity.angular * kStep;
      pose.x += velocity.linear * kStep * std::cos(heading);
      pose.y += velocity.linear * kStep * std::sin(heading);
      pose.heading = wrapped(pose.heading + velocity.angular * kStep);
      if (step <= kStepsJudged) judged = pose;
      if (!touches_static(map_, pose, margin, room, work_)) continue;
      const double seconds = (step - 1) * kStep;
      const double speed = std::abs(velocity.linear);
      const double turn = std::abs(velocity.angular);
      const double left = seconds - LocalPlanner::kReaction;
      const bool brakes = speed / (2.0 * LocalPlanner::kLimits.acceleration) <= left &&
                          turn / (2.0 * LocalPlanner::kLimits.turn_acceleration) <= left;
      if (!brakes && (speed > 0.0 || turn > 0.0)) return -std::numeric_limits<double>::infinity();
      break;
    }
    if (!aim_.target) return -kGoCost * std::abs(velocity.linear) - kTurnCost * std::abs(velocity.angular - aim_.turn);
    const double away = distance(position(judged), *aim_.target);
    const double bearing = std::atan2(aim_.target->y - judged.y, aim_.target->x - judged.x) - judged.heading;
    const double off = away > 0.1 ? std::abs(wrapped(bearing)) : 0.0;
    return -away - kBearingWeight * off - kRoomWeight * (kRoom - room);
  }

  const LocalMap& map_;
  const Odometry& odometry_;
  Aim aim_;
  Work work_;
};

// Where nothing moves.
Choice among_standing(DynamicWindow& window, const Aim& aim, bool may_back_up) {
  Choice choice = window.choose({LocalPlanner::kMargin, 0.0, aim.fastest});
  if (choice.moves()) return choice;
  const Choice tight = window.choose({kTightMargin, may_back_up ? kBackwards : 0.0, aim.fastest});
  return tight.score > choice.score + kWorthIt ? tight : choice;
}

// Where something holds the robot it may be nearer than usual to what stands; it comes no nearer to it.
Velocity straight_on(DynamicWindow& window, double speed) {
  const std::optional<double> margin = window.margin_kept_of({kTightMargin, kInNoObstacle});
  const Velocity velocity{speed, 0.0};
  return margin && window.allows(velocity, *margin) ? velocity : Velocity{};
}

Choice among_moving(DynamicWindow& window, Foresight& foresight) {
  constexpr double kFastest = LocalPlanner::kLimits.speed;
  const Choice choice = window.choose({LocalPlanner::kMargin, kGivingWay, kFastest, kTurnsIfConcerned}, foresight);
  if (choice.moves() && choice.safety == Foresight::Level::kSafe) return choice;
  const Choice tight = window.choose({kTightMargin, kGivingWay, kFastest, kTurnsIfConcerned}, foresight);
  const bool safer = tight.safety > choice.safety;
  return safer || (tight.safety == choice.safety && tight.score > choice.score + kWorthIt) ? tight : choice;
}

}  // namespace

// How long the robot has stood although it was to go somewhere; going on, it forgets this twice as fast.
void LocalPlanner::wait(const LocalMap& map, const Odometry& odometry, bool wants_to_go) {
  const double seconds = std::chrono::duration<double>(map.stamp - stamp_).count();
  stamp_ = map.stamp;
  const bool stands = std::abs(odometry.velocity.linear) < 0.15;
  if (seconds <= 0.0 || seconds > 1.0) return;
  waited_ = std::max(0.0, stands && wants_to_go ? waited_ + seconds : waited_ - 2.0 * seconds);
}

// The base's velocity: what the last command has made of it by now, corrected by what the wheels have counted in the
// last instant, which alone is too noisy to tell whether the robot can still stop.
Odometry LocalPlanner::smoothed(const Odometry& counted) {
  const double seconds = std::chrono::duration<double>(counted.stamp - counted_at_).count();
  counted_at_ = counted.stamp;
  Odometry odometry = counted;
  const double share = std::min(kMaxWheelsShare, kWheelsShare + kWheelsShareGain * seconds);
  if (driven_ && seconds >= 0.0 && seconds <= kMaxGap) {
    const auto mixed = [&](double before, double wanted, double change, double now) {
      const double expected = before + std::clamp(wanted - before, -change * seconds, change * seconds);
      return expected + share * (now - expected);
    };
    odometry.velocity.linear = mixed(driven_->linear, wanted_.linear, kLimits.acceleration, counted.velocity.linear);
    odometry.velocity.angular =
        mixed(driven_->angular, wanted_.angular, kLimits.turn_acceleration, counted.velocity.angular);
  }
  driven_ = odometry.velocity;
  return odometry;
}

LocalPlanner::Result LocalPlanner::run(const LocalMap& map, const Odometry& counted, const Command& command) {
  getting_free_.feel(counted, wanted_);
  const Result result = plan(map, smoothed(counted), command);
  wanted_ = result.velocity;
  return result;
}

LocalPlanner::Result LocalPlanner::plan(const LocalMap& map, const Odometry& odometry, const Command& command) {
  const Pose& pose = odometry.pose;
  wait(map, odometry, !command.stop);
  const double caution = std::clamp(1.0 - (waited_ - kPatience) / kImpatient, kMinCaution, 1.0);
  Foresight foresight(map, odometry, kReaction, caution, kLimits);

  Result result;
  const bool is_to_move = !command.stop || command.look_around;
  if (is_to_move && getting_free_.speed() && !foresight.concerned()) {
    DynamicWindow window(map, odometry, {});
    result.velocity = straight_on(window, *getting_free_.speed());
    result.work = window.work();
    return result;
  }
  Aim aim;
  if (command.stop) {
    if (command.look_around) {
      ++result.work.candidates;
      const bool turns_freely = map.static_clearance_at(position(pose)) >= kOuterRadius + kTightMargin;
      aim.turn = turns_freely ? kLookAround : 0.0;
    }
    result.velocity.angular = aim.turn;
    if (!foresight.concerned()) return result;
  } else {
    const Detour detour = find_detour(map, position(pose), command, kMargin);
    const double bearing = wrapped(std::atan2(detour.target.y - pose.y, detour.target.x - pose.x) - pose.heading);
    const double end =
        std::max(0.1, std::sqrt(kLimits.speed * command.distance_left));  // slower towards the end of the path
    aim.target = detour.target;
    aim.fastest = std::abs(bearing) > kTurnFirst ? 0.0 : std::min(kLimits.speed, end);
    result.way = detour.kind;
    result.work = detour.work;
  }
  DynamicWindow window(map, odometry, aim);
  const Choice choice = foresight.concerned() ? among_moving(window, foresight)
                                              : among_standing(window, aim, getting_free_.may_back_up());
  result.velocity = choice.velocity;
  result.safety = choice.safety;
  result.work += window.work();
  result.work += foresight.work();
  return result;
}

}  // namespace ctn::navigation
