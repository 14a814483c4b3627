#include "local_mapper.h"

#include <algorithm>
#include <cmath>

namespace ctn::navigation {
namespace {

constexpr float kHit = 1.0F;
constexpr float kPassed = -0.6F;
constexpr float kMaxEvidence = 2.0F;      // evidence for an obstacle
constexpr float kMinEvidence = -1.0F;     // for a free cell
constexpr float kObstacle = 0.5F;         // from here on
constexpr double kRayStep = kCell / 2.0;  // along a beam: no cell is left out of which more than a corner is passed

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

void LocalMapper::move_to(const Pose& pose) {
  const int side = static_cast<int>(std::lround(kSide / kCell));
  const GridFrame next{static_cast<int>(std::floor(pose.x / kCell)) - side / 2,
                       static_cast<int>(std::floor(pose.y / kCell)) - side / 2, side, side};
  if (next == frame_) return;
  std::vector<float> moved(next.cells(), 0.0F);
  for (int row = 0; row < next.height; ++row) {
    const int old_row = row + next.bottom - frame_.bottom;
    for (int column = 0; column < next.width; ++column) {
      const int old_column = column + next.left - frame_.left;
      if (!frame_.inside(old_column, old_row)) continue;
      moved[next.index(column, row)] = evidence_[frame_.index(old_column, old_row)];
    }
  }
  evidence_ = std::move(moved);
  marked_.assign(next.cells(), 0);
  frame_ = next;
}

void LocalMapper::fade(double seconds) {
  const auto step = static_cast<float>(std::clamp(seconds / kMemory, 0.0, 1.0)) * kMaxEvidence;
  for (float& evidence : evidence_) evidence = towards_nothing(evidence, step);
}

LocalMapper::Result LocalMapper::run(const CleanScan& scan) {
  const Pose& pose = scan.odometry.pose;
  Work work{.beams = scan.ranges.size()};
  if (runs_ > 0) fade(std::chrono::duration<double>(scan.stamp - stamp_).count());
  stamp_ = runs_ > 0 ? std::max(stamp_, scan.stamp) : scan.stamp;
  move_to(pose);
  ++runs_;

  // Obstacles first: a beam that grazes a cell in which another one ends must not clear that cell.
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const auto range = static_cast<double>(scan.ranges[beam]);
    if (!std::isfinite(range)) continue;
    const double angle = pose.heading + scan.angle(beam);
    const int column = frame_.column(pose.x + range * std::cos(angle));
    const int row = frame_.row(pose.y + range * std::sin(angle));
    if (!frame_.inside(column, row)) continue;
    const std::size_t cell = frame_.index(column, row);
    if (marked_[cell] == runs_) continue;
    marked_[cell] = runs_;
    evidence_[cell] = std::min(kMaxEvidence, evidence_[cell] + kHit);
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

  std::vector<std::uint8_t> obstacles(frame_.cells());
  std::transform(evidence_.begin(), evidence_.end(), obstacles.begin(),
                 [](float evidence) { return static_cast<std::uint8_t>(evidence >= kObstacle); });
  work.cells += 4 * frame_.cells();  // faded, judged, and twice on the way to distances
  return {{scan.stamp, scan.odometry, frame_, navigation::clearance(frame_, obstacles, kFarthestClearance)}, work};
}

}  // namespace ctn::navigation
