#include "navigation_command.h"

#include <cstddef>

namespace ctn::navigation {

NavigationCommand::Result NavigationCommand::run(const Path& path, const Localization& localization,
                                                 const Odometry& odometry) const {
  Result result;
  result.command.stamp = odometry.stamp;
  result.command.look_around = path.outcome == Path::Outcome::kNoWay || path.outcome == Path::Outcome::kNothingLeft;
  if (path.outcome != Path::Outcome::kFound || path.points.empty()) return result;

  const Pose correction = localization.correction_on(path.anchor);
  const Point robot = position(transformed(correction, odometry.pose));
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    if (distance(path.points[i], robot) < distance(path.points[nearest], robot)) nearest = i;
  }
  double along = distance(path.points[nearest], robot);
  std::size_t carrot = along >= kLookahead ? nearest : path.points.size() - 1;
  for (std::size_t i = nearest + 1; i < path.points.size(); ++i) {
    const double before = along;
    along += distance(path.points[i - 1], path.points[i]);
    if (before < kLookahead && along >= kLookahead) carrot = i;
  }
  result.work.candidates = 2 * path.points.size();
  if (distance(path.points.back(), robot) <= kArrived) {
    result.command.arrived = path.to_goal;
    return result;
  }
  result.command.stop = false;
  const Pose to_odometry = inverse(correction);
  result.command.carrot = transformed(to_odometry, path.points[carrot]);
  for (std::size_t i = carrot; i < path.points.size() && distance(path.points[i], robot) <= kBeyond; ++i) {
    result.command.beyond.push_back(transformed(to_odometry, path.points[i]));
  }
  result.command.distance_left = along;
  return result;
}

}  // namespace ctn::navigation
