#include "local_mapper.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "footprint.h"
#include "robot.h"

namespace ctn::navigation {
namespace {

constexpr float kHit = 1.0F;
constexpr float kPassed = -0.6F;
constexpr float kMaxEvidence = 2.0F;      // evidence for an obstacle
constexpr float kMinEvidence = -1.0F;     // for a free cell
constexpr float kObstacle = 0.5F;         // from here on
constexpr double kRayStep = kCell / 2.0;  // along a beam: no cell is left out of which more than a corner is passed

constexpr float kFree = -0.5F;      // from here down, a cell is known to be free
constexpr float kLongAgo = -1e6F;   // seconds
constexpr double kFreshFor = 0.7;   // seconds for which a cell that something came into tells of motion
constexpr double kOld = 1.0;        // an obstacle that has been there for longer does not move
constexpr double kVeryOld = 3.0;    // nor is it then taken for something that was seen to move
constexpr double kBesideOld = 0.1;  // metres around an old obstacle within which nothing is taken to have moved
constexpr double kBesideOldPerMetre = 0.03;  // farther from the robot, errors of its heading count more
constexpr double kTakenOut = 0.06;           // metres around what moves

// `values` of the cells of `from`, for those of `to`.
template <typename T>
std::vector<T> on_frame(const GridFrame& from, const std::vector<T>& values, const GridFrame& to, T unknown) {
  std::vector<T> moved(to.cells(), unknown);
  const int left = std::max(from.left, to.left);
  const int right = std::min(from.left + from.width, to.left + to.width);
  const int top = std::min(from.bottom + from.height, to.bottom + to.height);
  for (int row = std::max(from.bottom, to.bottom); row < top && left < right; ++row) {
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(from.index(left - from.left, row - from.bottom));
    std::copy(begin, begin + (right - left),
              moved.begin() + static_cast<std::ptrdiff_t>(to.index(left - to.left, row - to.bottom)));
  }
  return moved;
}

float towards_nothing(float evidence, float step) {
  return evidence > 0.0F ? std::max(0.0F, evidence - step) : std::min(0.0F, evidence + step);
}

}  // namespace

double LocalMap::clearance_at(const Point& point) const {
  const int column = frame.column(point.x);
  const int row = frame.row(point.y);
  if (!frame.inside(column, row)) return LocalMapper::kFarthestClearance;
  return static_cast<double>(clearance[frame.index(column, row)]);
}

double LocalMap::static_clearance_at(const Point& point) const {
  const int column = frame.column(point.x);
  const int row = frame.row(point.y);
  if (!frame.inside(column, row)) return LocalMapper::kFarthestClearance;
  const std::vector<float>& distances = static_clearance.empty() ? clearance : static_clearance;
  return static_cast<double>(distances[frame.index(column, row)]);
}

void LocalMapper::move_to(const Pose& pose) {
  const int side = static_cast<int>(std::lround(kSide / kCell));
  const GridFrame next{static_cast<int>(std::floor(pose.x / kCell)) - side / 2,
                       static_cast<int>(std::floor(pose.y / kCell)) - side / 2, side, side};
  if (next == frame_) return;
  evidence_ = on_frame(frame_, evidence_, next, 0.0F);
  entered_ = on_frame(frame_, entered_, next, kLongAgo);
  occupied_ = on_frame(frame_, occupied_, next, kLongAgo);
  marked_.assign(next.cells(), 0);
  frame_ = next;
}

void LocalMapper::fade(double seconds) {
  const auto step = static_cast<float>(std::clamp(seconds / kMemory, 0.0, 1.0)) * kMaxEvidence;
  for (float& evidence : evidence_) evidence = towards_nothing(evidence, step);
}

bool LocalMapper::beside_old_obstacle(int column, int row, double range) const {
  const int beside = static_cast<int>(std::ceil((kBesideOld + kBesideOldPerMetre * range) / kCell));
  for (int y = row - beside; y <= row + beside; ++y) {
    for (int x = column - beside; x <= column + beside; ++x) {
      if (!frame_.inside(x, y)) continue;
      const std::size_t cell = frame_.index(x, y);
      if (evidence_[cell] >= kObstacle && since(occupied_[cell]) > kOld) return true;
    }
  }
  return false;
}

void LocalMapper::hit(int column, int row, double range) {
  const std::size_t cell = frame_.index(column, row);
  if (marked_[cell] == runs_) return;
  marked_[cell] = runs_;
  if (evidence_[cell] <= kFree && !beside_old_obstacle(column, row, range)) entered_[cell] = static_cast<float>(now_);
  if (evidence_[cell] < kObstacle && evidence_[cell] + kHit >= kObstacle) occupied_[cell] = static_cast<float>(now_);
  evidence_[cell] = std::min(kMaxEvidence, evidence_[cell] + kHit);
}

// Where the robot is, there is nothing else: what it touched, or what passed it too closely to be seen, left its trace.
void LocalMapper::clear_under(const Pose& pose, Work& work) {
  const double reach = kOuterRadius;
  for (int row = frame_.row(pose.y - reach); row <= frame_.row(pose.y + reach); ++row) {
    for (int column = frame_.column(pose.x - reach); column <= frame_.column(pose.x + reach); ++column) {
      ++work.cells;
      if (distance_from_outline(pose, frame_.centre(column, row)) > 0.0) continue;
      float& evidence = evidence_[frame_.index(column, row)];
      evidence = std::min(evidence, 0.0F);
    }
  }
}

// Obstacles that have come to be where it is while it moved through them.
void LocalMapper::take_out(const MovingObstacle& moving, std::vector<std::uint8_t>& obstacles) const {
  const double reach = moving.radius + kTakenOut;
  const double lately = std::max(kOld, 2.0 * reach / moving.speed());
  for (int row = frame_.row(moving.centre.y - reach); row <= frame_.row(moving.centre.y + reach); ++row) {
    for (int column = frame_.column(moving.centre.x - reach); column <= frame_.column(moving.centre.x + reach);
         ++column) {
      if (!frame_.inside(column, row)) continue;
      const std::size_t cell = frame_.index(column, row);
      if (obstacles[cell] == 0 || since(occupied_[cell]) > lately) continue;
      if (distance(frame_.centre(column, row), moving.centre) <= reach) obstacles[cell] = 0;
    }
  }
}

LocalMapper::Result LocalMapper::run(const CleanScan& scan) {
  const Pose& pose = scan.odometry.pose;
  Work work{.beams = scan.ranges.size()};
  const double interval = runs_ > 0 ? std::max(0.0, std::chrono::duration<double>(scan.stamp - stamp_).count()) : 0.0;
  fade(interval);
  now_ += interval;
  stamp_ = runs_ > 0 ? std::max(stamp_, scan.stamp) : scan.stamp;
  move_to(pose);
  ++runs_;

  std::vector<MotionTracker::Hit> hits(scan.ranges.size());
  // Obstacles first: a beam that grazes a cell in which another one ends must not clear that cell.
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const auto range = static_cast<double>(scan.ranges[beam]);
    if (!std::isfinite(range)) continue;
    const double angle = pose.heading + scan.angle(beam);
    const int column = frame_.column(pose.x + range * std::cos(angle));
    const int row = frame_.row(pose.y + range * std::sin(angle));
    if (!frame_.inside(column, row)) continue;
    hit(column, row, range);
    const std::size_t cell = frame_.index(column, row);
    if (since(entered_[cell]) < kFreshFor) hits[beam] = MotionTracker::Hit::kFresh;
    if (evidence_[cell] >= kObstacle && since(occupied_[cell]) > kVeryOld) hits[beam] = MotionTracker::Hit::kOld;
  }
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const double angle = pose.heading + scan.angle(beam);
    const double step_x = std::cos(angle) * kRayStep;
    const double step_y = std::sin(angle) * kRayStep;
    const double free = std::min({static_cast<double>(scan.ranges[beam]), scan.max_range, kSide});
    const int steps = static_cast<int>(free / kRayStep);
    for (int step = 0; step < steps; ++step) {
      const int column = frame_.column(pose.x + step * step_x);
      const int row = frame_.row(pose.y + step * step_y);
      if (!frame_.inside(column, row)) break;
      ++work.cells;
      const std::size_t cell = frame_.index(column, row);
      if (marked_[cell] == runs_) continue;
      marked_[cell] = runs_;
      evidence_[cell] = std::max(kMinEvidence, evidence_[cell] + kPassed);
    }
  }

  clear_under(pose, work);
  std::vector<std::uint8_t> obstacles(frame_.cells());
  std::transform(evidence_.begin(), evidence_.end(), obstacles.begin(),
                 [](float evidence) { return static_cast<std::uint8_t>(evidence >= kObstacle); });
  work.cells += 4 * frame_.cells();  // faded, judged, and twice on the way to distances
  LocalMap map{scan.stamp, scan.odometry, frame_, navigation::clearance(frame_, obstacles, kFarthestClearance), {}, {}};
  map.moving = tracker_.run(scan, hits, work);
  const auto moves = [](const MovingObstacle& moving) { return moving.moves(); };
  if (std::any_of(map.moving.begin(), map.moving.end(), moves)) {
    for (const MovingObstacle& moving : map.moving) {
      if (moving.moves()) take_out(moving, obstacles);
    }
    map.static_clearance = navigation::clearance(frame_, obstacles, kFarthestClearance);
    work.cells += 2 * frame_.cells();
  }
  return {std::move(map), work};
}

}  // namespace ctn::navigation
