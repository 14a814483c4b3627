#include "path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ctn::face_tracking {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(BearingOnSquare, GoesAllRoundInFourSides) {
  EXPECT_DOUBLE_EQ(bearing_on_square(0.0), 0.0);
  EXPECT_NEAR(bearing_on_square(0.5), kPi / 4, 1e-12);
  EXPECT_NEAR(bearing_on_square(1.0), kPi / 2, 1e-12);
  EXPECT_NEAR(bearing_on_square(4.0), 2 * kPi, 1e-12);
  EXPECT_NEAR(bearing_on_square(-3.0), -3 * kPi / 2, 1e-12);
}

TEST(BearingOnSquare, HasNoJumpAtCorners) {
  for (const double corner : {-1.5, -0.5, 0.5, 1.5, 2.5}) {
    EXPECT_NEAR(bearing_on_square(corner - 1e-9), bearing_on_square(corner + 1e-9), 1e-8);
  }
}

TEST(BearingOnSquare, IsFastestInTheMiddleOfASide) {
  const auto rate = [](double sides) {
    return (bearing_on_square(sides + 1e-6) - bearing_on_square(sides - 1e-6)) / 2e-6;
  };
  EXPECT_NEAR(rate(0.0) / rate(0.4999), 2.0, 0.01);
}

TEST(Wrapped, StaysInHalfATurn) {
  EXPECT_NEAR(wrapped(3 * kPi / 2), -kPi / 2, 1e-12);
  EXPECT_NEAR(wrapped(-7.0), -7.0 + 2 * kPi, 1e-12);
  EXPECT_DOUBLE_EQ(wrapped(kPi), -kPi);
}

TEST(Path, SameSeedSameWalk) {
  const Path one(1.2, 7);
  const Path same(1.2, 7);
  const Path other(1.2, 8);
  double apart = 0.0;
  for (double time = 0.0; time < 60.0; time += 0.1) {
    EXPECT_EQ(one.bearing(time), same.bearing(time));
    apart = std::max(apart, std::abs(one.bearing(time) - other.bearing(time)));
  }
  EXPECT_GT(apart, 0.5);
}

TEST(Path, MeanRateIsTheSpeed) {
  const double speed = 0.9;
  const Path path(speed, 3);
  double walked = 0.0;
  for (int i = 0; i < 600000; ++i) walked += std::abs(path.bearing((i + 1) * 0.001) - path.bearing(i * 0.001));
  EXPECT_NEAR(walked / 600.0, speed, 0.02);
}

TEST(Path, TurnsRoundNowAndThenAndNeverJumps) {
  const Path path(1.0, 5);
  int turns = 0;
  double before = 0.0;
  for (int i = 0; i < 60000; ++i) {
    const double step = path.bearing((i + 1) * 0.001) - path.bearing(i * 0.001);
    EXPECT_LE(std::abs(step), 0.001 * 4.0 / kPi + 1e-9);
    turns += step * before < 0.0 ? 1 : 0;
    before = step;
  }
  EXPECT_GE(turns, 60 / 3 - 1);
  EXPECT_LE(turns, 60 / 1 + 1);
}

}  // namespace
}  // namespace ctn::face_tracking
