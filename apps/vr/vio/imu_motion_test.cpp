#include "vio/imu_motion.h"

#include <gtest/gtest.h>

#include <limits>

#include "vio/rotation.h"
#include "vio/testing/synthetic.h"

namespace ctn::vr {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

ImuSample resting(double time) { return {time, Eigen::Vector3d::Zero(), {0.0, 0.0, kGravity}}; }

TEST(Rotation, OfAVectorAndBack) {
  for (const double angle : {0.0, 1e-9, 1e-3, 1.0, 3.1}) {
    const Eigen::Vector3d vector = angle * Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
    EXPECT_LT((rotation_vector(rotation(vector)) - vector).norm(), 1e-9) << angle;
    const Eigen::Quaterniond other_sign(-rotation(vector).coeffs());
    EXPECT_LT((rotation_vector(other_sign) - vector).norm(), 1e-9) << angle;
  }
  EXPECT_NEAR(yaw_of(rotation({0.0, 0.0, 0.7})), 0.7, 1e-12);
}

TEST(ImuMotion, FollowsAHeadThatTurnsFast) {
  const testing::SyntheticHead head({.rest = 0.0});
  State state = head.truth(3.0);
  for (int i = 0; i < 400; ++i) {
    const double time = 3.0 + 0.005 * i;
    state = moved(state, head.exact_sample(time), head.exact_sample(time + 0.005));
  }
  const State truth = head.truth(5.0);
  // What is left is that rates are not linear between samples.
  EXPECT_LT((state.pose.position - truth.pose.position).norm(), 2e-3);
  EXPECT_LT((state.velocity - truth.velocity).norm(), 2e-3);
  EXPECT_LT(rotation_vector(truth.pose.orientation.conjugate() * state.pose.orientation).norm(), 2e-4);
}

TEST(ImuMotion, TakesBiasesOff) {
  State state;
  state.gyro_bias = {0.1, -0.2, 0.3};
  state.accelerometer_bias = {0.4, 0.5, -0.6};
  ImuSample from = resting(0.0);
  from.angular_rate = state.gyro_bias;
  from.acceleration += state.accelerometer_bias;
  ImuSample to = from;
  to.time = 0.01;
  const State next = moved(state, from, to);
  EXPECT_LT(next.pose.position.norm(), 1e-12);
  EXPECT_LT(next.velocity.norm(), 1e-12);
  EXPECT_LT(rotation_vector(next.pose.orientation).norm(), 1e-12);
  EXPECT_EQ(next.time, 0.01);
}

TEST(ImuMotion, StandsStillWhereSamplesAreMissing) {
  State state;
  state.velocity = {1.0, 0.0, 0.0};
  const State next = moved(state, resting(0.0), resting(5.0));
  EXPECT_EQ(next.time, 5.0);
  EXPECT_EQ(next.pose.position, state.pose.position);
  EXPECT_EQ(next.velocity, Eigen::Vector3d(Eigen::Vector3d::Zero()));
}

TEST(ImuMotion, TimeDoesNotRunBackwards) {
  State state;
  state.time = 1.0;
  state.velocity = {1.0, 0.0, 0.0};
  EXPECT_EQ(moved(state, resting(0.0), resting(0.5)).time, 1.0);
  EXPECT_EQ(moved(state, resting(0.0), resting(kNotANumber)).pose.position, state.pose.position);
}

TEST(ImuHistory, RefusesWhatNoSensorMeasures) {
  ImuHistory history(10);
  EXPECT_TRUE(history.add(resting(1.0)));
  EXPECT_FALSE(history.add(resting(1.0)));
  EXPECT_FALSE(history.add(resting(0.5)));
  EXPECT_FALSE(history.add(resting(kNotANumber)));
  EXPECT_FALSE(history.add(resting(std::numeric_limits<double>::infinity())));
  ImuSample sample = resting(2.0);
  sample.angular_rate.y() = kNotANumber;
  EXPECT_FALSE(history.add(sample));
  sample = resting(2.0);
  sample.acceleration.x() = 1e30;
  EXPECT_FALSE(history.add(sample));
  EXPECT_TRUE(history.add(resting(2.0)));
  EXPECT_EQ(history.samples().size(), 2U);
}

TEST(ImuHistory, GivesAStretchWithInterpolatedEnds) {
  ImuHistory history(10);
  for (int i = 0; i < 4; ++i) history.add({0.1 * i, {1.0 * i, 0.0, 0.0}, {0.0, 0.0, kGravity}});
  const std::vector<ImuSample> between = history.between(0.05, 0.25);
  ASSERT_EQ(between.size(), 4U);
  EXPECT_EQ(between.front().time, 0.05);
  EXPECT_NEAR(between.front().angular_rate.x(), 0.5, 1e-12);
  EXPECT_NEAR(between[1].angular_rate.x(), 1.0, 1e-12);
  EXPECT_EQ(between.back().time, 0.25);
  EXPECT_NEAR(between.back().angular_rate.x(), 2.5, 1e-12);
  // Beyond the samples, the nearest one.
  EXPECT_EQ(history.between(-1.0, 9.0).front().angular_rate.x(), 0.0);
  EXPECT_EQ(history.between(-1.0, 9.0).back().angular_rate.x(), 3.0);
  EXPECT_TRUE(history.between(1.0, 1.0).empty());
  EXPECT_TRUE(history.between(1.0, kNotANumber).empty());
  EXPECT_TRUE(ImuHistory(3).between(0.0, 1.0).empty());
}

TEST(ImuHistory, IsBounded) {
  ImuHistory history(10);
  for (int i = 0; i < 100; ++i) history.add(resting(i));
  EXPECT_EQ(history.samples().size(), 10U);
  history.forget_before(95.5);
  EXPECT_EQ(history.samples().front().time, 95.0);
  history.forget_before(1000.0);
  EXPECT_EQ(history.samples().size(), 1U);
}

}  // namespace
}  // namespace ctn::vr
