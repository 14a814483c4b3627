#include "local_planner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace ctn::navigation {
namespace {

constexpr double kWindow = 0.25;  // seconds within which a velocity must be reached
constexpr int kSpeeds = 13;       // 4 cm/s from one to the next
constexpr int kTurns = 61;        // 1.4 degrees/s
constexpr double kHorizon = 1.5;
constexpr double kStep = 0.05;      // at full speed, a cell
constexpr int kStepsJudged = 20;    // the pose after so many steps is compared with the target
constexpr double kTurnFirst = 1.2;  // towards a target farther to the side, the robot turns on the spot
constexpr double kTightMargin = 0.04;
constexpr double kLookAround = 0.5;  // rad/s
constexpr double kBackwards = -0.2;
constexpr double kWorthIt = 0.03;        // metres by which going tight or backwards must be better than standing
constexpr double kBearingWeight = 0.25;  // metres per radian
constexpr double kRoomWeight = 0.4;      // metres per metre
constexpr double kRoom = 0.6;            // more room than this is worth nothing extra
constexpr double kOutlineSpacing = 0.04;

// Points along the robot's sides, as seen from its centre.
std::vector<Point> make_outline() {
  std::vector<Point> points;
  const int count = static_cast<int>(std::lround(kRobotSide / kOutlineSpacing));
  for (int i = 0; i < count; ++i) {
    const double along = -kInnerRadius + i * kOutlineSpacing;
    points.push_back({along, -kInnerRadius});
    points.push_back({kInnerRadius, along});
    points.push_back({-along, kInnerRadius});
    points.push_back({-kInnerRadius, -along});
  }
  return points;
}

struct Limits {
  double margin;
  double slowest;
  double fastest;
};

struct Choice {
  Velocity velocity;  // standing still, if none is allowed
  double score = -std::numeric_limits<double>::infinity();

  bool moves() const { return std::abs(velocity.linear) >= 0.02 || std::abs(velocity.angular) >= 0.05; }
};

class DynamicWindow {
 public:
  DynamicWindow(const LocalMap& map, const Odometry& odometry, Point target)
      : map_(map), odometry_(odometry), target_(target) {}

  Choice choose(const Limits& limits) {
    static const std::vector<Point> kOutline = make_outline();
    const double speed = std::clamp(odometry_.velocity.linear, limits.slowest, limits.fastest);
    const double turn = odometry_.velocity.angular;
    const double slowest = std::max(limits.slowest, speed - LocalPlanner::kLimits.acceleration * kWindow);
    const double fastest = std::min(limits.fastest, speed + LocalPlanner::kLimits.acceleration * kWindow);
    const double right =
        std::max(-LocalPlanner::kLimits.turn_rate, turn - LocalPlanner::kLimits.turn_acceleration * kWindow);
    const double left =
        std::min(LocalPlanner::kLimits.turn_rate, turn + LocalPlanner::kLimits.turn_acceleration * kWindow);
    Choice best;
    for (int i = 0; i < kSpeeds; ++i) {
      for (int j = 0; j < kTurns; ++j) {
        const Velocity velocity{slowest + (fastest - slowest) * i / (kSpeeds - 1),
                                right + (left - right) * j / (kTurns - 1)};
        const double score = judge(velocity, limits.margin, kOutline);
        if (score > best.score) best = {velocity, score};
      }
    }
    return best;
  }

  std::uint64_t lookups() const { return lookups_; }

 private:
  bool touches(const Pose& pose, double margin, const std::vector<Point>& outline, double& room) {
    const double clear = map_.clearance_at(position(pose));
    ++lookups_;
    room = std::min(room, clear);
    if (clear >= kOuterRadius + margin) return false;
    if (clear < kInnerRadius) return true;
    lookups_ += outline.size();
    return std::any_of(outline.begin(), outline.end(),
                       [&](const Point& point) { return map_.clearance_at(transformed(pose, point)) < margin; });
  }

  double judge(const Velocity& velocity, double margin, const std::vector<Point>& outline) {
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
      if (!touches(pose, margin, outline, room)) continue;
      const double seconds = (step - 1) * kStep;
      const double speed = std::abs(velocity.linear);
      const double turn = std::abs(velocity.angular);
      const bool brakes = LocalPlanner::kReaction + speed / (2.0 * LocalPlanner::kLimits.acceleration) <= seconds &&
                          LocalPlanner::kReaction + turn / (2.0 * LocalPlanner::kLimits.turn_acceleration) <= seconds;
      if (!brakes && (speed > 0.0 || turn > 0.0)) return -std::numeric_limits<double>::infinity();
      break;
    }
    const double away = distance(position(judged), target_);
    const double bearing = std::atan2(target_.y - judged.y, target_.x - judged.x) - judged.heading;
    const double off = away > 0.1 ? std::abs(wrapped(bearing)) : 0.0;
    return -away - kBearingWeight * off - kRoomWeight * (kRoom - room);
  }

  const LocalMap& map_;
  const Odometry& odometry_;
  Point target_;
  std::uint64_t lookups_ = 0;
};

}  // namespace

LocalPlanner::Result LocalPlanner::run(const LocalMap& map, const Odometry& odometry, const Command& command) const {
  const Pose& pose = odometry.pose;
  if (command.look_around) {
    const bool turns_freely = map.clearance_at(position(pose)) >= kOuterRadius + kTightMargin;
    return {{0.0, turns_freely ? kLookAround : 0.0}, Detour::Kind::kStraight, {.candidates = 1}};
  }
  if (command.stop) return {};
  const Detour detour = find_detour(map, position(pose), command, kMargin);
  const Point& target = detour.target;
  const double bearing = wrapped(std::atan2(target.y - pose.y, target.x - pose.x) - pose.heading);
  const double end =
      std::max(0.1, std::sqrt(kLimits.speed * command.distance_left));  // slower towards the end of the path
  const double fastest = std::abs(bearing) > kTurnFirst ? 0.0 : std::min(kLimits.speed, end);

  DynamicWindow window(map, odometry, target);
  Choice choice = window.choose({kMargin, 0.0, fastest});
  if (!choice.moves()) {
    const Choice tight = window.choose({kTightMargin, kBackwards, fastest});
    if (tight.score > choice.score + kWorthIt) choice = tight;
  }
  Work work = detour.work;
  work.candidates += window.lookups();
  return {choice.velocity, detour.kind, work};
}

}  // namespace ctn::navigation
