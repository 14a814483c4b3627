#include "ros1/navigation/odometry_history.h"

#include <algorithm>

namespace ctn::navigation::ros1 {

void OdometryHistory::add(const Odometry& odometry) { kept_[added_++ % kKept] = odometry; }

std::optional<Odometry> OdometryHistory::at(std::chrono::nanoseconds stamp) const {
  const Odometry* newest = nullptr;
  for (std::size_t index = 0; index < std::min(added_, kKept); ++index) {
    const Odometry& one = kept_[index];
    if (one.stamp <= stamp && (newest == nullptr || one.stamp > newest->stamp)) newest = &one;
  }
  if (newest == nullptr) return std::nullopt;
  if (newest->stamp == stamp) return *newest;
  const double seconds = std::chrono::duration<double>(stamp - newest->stamp).count();
  const Velocity& velocity = newest->velocity;
  return Odometry{stamp, along_arc(newest->pose, velocity.linear * seconds, velocity.angular * seconds), velocity};
}

}  // namespace ctn::navigation::ros1
