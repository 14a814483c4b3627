#include "visibility.h"

#include <algorithm>
#include <cmath>

namespace ctn::navigation {
namespace {

constexpr std::size_t kBeside = kBeamsForPoint / 2;  // to each side: a wall that beams graze is nearer for one of them
constexpr double kWellBeyond = 0.3;                  // what moves covers more from keyframe to keyframe
constexpr double kReachOfSight = 10.0;               // farther places are seen too coarsely
constexpr std::size_t kWitnesses = 5;                // keyframes before a keyframe that show what moves

}  // namespace

Seen seen(const CleanScan& scan, const Point& place) {
  if (scan.ranges.size() <= 2 * kBeside) return Seen::kUnknown;
  const double away = std::hypot(place.x, place.y);
  const auto last = static_cast<double>(scan.ranges.size() - 1);
  const double at = (std::atan2(place.y, place.x) / scan.field + 0.5) * last;
  constexpr auto kEdge = static_cast<double>(kBeside);
  if (away > kReachOfSight || !(at >= kEdge) || at > last - kEdge) return Seen::kUnknown;
  const auto beam = static_cast<std::size_t>(std::lround(at));
  for (std::size_t i = beam - kBeside; i <= beam + kBeside; ++i) {
    const auto range = static_cast<double>(scan.ranges[i]);
    if (!std::isfinite(range)) return Seen::kUnknown;
    if (range < away + kWellBeyond) return Seen::kOther;
  }
  return Seen::kFree;
}

void remove_free(const CleanScan& scan, const Pose& from, std::vector<Point>& points) {
  const auto is_free = [&](const Point& point) { return seen(scan, transformed(from, point)) == Seen::kFree; };
  points.erase(std::remove_if(points.begin(), points.end(), is_free), points.end());
}

Conflict conflict(const CleanScan& scan, const Pose& from, const std::vector<Point>& points) {
  Conflict found;
  for (const Point& point : points) {
    const Seen what = seen(scan, transformed(from, point));
    if (what == Seen::kUnknown) continue;
    ++found.judged;
    if (what == Seen::kFree) ++found.free;
  }
  return found;
}

void StillPoints::add(const std::vector<Keyframe>& keyframes, Work& work) {
  for (std::size_t newest = points_.size(); newest < keyframes.size(); ++newest) {
    const Keyframe& after = keyframes[newest];
    std::vector<Point>& points = points_.emplace_back(after.scan->points);
    for (std::size_t i = newest - std::min(kWitnesses, newest); i < newest; ++i) {
      const Keyframe& before = keyframes[i];
      work.beams += kBeamsForPoint * (points.size() + points_[i].size());
      remove_free(*before.scan, between(before.pose, after.pose), points);
      remove_free(*after.scan, between(after.pose, before.pose), points_[i]);
    }
  }
}

}  // namespace ctn::navigation
