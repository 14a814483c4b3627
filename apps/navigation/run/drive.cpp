#include "run/drive.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry.h"

namespace ctn::navigation::run {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kLookPeriod = std::chrono::milliseconds(500);  // the world's, at what was explored
constexpr double kExplored = 0.9;
constexpr double kSameThing = 0.01;  // between the end of a ray and the outline of what it hit

double to_seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

world::WorldOptions with_seed(std::uint64_t seed) {
  world::WorldOptions options;
  options.seed = seed;
  return options;
}

// How far `point` is from the outline of a mover that is at `at`.
double from_outline(const world::MoverSpec& spec, Point at, Point point) {
  if (spec.radius > 0.0) return std::abs(distance(point, at) - spec.radius);
  const Point seen = transformed(inverse(Pose{at.x, at.y, spec.heading}), point);
  const double dx = std::abs(seen.x) - spec.length / 2.0;
  const double dy = std::abs(seen.y) - spec.width / 2.0;
  return dx <= 0.0 && dy <= 0.0 ? -std::max(dx, dy) : std::hypot(std::max(dx, 0.0), std::max(dy, 0.0));
}

bool in_way(Point seen) {
  return seen.x > 0.0 && seen.x <= Drive::kWayLength && std::abs(seen.y) <= Drive::kWayWidth / 2.0;
}

}  // namespace

Drive::Drive(const world::WorldFile& file, std::uint64_t seed)
    : world_(file, with_seed(seed)), movers_(file.movers.size()) {
  advance(nanoseconds(0));
}

std::shared_ptr<const Reading> Drive::laser(nanoseconds time) {
  advance(time);
  const Scan& scan = world_.scan_at(time);
  if (!reading_ || reading_->scan.stamp != scan.stamp) {
    reading_ = std::make_shared<const Reading>(Reading{scan, world_.odometry_at(scan.stamp)});
  }
  return reading_;
}

Odometry Drive::odometry(nanoseconds time) {
  advance(time);
  return world_.odometry_at(time);
}

void Drive::move(const Motion& motion) {
  advance(motion.at);
  motion_ = motion;
  world_.command(motion.at, over() ? Velocity{} : motion.velocity);
  if (over()) return;
  const std::optional<nanoseconds> stamp = motion.map ? motion.map->stamp : motion.stamp;
  if (stamp) findings_.scan_ages.push_back({motion.at, motion.at - *stamp});
  if (!motion.map) return;
  for (std::size_t mover = 0; mover < movers_.size(); ++mover) {
    if (!movers_[mover].open) continue;
    Appearance& appearance = findings_.appearances[*movers_[mover].open];
    if (motion.map->stamp < appearance.at) continue;
    const std::vector<Point> hits = hits_in_way(mover, motion.map->stamp);
    const bool shown = std::any_of(hits.begin(), hits.end(), [&](Point hit) {
      return motion.map->clearance_at(transformed(motion.map->odometry.pose, hit)) <= kShownWithin;
    });
    if (!shown) continue;
    appearance.reaction = motion.at - appearance.at;
    movers_[mover].open.reset();
  }
}

void Drive::guided(const Guidance& guidance) {
  advance(guidance.at);
  if (over()) return;
  findings_.guidance_ages.push_back({guidance.at, guidance.at - guidance.stamp});
  findings_.pose_errors.push_back(distance(position(guidance.pose), position(world_.truth_at(guidance.stamp))));
}

void Drive::planned(const Planned& planned) {
  advance(planned.at);
  plan_ = planned;
  if (planned.path->outcome != Path::Outcome::kNothingLeft) {
    nothing_left_since_.reset();
  } else if (!nothing_left_since_) {
    nothing_left_since_ = planned.at;
  }
}

void Drive::detected(const Detected& detected) {
  advance(detected.at);
  if (!over()) findings_.detections.push_back(detected.at);
}

void Drive::advance(nanoseconds time) {
  for (; next_instant_ <= time; next_instant_ += world::kSensorPeriod) {
    world_.advance(next_instant_);
    if (!over()) observe(next_instant_);
  }
  world_.advance(time);
}

void Drive::observe(nanoseconds instant) {
  look_for_movers(instant);
  findings_.lasted = instant;
  if (world_.explored() && instant % kLookPeriod == nanoseconds(0)) {
    findings_.explored = world_.explored()->fraction();
    if (!findings_.explored_90_at && findings_.explored >= kExplored) findings_.explored_90_at = instant;
  }
  if (nothing_left_since_ && instant >= *nothing_left_since_ + kNothingLeftFor) end(Ending::kExplored, instant);
  if (world_.file().goal && distance(position(world_.truth()), *world_.file().goal) <= world::kGoalRadius) {
    end(Ending::kGoal, instant);
  }
}

void Drive::end(Ending ending, nanoseconds at) {
  const Findings now = findings();
  findings_ = now;
  findings_.ending = ending;
  ended_at_ = at;
}

void Drive::look_for_movers(nanoseconds instant) {
  for (std::size_t mover = 0; mover < movers_.size(); ++mover) {
    Watched& watched = movers_[mover];
    if (watched.in_way && instant - watched.last_seen >= kGone) {
      watched.in_way = false;
      watched.open.reset();
    }
    const std::size_t needed = watched.in_way ? 1 : kBeamsToSee;
    if (hits_in_way(mover, instant).size() < needed) continue;
    watched.last_seen = instant;
    if (watched.in_way) continue;
    watched.in_way = true;
    watched.open = findings_.appearances.size();
    findings_.appearances.push_back({instant, mover, std::nullopt});
  }
}

std::vector<Point> Drive::hits_in_way(std::size_t mover, nanoseconds instant) {
  const world::Mover& moves = world_.scene().movers()[mover];
  const Pose robot = world_.truth_at(instant);
  const Point at = moves.at(to_seconds(instant));
  const Point centre = transformed(inverse(robot), at);
  const double reach = moves.spec().reach();
  if (centre.x < -reach || centre.x > kWayLength + reach || std::abs(centre.y) > kWayWidth / 2.0 + reach) return {};

  const world::Laser& laser = world_.options().laser;
  std::vector<float> rays(laser.beams);
  world_.scene().cast(robot, to_seconds(instant), laser.field, laser.range, rays);
  std::vector<Point> hits;
  for (std::size_t ray = 0; ray < rays.size(); ++ray) {
    if (!std::isfinite(rays[ray])) continue;
    const double angle = laser.field * (static_cast<double>(ray) / static_cast<double>(rays.size() - 1) - 0.5);
    const double range = static_cast<double>(rays[ray]);
    const Point seen{range * std::cos(angle), range * std::sin(angle)};
    if (in_way(seen) && from_outline(moves.spec(), at, transformed(robot, seen)) <= kSameThing) hits.push_back(seen);
  }
  return hits;
}

Progress Drive::progress() const {
  return {world_.now(), world_.travelled(), findings_.explored, world_.contacts().size(), over()};
}

Findings Drive::findings() const {
  Findings findings = findings_;
  if (over()) return findings;
  world::Score score = world_.score();
  findings.contacts = std::move(score.contacts);
  findings.way = score.travelled;
  findings.reached_at = score.reached_at;
  return findings;
}

}  // namespace ctn::navigation::run
