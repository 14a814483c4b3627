#include "footprint.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "robot.h"

namespace ctn::navigation {
namespace {

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

}  // namespace

bool touches_static(const LocalMap& map, const Pose& pose, double margin, double& room, Work& work) {
  static const std::vector<Point> kOutline = make_outline();
  const double clear = map.static_clearance_at(position(pose));
  ++work.poses;
  room = std::min(room, clear);
  if (clear >= kOuterRadius + margin) return false;
  if (clear < kInnerRadius + std::min(0.0, margin)) return true;
  const double c = std::cos(pose.heading);
  const double s = std::sin(pose.heading);
  return std::any_of(kOutline.begin(), kOutline.end(), [&](const Point& point) {
    ++work.candidates;
    const Point at{pose.x + c * point.x - s * point.y, pose.y + s * point.x + c * point.y};
    return map.static_clearance_at(at) < margin;
  });
}

std::optional<double> margin_kept(const LocalMap& map, const Pose& pose, std::initializer_list<double> margins,
                                  Work& work) {
  double room = 0.0;
  for (const double margin : margins) {
    if (!touches_static(map, pose, margin, room, work)) return margin;
  }
  return std::nullopt;
}

double distance_from_outline(const Pose& pose, Point point) {
  const Point from = point - position(pose);
  const double c = std::cos(pose.heading);
  const double s = std::sin(pose.heading);
  const double ahead = std::max(0.0, std::abs(c * from.x + s * from.y) - kInnerRadius);
  const double aside = std::max(0.0, std::abs(c * from.y - s * from.x) - kInnerRadius);
  return std::sqrt(ahead * ahead + aside * aside);
}

}  // namespace ctn::navigation
