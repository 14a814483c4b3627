#include "world.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace ctn::navigation::world {
namespace {

using std::chrono::nanoseconds;

// Streams of random numbers; scene.cpp has the first.
constexpr std::uint64_t kRanges = 2;
constexpr std::uint64_t kWheels = 3;

constexpr double kStepSeconds = 1e-3;
constexpr std::int64_t kStepsPerInstant = kSensorPeriod / kWorldStep;
constexpr std::size_t kInstantsPerLook = 25;  // 0.5 s between two looks at which free space is seen
constexpr double kTouch = 2e-5;               // nearer than this is contact: what single precision can tell
constexpr double kApart = 0.01;               // farther than this, contact is over
constexpr double kNear = 0.5;                 // farther than this, distances are not measured

double seconds_of_step(std::int64_t step) { return static_cast<double>(step) * kStepSeconds; }

double towards(double value, double wanted, double change) {
  return value + std::clamp(wanted - value, -change, change);
}

double limited(double value, double limit) { return std::isfinite(value) ? std::clamp(value, -limit, limit) : 0.0; }

// What happens in one step, up to a share of it: the speeds change evenly.
double driven_in(const World::Motion& motion, double share) {
  return (motion.speed + (motion.speed_after - motion.speed) * share / 2.0) * share * kStepSeconds;
}
Pose pose_in(const Pose& from, const World::Motion& motion, double share) {
  const double turned =
      (motion.turn_rate + (motion.turn_rate_after - motion.turn_rate) * share / 2.0) * share * kStepSeconds;
  return along_arc(from, driven_in(motion, share), turned);
}

}  // namespace

World::World(const WorldFile& file, const WorldOptions& options)
    : file_(file),
      options_(options),
      scene_(file, options.seed),
      range_noise_(options.seed, kRanges),
      drift_noise_(options.seed, kWheels),
      pose_(file.start),
      touching_(file.movers.size() + 1) {
  double fastest = 0.0;
  for (const MoverSpec& mover : file.movers) fastest = std::max(fastest, mover.speed);
  closing_speed_ = fastest + options.limits.speed + options.limits.turn_rate * kRobotSide / std::numbers::sqrt2;
  if (file.explore()) explored_.emplace(file, kSeenCell);
  take_instant();
}

void World::command(nanoseconds time, const Velocity& velocity) {
  advance(time);
  const std::int64_t first = (time + kWorldStep - nanoseconds(1)) / kWorldStep;
  next_ = {std::max(first, step_),
           {limited(velocity.linear, options_.limits.speed), limited(velocity.angular, options_.limits.turn_rate)}};
}

void World::advance(nanoseconds time) {
  while (now() + kWorldStep <= time) step();
}

double World::distance_to(std::size_t obstacle, const Pose& pose, double time) const {
  return obstacle < scene_.movers().size() ? scene_.to_mover(obstacle, pose, kRobotSide, time)
                                           : scene_.to_walls(pose, kRobotSide, kNear);
}

// The largest share of the step, to the nanosecond, at which robot and obstacle do not touch yet. Precondition: they do
// at the step's end.
double World::first_touch(std::size_t obstacle, const Motion& motion) const {
  double apart = 0.0;
  double touch = 1.0;
  while (touch - apart > 1e-6) {
    const double share = (apart + touch) / 2.0;
    const Pose pose = pose_in(pose_, motion, share);
    const double time = seconds_of_step(step_) + share * kStepSeconds;
    (distance_to(obstacle, pose, time) <= kTouch ? touch : apart) = share;
  }
  return apart;
}

double World::driven_share(Motion& motion) {
  if (step_ < clear_until_) return 1.0;
  const std::size_t walls = scene_.movers().size();
  const double begin = seconds_of_step(step_);
  double nearest = kNear;
  for (std::size_t i = 0; i <= walls; ++i) {
    const double apart = distance_to(i, pose_, begin);
    nearest = std::min(nearest, apart);
    if (apart > kApart) touching_[i] = 0;
  }
  // One step less, because of rounding.
  const auto clear = static_cast<std::int64_t>((nearest - kTouch) / (closing_speed_ * kStepSeconds)) - 1;
  if (clear > 0) {
    clear_until_ = step_ + clear;
    return 1.0;
  }
  // A wall that the robot touches already still stops it; a mover passes through it.
  if (touching_[walls] != 0 && distance_to(walls, pose_in(pose_, motion, 1.0), begin) <= kTouch) motion = Motion();
  const Pose after = pose_in(pose_, motion, 1.0);
  const double end = seconds_of_step(step_ + 1);
  double share = 1.0;
  std::optional<std::size_t> met;
  for (std::size_t i = 0; i <= walls; ++i) {
    if (touching_[i] != 0 || distance_to(i, after, end) > kTouch) continue;
    const double until = first_touch(i, motion);
    if (met && until >= share) continue;
    share = until;
    met = i;
  }
  if (!met) return 1.0;
  touching_[*met] = 1;
  contacts_.push_back({now() + nanoseconds(std::llround(share * 1e9 * kStepSeconds)), *met < walls ? met : std::nullopt,
                       pose_in(pose_, motion, share), motion.speed + (motion.speed_after - motion.speed) * share});
  ended_ = options_.after_contact == AfterContact::kEnd;
  return share;
}

