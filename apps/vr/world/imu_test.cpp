#include "world/imu.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

namespace ctn::vr::world {
namespace {

// At rest, with the body turned by `orientation`.
class Still : public Trajectory {
 public:
  Still(double duration, const Eigen::Quaterniond& orientation) : duration_(duration), orientation_(orientation) {}
  Motion at(double) const override {
    Motion motion;
    motion.pose.orientation = orientation_;
    return motion;
  }
  double duration() const override { return duration_; }

 private:
  double duration_;
  Eigen::Quaterniond orientation_;
};

TEST(Imu, FeelsGravityAtRestAsAForceUpwards) {
  const Still still(1.0, Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2.0, Eigen::Vector3d::UnitX())));
  const Imu imu(still, 1, ImuNoise::none());
  EXPECT_EQ(imu.size(), 201U);
  const ImuSample sample = imu.sample(7);
  EXPECT_EQ(sample.time, 0.035);
  EXPECT_LT((sample.acceleration - Eigen::Vector3d(0.0, kGravity, 0.0)).norm(), 1e-12);
  EXPECT_EQ(sample.angular_rate.norm(), 0.0);
}

// Without noise, the samples of a second lead from the state at its begin to that at its end: by midpoints, whose error
// goes with the square of the period.
TEST(Imu, IsConsistentWithTheTrajectory) {
  const HeadTrajectory head({});
  const Imu imu(head, 1, ImuNoise::none(), 2000.0);
  State state = imu.truth(4000);
  const auto mean = [&](std::size_t i, auto member) -> Eigen::Vector3d {
    return 0.5 * (imu.sample(i).*member + imu.sample(i + 1).*member);
  };
  for (std::size_t i = 4000; i < 6000; ++i) {
    const double step = imu.time(i + 1) - imu.time(i);
    const Eigen::Vector3d turn = mean(i, &ImuSample::angular_rate) * step;
    const Eigen::AngleAxisd half(turn.norm() / 2.0, turn.normalized());
    const Eigen::Quaterniond middle = state.pose.orientation * half;
    const Eigen::Vector3d acceleration =
        middle * mean(i, &ImuSample::acceleration) - Eigen::Vector3d(0.0, 0.0, kGravity);
    state.pose.position += step * (state.velocity + 0.5 * step * acceleration);
    state.velocity += step * acceleration;
    state.pose.orientation = middle * half;
  }
  const State truth = imu.truth(6000);
  EXPECT_LT((state.pose.position - truth.pose.position).norm(), 1e-5);
  EXPECT_LT((state.velocity - truth.velocity).norm(), 1e-5);
  EXPECT_LT(state.pose.orientation.angularDistance(truth.pose.orientation), 1e-6);
}

TEST(Imu, HasTheNoiseThatItShould) {
  const Still still(500.0, Eigen::Quaterniond::Identity());
  ImuNoise noise;
  noise.gyro_walk = noise.accelerometer_walk = 0.0;
  const Imu imu(still, 5, noise);
  const State truth = imu.truth(0);
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < imu.size(); ++i) {
    const ImuSample sample = imu.sample(i);
    gyro += (sample.angular_rate - truth.gyro_bias).cwiseAbs2();
    accelerometer += (sample.acceleration - truth.accelerometer_bias - Eigen::Vector3d(0.0, 0.0, kGravity)).cwiseAbs2();
  }
  // Of 100 000 samples the standard deviation is known to 0.22 %: five times that.
  const auto count = static_cast<double>(imu.size());
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(std::sqrt(gyro[axis] / count) / (1.6968e-4 * std::sqrt(200.0)), 1.0, 0.011);
    EXPECT_NEAR(std::sqrt(accelerometer[axis] / count) / (2.0e-3 * std::sqrt(200.0)), 1.0, 0.011);
  }
}

TEST(Imu, ItsBiasesWalk) {
  const Still still(500.0, Eigen::Quaterniond::Identity());
  const Imu imu(still, 6);
  double gyro = 0.0;
  double accelerometer = 0.0;
  for (std::size_t i = 0; i + 200 < imu.size(); i += 200) {
    gyro += (imu.truth(i + 200).gyro_bias - imu.truth(i).gyro_bias).squaredNorm() / 3.0;
    accelerometer += (imu.truth(i + 200).accelerometer_bias - imu.truth(i).accelerometer_bias).squaredNorm() / 3.0;
  }
  // In a second a bias walks by the walk's density; of 1500 such ways that is known to 1.8 %: five times that.
  EXPECT_NEAR(std::sqrt(gyro / 500.0) / 1.9393e-5, 1.0, 0.09);
  EXPECT_NEAR(std::sqrt(accelerometer / 500.0) / 3.0e-3, 1.0, 0.09);
}

TEST(Imu, ItsNoiseDependsOnSeedAndNumberAlone) {
  const HeadTrajectory head({});
  const Imu one(head, 1);
  const Imu same(head, 1);
  const Imu other(head, 2);
  same.sample(10);
  EXPECT_EQ(one.sample(300).angular_rate, same.sample(300).angular_rate);
  EXPECT_EQ(one.sample(300).acceleration, same.sample(300).acceleration);
  EXPECT_NE(one.sample(300).angular_rate, other.sample(300).angular_rate);
  EXPECT_NE(one.truth(0).gyro_bias, other.truth(0).gyro_bias);
}

}  // namespace
}  // namespace ctn::vr::world
