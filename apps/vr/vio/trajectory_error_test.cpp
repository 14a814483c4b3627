#include "vio/trajectory_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "vio/rotation.h"
#include "vio/testing/synthetic.h"

namespace ctn::vr {
namespace {

std::vector<StampedPose> path(double seconds) {
  const testing::SyntheticHead head({.rest = 0.0});
  std::vector<StampedPose> poses;
  for (int i = 0; i < static_cast<int>(seconds * 20.0); ++i) poses.push_back({0.05 * i, head.truth(0.05 * i).pose});
  return poses;
}

TEST(TrajectoryError, IsZeroButForYawAndPosition) {
  const std::vector<StampedPose> truth = path(20.0);
  const YawAlignment away{2.0, {3.0, -4.0, 5.0}};
  std::vector<StampedPose> estimated;
  for (const StampedPose& pose : truth) estimated.push_back({pose.time, aligned(away, pose.pose)});
  const TrajectoryError error = absolute_error(estimated, truth);
  EXPECT_EQ(error.poses, truth.size());
  EXPECT_LT(error.position_rmse, 1e-9);
  EXPECT_LT(error.rotation_rmse, 1e-9);
  EXPECT_NEAR(error.alignment.yaw, -2.0, 1e-9);
  EXPECT_LT(relative_error(estimated, truth, 1.0).position_rmse, 1e-9);
}

TEST(TrajectoryError, DoesNotForgiveAWrongTiltOrScale) {
  const std::vector<StampedPose> truth = path(20.0);
  std::vector<StampedPose> tilted;
  std::vector<StampedPose> scaled;
  for (const StampedPose& pose : truth) {
    tilted.push_back({pose.time, transformed(Pose{rotation({0.1, 0.0, 0.0}), Eigen::Vector3d::Zero()}, pose.pose)});
    scaled.push_back({pose.time, {pose.pose.orientation, 1.1 * pose.pose.position}});
  }
  EXPECT_GT(absolute_error(tilted, truth).position_rmse, 0.02);
  EXPECT_NEAR(absolute_error(tilted, truth).rotation_rmse, 0.1, 0.01);
  EXPECT_GT(absolute_error(scaled, truth).position_rmse, 0.05);
}

// One draw a line: in which order arguments are evaluated is the compiler's choice.
template <class Draw>
Eigen::Vector3d drawn(Draw& draw) {
  const double x = draw();
  const double y = draw();
  const double z = draw();
  return {x, y, z};
}

template <class Draw>
std::vector<StampedPose> noisy(std::vector<StampedPose> poses, Draw&& draw) {
  for (StampedPose& pose : poses) pose.pose.position += drawn(draw);
  return poses;
}

TEST(TrajectoryError, IsThatOfNoise) {
  const std::vector<StampedPose> truth = path(50.0);
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.0, 0.1);
  const std::vector<StampedPose> estimated = noisy(truth, [&] { return normal(random); });
  EXPECT_NEAR(absolute_error(estimated, truth).position_rmse, 0.1 * std::sqrt(3.0), 0.01);
  EXPECT_NEAR(relative_error(estimated, truth, 1.0).position_rmse, 0.1 * std::sqrt(6.0), 0.02);
}

// No other yaw and translation make the error smaller.
TEST(TrajectoryError, AlignsBest) {
  const std::vector<StampedPose> truth = path(20.0);
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0.0, 0.3);
  const auto draw = [&] { return normal(random); };
  const std::vector<StampedPose> estimated = noisy(truth, draw);
  const TrajectoryError best = absolute_error(estimated, truth);
  for (int i = 0; i < 200; ++i) {
    const YawAlignment other{best.alignment.yaw + 0.1 * draw(), best.alignment.translation + 0.1 * drawn(draw)};
    double sum = 0.0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      sum += (aligned(other, estimated[k].pose).position - truth[k].pose.position).squaredNorm();
    }
    EXPECT_GE(std::sqrt(sum / static_cast<double>(truth.size())), best.position_rmse - 1e-12);
  }
}

TEST(TrajectoryError, InterpolatesTheTruthAndLeavesOutWhatItLacks) {
  const std::vector<StampedPose> truth = path(10.0);
  const testing::SyntheticHead head({.rest = 0.0});
  std::vector<StampedPose> estimated;
  for (int i = -20; i < 400; ++i) {
    const double time = 0.0371 * i;
    estimated.push_back({time, head.truth(time).pose});
  }
  const TrajectoryError error = absolute_error(estimated, truth);
  EXPECT_EQ(error.poses, 269U);  // from 0 to 9.95 s
  EXPECT_LT(error.position_rmse, 2e-3);
}

TEST(TrajectoryError, OfNothing) {
  EXPECT_EQ(absolute_error({}, path(1.0)).poses, 0U);
  EXPECT_EQ(absolute_error(path(1.0), {}).poses, 0U);
  EXPECT_EQ(relative_error(path(1.0), path(1.0), 5.0).poses, 0U);
  EXPECT_EQ(absolute_error({}, {}).position_rmse, 0.0);
}

}  // namespace
}  // namespace ctn::vr
