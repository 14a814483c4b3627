#include "model/portable_math.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

namespace ctn::model {
namespace {

double within(double min, double max, double fraction) { return min + (max - min) * fraction; }

double any_fraction() { return *rc::gen::inRange(0, 1'000'001) / 1e6; }

RC_GTEST_PROP(PortableMath, ExpIsTheLibrarys, ()) {
  const double x = within(-700.0, 700.0, any_fraction());
  RC_ASSERT(std::abs(portable_exp(x) / std::exp(x) - 1.0) < 2e-13);
}

RC_GTEST_PROP(PortableMath, LogIsTheLibrarys, ()) {
  const double x = std::exp(within(-600.0, 600.0, any_fraction()));
  RC_ASSERT(std::abs(portable_log(x) - std::log(x)) < 1e-13 * std::max(1.0, std::abs(std::log(x))));
}

RC_GTEST_PROP(PortableMath, InverseNormalInvertsTheDistribution, ()) {
  const double probability = within(1e-9, 1.0 - 1e-9, any_fraction());
  const double z = inverse_normal(probability);
  const double back = 0.5 * std::erfc(-z / std::sqrt(2.0));
  RC_ASSERT(std::abs(back - probability) < 1e-8 * std::max(probability, 1e-3));
}

TEST(PortableMath, KnowsTheTable) {
  EXPECT_NEAR(inverse_normal(0.95), 1.6448536269514722, 2e-9 * 1.7);
  EXPECT_EQ(inverse_normal(0.5), 0.0);
  EXPECT_NEAR(inverse_normal(0.001), -3.090232306167814, 1e-8);
  EXPECT_EQ(portable_exp(0.0), 1.0);
  EXPECT_EQ(portable_log(1.0), 0.0);
}

// To the last bit, here and everywhere: if this fails on a machine, so do comparisons of runs made on two.
TEST(PortableMath, IsExactlyTheSameEverywhere) {
  EXPECT_EQ(portable_exp(1.25), 0x1.bec38edb0fafp+1);
  EXPECT_EQ(portable_log(10.0), 0x1.26bb1bbb55515p+1);
  EXPECT_EQ(inverse_normal(0.01), -0x1.29c5c463cecf2p+1);
  EXPECT_EQ(inverse_normal(0.7), 0x1.0c7e395d14935p-1);
}

}  // namespace
}  // namespace ctn::model
