#include "world/trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace ctn::vr::world {
namespace {

constexpr double kToDegrees = 180.0 / std::numbers::pi;

// The rotation from one orientation to another, as a vector in the frame of the first.
Eigen::Vector3d turn_between(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  const Eigen::AngleAxisd turn(from.conjugate() * to);
  return turn.angle() * turn.axis();
}

// Central differences, whose error goes with the square of the step.
void expect_consistent(const Trajectory& trajectory, double rotation_limit, double velocity_limit,
                       double acceleration_limit) {
  constexpr double kStep = 1e-5;
  for (double time = 0.01; time < trajectory.duration() - 0.01; time += 0.0173) {
    const Motion before = trajectory.at(time - kStep);
    const Motion motion = trajectory.at(time);
    const Motion after = trajectory.at(time + kStep);
    const Eigen::Vector3d velocity = (after.pose.position - before.pose.position) / (2.0 * kStep);
    const Eigen::Vector3d acceleration = (after.velocity - before.velocity) / (2.0 * kStep);
    const Eigen::Vector3d rate = turn_between(motion.pose.orientation, after.pose.orientation) / kStep / 2.0 -
                                 turn_between(motion.pose.orientation, before.pose.orientation) / kStep / 2.0;
    ASSERT_LT((velocity - motion.velocity).norm(), velocity_limit) << time;
    ASSERT_LT((acceleration - motion.acceleration).norm(), acceleration_limit) << time;
    ASSERT_LT((rate - motion.angular_rate).norm(), rotation_limit) << time;
    ASSERT_NEAR(motion.pose.orientation.norm(), 1.0, 1e-12);
  }
}

// Nothing jumps: what changes within a step is in proportion to the step.
void expect_smooth(const Trajectory& trajectory, double jerk_limit, double angular_acceleration_limit) {
  constexpr double kStep = 1e-3;
  Motion before = trajectory.at(0.001);
  for (double time = 0.001 + kStep; time < trajectory.duration() - 0.001; time += kStep) {
    const Motion motion = trajectory.at(time);
    ASSERT_LT((motion.acceleration - before.acceleration).norm(), jerk_limit * kStep) << time;
    ASSERT_LT((motion.angular_rate - before.angular_rate).norm(), angular_acceleration_limit * kStep) << time;
    before = motion;
  }
}

TEST(HeadTrajectory, IsConsistent) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    HeadOptions options;
    options.seed = seed;
    const HeadTrajectory trajectory(options);
    expect_consistent(trajectory, 1e-6, 1e-6, 1e-5);
    expect_smooth(trajectory, 2000.0, 100.0);
  }
}

TEST(HeadTrajectory, TurnsAsFastAsItMayAndNoFaster) {
  HeadOptions options;
  options.duration = 600.0;
  for (const double limit : {200.0, 90.0}) {
    options.max_turn_rate = limit / kToDegrees;
    const HeadTrajectory trajectory(options);
    double fastest = 0.0;
    for (double time = 0.0; time <= options.duration; time += 0.002) {
      fastest = std::max(fastest, trajectory.at(time).angular_rate.norm() * kToDegrees);
    }
    EXPECT_LE(fastest, limit);
    EXPECT_GE(fastest, 0.9 * limit);
  }
}

TEST(HeadTrajectory, WalksAboutWithinItsReach) {
  HeadOptions options;
  options.duration = 300.0;
  const HeadTrajectory trajectory(options);
  double way = 0.0;
  double speed = 0.0;
  Eigen::Vector3d low = trajectory.at(0.0).pose.position;
  Eigen::Vector3d high = low;
  for (double time = 0.0; time <= options.duration; time += 0.01) {
    const Motion motion = trajectory.at(time);
    low = low.cwiseMin(motion.pose.position);
    high = high.cwiseMax(motion.pose.position);
    way += motion.velocity.head<2>().norm() * 0.01;
    speed = std::max(speed, motion.velocity.norm());
  }
  // The head is 18 cm from the neck, and sways by half a centimetre.
  EXPECT_LT(std::max(-low.x(), high.x()), options.reach_x + 0.19);
  EXPECT_LT(std::max(-low.y(), high.y()), options.reach_y + 0.19);
  EXPECT_GT(high.x() - low.x(), options.reach_x);
  EXPECT_GT(high.y() - low.y(), options.reach_y);
  EXPECT_GT(low.z(), options.height);
  EXPECT_LT(high.z(), options.height + 0.25);
  EXPECT_GT(way, 60.0);
  EXPECT_LT(speed, 2.0);
}

