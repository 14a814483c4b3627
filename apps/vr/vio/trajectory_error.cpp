#include "vio/trajectory_error.h"

#include <algorithm>
#include <cmath>

#include "vio/rotation.h"

namespace ctn::vr {
namespace {

struct PosePair {
  double time;
  Pose estimated;
  Pose truth;
};

Pose interpolated(const StampedPose& before, const StampedPose& after, double time) {
  const double share = after.time > before.time ? (time - before.time) / (after.time - before.time) : 0.0;
  return {before.pose.orientation.slerp(share, after.pose.orientation),
          before.pose.position + share * (after.pose.position - before.pose.position)};
}

std::vector<PosePair> pairs_of(const std::vector<StampedPose>& estimated, const std::vector<StampedPose>& truth) {
  std::vector<PosePair> pairs;
  for (const StampedPose& pose : estimated) {
    const auto after = std::lower_bound(truth.begin(), truth.end(), pose.time,
                                        [](const StampedPose& one, double time) { return one.time < time; });
    if (after == truth.end()) break;
    if (after->time == pose.time) {
      pairs.push_back({pose.time, pose.pose, after->pose});
    } else if (after != truth.begin()) {
      pairs.push_back({pose.time, pose.pose, interpolated(*(after - 1), *after, pose.time)});
    }
  }
  return pairs;
}

void count(TrajectoryError& error, const Eigen::Vector3d& position, const Eigen::Quaterniond& rotation) {
  ++error.poses;
  error.position_rmse += position.squaredNorm();
  error.position_max = std::max(error.position_max, position.norm());
  error.rotation_rmse += rotation_vector(rotation).squaredNorm();
}

TrajectoryError with_roots(TrajectoryError error) {
  if (error.poses == 0) return error;
  error.position_rmse = std::sqrt(error.position_rmse / static_cast<double>(error.poses));
  error.rotation_rmse = std::sqrt(error.rotation_rmse / static_cast<double>(error.poses));
  return error;
}

}  // namespace

Pose aligned(const YawAlignment& alignment, const Pose& pose) {
  return transformed(Pose{rotation({0.0, 0.0, alignment.yaw}), alignment.translation}, pose);
}

TrajectoryError absolute_error(const std::vector<StampedPose>& estimated, const std::vector<StampedPose>& truth) {
  const std::vector<PosePair> pairs = pairs_of(estimated, truth);
  TrajectoryError error;
  if (pairs.empty()) return error;
  Eigen::Vector3d estimated_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d true_mean = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    estimated_mean += pair.estimated.position / static_cast<double>(pairs.size());
    true_mean += pair.truth.position / static_cast<double>(pairs.size());
  }
  // The yaw that turns the one set of points, about its mean, onto the other.
  double sine = 0.0;
  double cosine = 0.0;
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d from = pair.estimated.position - estimated_mean;
    const Eigen::Vector3d to = pair.truth.position - true_mean;
    sine += from.x() * to.y() - from.y() * to.x();
    cosine += from.x() * to.x() + from.y() * to.y();
  }
  error.alignment.yaw = std::atan2(sine, cosine);
  error.alignment.translation = true_mean - rotation({0.0, 0.0, error.alignment.yaw}) * estimated_mean;
  for (const PosePair& pair : pairs) {
    const Pose pose = aligned(error.alignment, pair.estimated);
    count(error, pose.position - pair.truth.position, pair.truth.orientation.conjugate() * pose.orientation);
  }
  return with_roots(error);
}

TrajectoryError relative_error(const std::vector<StampedPose>& estimated, const std::vector<StampedPose>& truth,
                               double seconds) {
  const std::vector<PosePair> pairs = pairs_of(estimated, truth);
  TrajectoryError error;
  std::size_t end = 0;
  for (const PosePair& begin : pairs) {
    while (end < pairs.size() && pairs[end].time < begin.time + seconds) ++end;
    if (end == pairs.size()) break;
    const Pose estimated_motion = transformed(inverse(begin.estimated), pairs[end].estimated);
    const Pose true_motion = transformed(inverse(begin.truth), pairs[end].truth);
    const Pose difference = transformed(inverse(true_motion), estimated_motion);
    count(error, difference.position, difference.orientation);
  }
  return with_roots(error);
}

}  // namespace ctn::vr
