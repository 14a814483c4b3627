#include "vio/standstill.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "vio/rotation.h"

namespace ctn::vr {
namespace {

ImuHistory standing(const Eigen::Quaterniond& orientation, const Eigen::Vector3d& gyro_bias, double shaking) {
  std::mt19937 random(6);
  std::normal_distribution<double> normal(0.0, 1.0);
  ImuHistory history(2000);
  for (int i = 0; i <= 200; ++i) {
    const Eigen::Vector3d noise(normal(random), normal(random), normal(random));
    history.add({0.005 * i, gyro_bias + 0.1 * shaking * noise,
                 orientation.conjugate() * Eigen::Vector3d(0.0, 0.0, kGravity) + shaking * noise});
  }
  return history;
}

TEST(Standstill, TellsUpAndTheGyroscopesBias) {
  const Eigen::Vector3d bias(0.01, -0.03, 0.08);
  for (const Eigen::Vector3d& tilt :
       {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.3, -0.5, 0.0), Eigen::Vector3d(3.0, 0.2, 0.1)}) {
    const Eigen::Quaterniond orientation = rotation(tilt);
    const std::optional<State> state = standing_state(standing(orientation, bias, 0.03), 1.0);
    ASSERT_TRUE(state);
    EXPECT_EQ(state->time, 1.0);
    const Eigen::Vector3d up = state->pose.orientation.conjugate() * Eigen::Vector3d::UnitZ();
    EXPECT_LT((up - orientation.conjugate() * Eigen::Vector3d::UnitZ()).norm(), 2e-3);
    EXPECT_NEAR(yaw_of(state->pose.orientation), 0.0, 1e-9);
    EXPECT_LT((state->gyro_bias - bias).norm(), 2e-3);
    EXPECT_EQ(state->velocity, Eigen::Vector3d(Eigen::Vector3d::Zero()));
  }
}

TEST(Standstill, IsNotTakenForMotion) {
  const Eigen::Quaterniond upright = Eigen::Quaterniond::Identity();
  EXPECT_FALSE(standing_state(standing(upright, {0.0, 0.0, 0.0}, 0.5), 1.0));   // shaken
  EXPECT_FALSE(standing_state(standing(upright, {0.0, 0.0, 0.5}, 0.01), 1.0));  // turning
  EXPECT_FALSE(standing_state(standing(upright, {0.0, 0.0, 0.0}, 0.01), 9.0));  // no samples
  EXPECT_FALSE(standing_state(standing(upright, {0.0, 0.0, 0.0}, 0.01), 0.1));
  EXPECT_FALSE(standing_state(ImuHistory(10), 1.0));
}

}  // namespace
}  // namespace ctn::vr