TEST(HeadTrajectory, RestsAtFirstButForTheSway) {
  const HeadTrajectory trajectory({});
  for (double time = 0.0; time < 1.0; time += 0.01) {
    const Motion motion = trajectory.at(time);
    EXPECT_LT(motion.angular_rate.norm() * kToDegrees, 3.0);
    EXPECT_LT(motion.velocity.norm(), 0.05);
    EXPECT_LT(motion.acceleration.norm(), 0.2);
  }
}

TEST(HeadTrajectory, DependsOnTheSeedAlone) {
  HeadOptions options;
  const HeadTrajectory one(options);
  const HeadTrajectory same(options);
  options.seed = 2;
  const HeadTrajectory other(options);
  for (double time = 0.0; time < options.duration; time += 0.25) {
    EXPECT_EQ(one.at(time).pose.position, same.at(time).pose.position) << time;
    EXPECT_EQ(one.at(time).pose.orientation.coeffs(), same.at(time).pose.orientation.coeffs()) << time;
  }
  EXPECT_NE(one.at(20.0).pose.position, other.at(20.0).pose.position);
  EXPECT_NE(one.at(20.0).pose.orientation.coeffs(), other.at(20.0).pose.orientation.coeffs());
}

TEST(Trajectory, StaysWhereItEnds) {
  const HeadTrajectory trajectory({});
  const Motion after = trajectory.at(trajectory.duration() + 5.0);
  EXPECT_EQ(after.pose.position, trajectory.at(trajectory.duration()).pose.position);
  EXPECT_EQ(after.velocity.norm() + after.acceleration.norm() + after.angular_rate.norm(), 0.0);
}

std::vector<TimedPose> recorded(const Trajectory& trajectory, double begin, double spacing) {
  std::vector<TimedPose> poses;
  for (int i = 0; i * spacing <= trajectory.duration(); ++i) {
    TimedPose pose{begin + i * spacing, trajectory.at(i * spacing).pose};
    if (i % 2 == 1) pose.pose.orientation.coeffs() *= -1.0;  // the same orientation
    poses.push_back(pose);
  }
  return poses;
}

TEST(RecordedTrajectory, IsConsistent) {
  HeadOptions options;
  options.duration = 10.0;
  const HeadTrajectory head(options);
  for (const double spacing : {0.005, 0.05}) {
    const RecordedTrajectory trajectory(recorded(head, 7.0, spacing));
    EXPECT_NEAR(trajectory.duration(), 10.0, spacing);
    // Its third derivative jumps, so differences across a control are less exact.
    expect_consistent(trajectory, 1e-3, 1e-5, 0.02);
    expect_smooth(trajectory, 2000.0, 200.0);
  }
}

TEST(RecordedTrajectory, StaysWithWhatWasRecorded) {
  HeadOptions options;
  options.duration = 10.0;
  const HeadTrajectory head(options);
  const Eigen::Vector3d offset(1.0, -2.0, 0.5);
  const RecordedTrajectory trajectory(recorded(head, 7.0, 0.005), offset);
  for (double time = 0.0; time < 9.9; time += 0.013) {
    const Pose truth = head.at(time).pose;
    const Pose pose = trajectory.at(time).pose;
    EXPECT_LT((pose.position - truth.position - offset).norm(), 0.002) << time;
    EXPECT_LT(turn_between(pose.orientation, truth.orientation).norm() * kToDegrees, 0.4) << time;
  }
}

// A turn at a constant rate, which a spline on SO(3) follows exactly.
TEST(RecordedTrajectory, KeepsAConstantTurn) {
  std::vector<TimedPose> poses;
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, 3.0).normalized();
  for (int i = 0; i <= 100; ++i) {
    const double time = 0.025 * i;
    poses.push_back({time, {Eigen::Quaterniond(Eigen::AngleAxisd(2.0 * time, axis)), {time, 0.0, 0.0}}});
  }
  const RecordedTrajectory trajectory(poses);
  for (double time = 0.1; time < 2.4; time += 0.017) {
    const Motion motion = trajectory.at(time);
    EXPECT_LT((motion.angular_rate - 2.0 * axis).norm(), 1e-9);
    EXPECT_NEAR(motion.velocity.x(), 1.0, 1e-9);
    EXPECT_NEAR(motion.pose.position.x(), time, 1e-9);
    EXPECT_LT(motion.acceleration.norm(), 1e-9);
  }
}

}  // namespace
}  // namespace ctn::vr::world
