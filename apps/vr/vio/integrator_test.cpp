#include "vio/integrator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "vio/rotation.h"
#include "vio/testing/synthetic.h"

namespace ctn::vr {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

double angle_between(const Pose& a, const Pose& b) {
  return rotation_vector(a.orientation.conjugate() * b.orientation).norm();
}

TEST(Integrator, KnowsNothingBeforeTheFirstFilteredState) {
  const testing::SyntheticHead head({.rest = 0.0});
  Integrator integrator;
  for (int i = 0; i < 10; ++i) integrator.add(head.exact_sample(0.005 * i));
  EXPECT_FALSE(integrator.newest());
  integrator.rebase(head.truth(0.02));
  ASSERT_TRUE(integrator.newest());
  EXPECT_NEAR(integrator.newest()->state.time, 0.045, 1e-12);
}

TEST(Integrator, FollowsTheHeadFromALateFilteredState) {
  const testing::SyntheticHead head({.rest = 0.0});
  Integrator integrator;
  std::uint64_t steps = 0;
  for (int i = 0; i <= 400; ++i) {
    const double time = 0.005 * i;
    steps += integrator.add(head.exact_sample(time)).samples;
    // VIO's states come 60 ms late, at times between samples.
    if (i % 10 == 0 && i >= 20) steps += integrator.rebase(head.truth(time - 0.0613)).samples;
    if (!integrator.newest()) continue;
    const State truth = head.truth(time);
    EXPECT_NEAR(integrator.newest()->state.time, time, 1e-12);
    EXPECT_LT((integrator.newest()->state.pose.position - truth.pose.position).norm(), 5e-4);
    EXPECT_LT(angle_between(integrator.newest()->state.pose, truth.pose), 5e-4);
    EXPECT_LT((integrator.newest()->angular_rate - head.exact_sample(time).angular_rate).norm(), 1e-9);
  }
  EXPECT_GT(steps, 380U + 38U * 12U);  // a step a sample, and for each filtered state those since
}

TEST(Integrator, IsWhereItWouldBeHadItHadTheFilteredStateBefore) {
  const testing::SyntheticHead head({.rest = 0.0});
  Integrator late;
  Integrator early;
  early.rebase(head.truth(1.0));
  late.rebase(head.truth(0.9));
  for (int i = 0; i < 40; ++i) {
    early.add(head.exact_sample(1.0 + 0.005 * i));
    late.add(head.exact_sample(1.0 + 0.005 * i));
  }
  late.rebase(head.truth(1.0));
  EXPECT_EQ(late.newest()->state.pose.position, early.newest()->state.pose.position);
  EXPECT_EQ(late.newest()->state.pose.orientation.coeffs(), early.newest()->state.pose.orientation.coeffs());
}

TEST(Integrator, LeavesOutFilteredStatesThatAreOldOrNoNumbers) {
  const testing::SyntheticHead head({.rest = 0.0});
  Integrator integrator;
  integrator.add(head.exact_sample(0.0));
  integrator.rebase(head.truth(1.0));
  const MovingState before = *integrator.newest();
  integrator.rebase(head.truth(0.5));
  State broken = head.truth(2.0);
  broken.velocity.x() = kNoNumber;
  integrator.rebase(broken);
  broken = head.truth(2.0);
  broken.time = kNoNumber;
  integrator.rebase(broken);
  EXPECT_EQ(integrator.newest()->state.time, before.state.time);
  EXPECT_EQ(integrator.newest()->state.pose.position, before.state.pose.position);
}

TEST(Integrator, StaysFiniteWhateverTheSamples) {
  const testing::SyntheticHead head({.rest = 0.0});
  Integrator integrator;
  integrator.rebase(head.truth(0.0));
  for (int i = 1; i < 200; ++i) {
    ImuSample sample = head.exact_sample(0.005 * i);
    if (i % 7 == 0) sample.time -= 0.5;
    if (i % 11 == 0) sample.angular_rate.z() = kNoNumber;
    if (i % 13 == 0) sample.acceleration.setConstant(std::numeric_limits<double>::infinity());
    if (i % 17 == 0) sample.time = kNoNumber;
    integrator.add(sample);
    ASSERT_TRUE(is_finite(integrator.newest()->state));
  }
  // Those that were right are enough.
  const State truth = head.truth(integrator.newest()->state.time);
  EXPECT_LT((integrator.newest()->state.pose.position - truth.pose.position).norm(), 0.01);
}

TEST(Integrator, AGapOfSecondsDoesNotThrowTheHeadThroughTheWall) {
  const testing::SyntheticHead head({.rest = 0.0});
  Integrator integrator;
  integrator.rebase(head.truth(1.0));
  integrator.add(head.exact_sample(1.0));
  integrator.add(head.exact_sample(9.0));
  EXPECT_EQ(integrator.newest()->state.time, 9.0);
  EXPECT_EQ(integrator.newest()->state.pose.position, head.truth(1.0).pose.position);
}

TEST(Integrator, GoesOnWhereVioIsLaterThanItsBuffer) {
  const testing::SyntheticHead head({.rest = 0.0});
  Integrator integrator;
  std::uint64_t samples = 0;
  for (std::size_t i = 0; i < 2 * Integrator::kMaxSamples; ++i)
    integrator.add(head.exact_sample(0.005 * static_cast<double>(i)));
  samples += integrator.rebase(head.truth(0.1)).samples;
  EXPECT_LE(samples, Integrator::kMaxSamples);
  EXPECT_TRUE(is_finite(integrator.newest()->state));
  EXPECT_NEAR(integrator.newest()->state.time, 0.005 * (2.0 * Integrator::kMaxSamples - 1.0), 1e-9);
}

TEST(Prediction, KeepsTurningAndMoving) {
  MovingState moving;
  moving.state.time = 2.0;
  moving.state.pose.orientation = rotation({0.0, 0.0, 0.5});
  moving.state.velocity = {1.0, 0.0, -0.5};
  moving.angular_rate = {0.0, 0.0, 3.0};
  const Pose pose = predicted(moving, 2.02);
  EXPECT_NEAR(yaw_of(pose.orientation), 0.56, 1e-12);
  EXPECT_LT((pose.position - Eigen::Vector3d(0.02, 0.0, -0.01)).norm(), 1e-12);
}

TEST(Prediction, IsBetterThanTheNewestPose) {
  const testing::SyntheticHead head({.rest = 0.0});
  double error = 0.0;
  double without = 0.0;
  for (int i = 0; i < 500; ++i) {
    const double time = 2.0 + 0.01 * i;
    const MovingState moving{head.truth(time), head.exact_sample(time).angular_rate};
    const Pose truth = head.truth(time + 0.02).pose;
    error += angle_between(predicted(moving, time + 0.02), truth);
    without += angle_between(moving.state.pose, truth);
  }
  EXPECT_LT(error, 0.1 * without);
}

TEST(Prediction, IsLimited) {
  MovingState moving;
  moving.state.time = 2.0;
  moving.state.velocity = {1.0, 0.0, 0.0};
  EXPECT_EQ(predicted(moving, 1.0).position.x(), 0.0);
  EXPECT_EQ(predicted(moving, kNoNumber).position.x(), 0.0);
  EXPECT_NEAR(predicted(moving, 1e9).position.x(), kMaxPrediction, 1e-12);
}

}  // namespace
}  // namespace ctn::vr