void World::step() {
  if (step_ >= next_.from_step) current_ = next_;
  if (!ended_) {
    const RobotLimits& limits = options_.limits;
    Motion motion{speed_, turn_rate_, towards(speed_, current_.velocity.linear, limits.acceleration * kStepSeconds),
                  towards(turn_rate_, current_.velocity.angular, limits.turn_acceleration * kStepSeconds)};
    const Pose before = pose_;
    const std::size_t met_before = contacts_.size();
    const double share = driven_share(motion);
    const double driven = driven_in(motion, share);
    pose_ = pose_in(before, motion, share);
    distance_since_ += driven;
    turn_since_ += pose_.heading - before.heading;
    travelled_ += std::abs(driven);
    const bool stopped = contacts_.size() > met_before;
    speed_ = stopped ? 0.0 : motion.speed_after;
    turn_rate_ = stopped ? 0.0 : motion.turn_rate_after;
  }
  ++step_;
  if (!reached_at_ && file_.goal && distance(position(pose_), *file_.goal) <= kGoalRadius) reached_at_ = now();
  if (step_ % kStepsPerInstant == 0) take_instant();
}

void World::take_instant() {
  Odometry odometry;
  odometry.stamp = now();
  if (instants_.empty()) {
    odometry.pose = pose_;
  } else {
    const std::uint64_t index = 2 * instants_.size();
    const OdometryNoise& drift = options_.drift;
    const double metres = std::abs(distance_since_);
    const double radians = std::abs(turn_since_);
    const double counted = distance_since_ + drift.distance_per_metre * std::sqrt(metres) * drift_noise_.normal(index);
    const double turned = turn_since_ + std::sqrt(drift.turn_per_radian * drift.turn_per_radian * radians +
                                                  drift.turn_per_metre * drift.turn_per_metre * metres) *
                                            drift_noise_.normal(index + 1);
    const double lasted = std::chrono::duration<double>(kSensorPeriod).count();
    odometry.pose = along_arc(instants_.back().odometry.pose, counted, turned);
    odometry.velocity.linear = counted / lasted;
    odometry.velocity.angular = turned / lasted;
  }
  distance_since_ = turn_since_ = 0.0;
  instants_.push_back({pose_, odometry});
  if (explored_ && (instants_.size() - 1) % kInstantsPerLook == 0) look_around();
}

void World::look_around() {
  const Laser& laser = options_.laser;
  std::vector<float> rays(laser.beams);
  scene_.cast(pose_, seconds_of_step(step_), laser.field, laser.range, rays);
  explored_->see(pose_, laser.field, laser.range, rays);
}

std::size_t World::instant_at(nanoseconds time) {
  assert(time >= nanoseconds(0));
  advance(time);
  return std::min(instants_.size() - 1, static_cast<std::size_t>(time / kSensorPeriod));
}

const Scan& World::scan_at(nanoseconds time) {
  const std::size_t instant = instant_at(time);
  if (scan_of_ == instant) return scan_;
  const Laser& laser = options_.laser;
  scan_.stamp = instants_[instant].odometry.stamp;
  scan_.field = laser.field;
  scan_.max_range = laser.range;
  scan_.ranges.resize(laser.beams);
  scene_.cast(instants_[instant].truth, std::chrono::duration<double>(scan_.stamp).count(), laser.field, laser.range,
              scan_.ranges);
  for (std::size_t i = 0; i < laser.beams; ++i) {
    float& range = scan_.ranges[i];
    if (!std::isfinite(range) || laser.noise <= 0.0) continue;
    // Each scan has its own indices, and an even number of them, since normal() uses them in pairs.
    const std::uint64_t index = instant * (laser.beams + laser.beams % 2) + i;
    const double noisy = static_cast<double>(range) + laser.noise * range_noise_.normal(index);
    range = static_cast<float>(std::clamp(noisy, 0.0, laser.range));
  }
  scan_of_ = instant;
  return scan_;
}

const Odometry& World::odometry_at(nanoseconds time) { return instants_[instant_at(time)].odometry; }

const Pose& World::truth_at(nanoseconds time) { return instants_[instant_at(time)].truth; }

Score World::score() const { return {contacts_, travelled_, reached_at_, explored_ ? explored_->fraction() : 0.0}; }

}  // namespace ctn::navigation::world
