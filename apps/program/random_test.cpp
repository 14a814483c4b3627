#include "program/random.h"

#include <gtest/gtest.h>

namespace ctn::program {
namespace {

TEST(Noise, IsNormal) {
  const Noise noise(3, 9);
  constexpr int kCount = 200'000;
  double sum = 0.0;
  double squares = 0.0;
  double neighbours = 0.0;
  int beyond_two = 0;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const double value = noise.normal(i);
    sum += value;
    squares += value * value;
    neighbours += value * noise.normal(i + 1);
    beyond_two += std::abs(value) > 2.0 ? 1 : 0;
  }
  // Five standard errors.
  EXPECT_NEAR(sum / kCount, 0.0, 0.012);
  EXPECT_NEAR(squares / kCount, 1.0, 0.016);
  EXPECT_NEAR(neighbours / kCount, 0.0, 0.012);
  EXPECT_NEAR(static_cast<double>(beyond_two) / kCount, 0.0455, 0.0024);
}

TEST(Noise, DependsOnSeedStreamAndIndex) {
  EXPECT_EQ(Noise(1, 2).normal(3), Noise(1, 2).normal(3));
  EXPECT_NE(Noise(1, 2).normal(3), Noise(2, 2).normal(3));
  EXPECT_NE(Noise(1, 2).normal(3), Noise(1, 3).normal(3));
  EXPECT_NE(Noise(1, 2).normal(3), Noise(1, 2).normal(4));
}

TEST(Draws, StayInTheirRangeAndReachItsEnds) {
  Draws draws(5, 1);
  int low = 0;
  int high = 0;
  for (int i = 0; i < 1000; ++i) {
    const int value = draws.between(2, 4);
    ASSERT_GE(value, 2);
    ASSERT_LE(value, 4);
    low += value == 2 ? 1 : 0;
    high += value == 4 ? 1 : 0;
  }
  EXPECT_GT(low, 250);
  EXPECT_GT(high, 250);
}

}  // namespace
}  // namespace ctn::program
