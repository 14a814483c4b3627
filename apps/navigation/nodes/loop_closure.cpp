#include "loop_closure.h"

#include <algorithm>
#include <cmath>

#include "matcher.h"
#include "pose_graph.h"
#include "visibility.h"

namespace ctn::navigation {
namespace {

constexpr double kLoopFits = 0.6;      // the lowest score
constexpr double kMaxConflict = 0.03;  // of the points: on map 2 more in 7 % of the true matches
constexpr double kDeviations = 2.5;    // of where the robot may be, that the window is wide
constexpr Matcher::Window kMinWindow{0.24, 0.06};
constexpr Matcher::Window kMaxWindow{1.2, 0.2};  // the matcher's grid has no room for more

Matcher::Window window_for(const PoseMatrix& drift) {
  const double offset = kDeviations * std::sqrt(std::max(drift.xx, drift.yy));
  const double turn = kDeviations * std::sqrt(drift.hh);
  return {std::clamp(offset, kMinWindow.offset, kMaxWindow.offset), std::clamp(turn, kMinWindow.turn, kMaxWindow.turn)};
}

// Whether `one` saw through what `other` hit.
bool saw_through(const Sight& one, const Sight& other, Work& work) {
  const Conflict found = conflict(one.scan, between(one.pose, other.pose), other.still);
  work.beams += kBeamsForPoint * other.still.size();
  return static_cast<double>(found.free) > kMaxConflict * static_cast<double>(found.judged);
}

}  // namespace

std::optional<Recognised> recognise(const std::vector<Sight>& old, const Sight& now, const PoseMatrix& drift,
                                    Work& work) {
  Matcher matcher;
  matcher.start(now.pose);
  for (const Sight& sight : old) matcher.add(sight.pose, sight.still);
  const Matcher::Match found = matcher.match(now.still, window_for(drift), inverse(drift));
  work += matcher.take_work();
  if (found.score < kLoopFits) return std::nullopt;
  const Pose moved{found.pose.x - now.pose.x, found.pose.y - now.pose.y,
                   wrapped(found.pose.heading - now.pose.heading)};
  if (squared(inverse(drift + found.covariance), moved) > kOneInThousand) return std::nullopt;
  const Sight there{found.pose, now.scan, now.still};
  if (saw_through(old.front(), there, work) || saw_through(there, old.front(), work)) {
    return std::nullopt;
  }
  return Recognised{found.pose, found.covariance};
}

}  // namespace ctn::navigation
