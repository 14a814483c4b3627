#include "vio/cost.h"

#include <gtest/gtest.h>

namespace ctn::vr {
namespace {

TEST(TrackingCost, AddsUpAllKindsOfWork) {
  const Work work{1, 10, 100, 1000, 10'000, 100'000, 1'000'000, 10'000'000};
  const TrackingFactors factors{100'000'000.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0};
  EXPECT_DOUBLE_EQ(cost(factors, work), 112'345'678e-9);
  EXPECT_EQ(cost(TrackingFactors{}, work), 0.0);
}

TEST(TrackingCost, WorkAddsUp) {
  const Work work{1, 2, 3, 4, 5, 6, 7, 8};
  Work sum = work;
  sum += work;
  EXPECT_EQ(sum, (Work{2, 4, 6, 8, 10, 12, 14, 16}));
}

// A picture with features costs VIO more than one without; a sample costs Int less than a picture costs Camera.
TEST(TrackingCost, OfNodesIsInTheirOrder) {
  const Work picture{.moved = 307'200, .smoothed = 408'000};
  const Work features{.samples = 10, .cornered = 80'000, .windows = 400, .votes = 2000};
  EXPECT_LT(cost(TrackingNode::kIntegrator, {.samples = 1}), cost(TrackingNode::kCamera, picture));
  EXPECT_GT(cost(TrackingNode::kVio, features), cost(TrackingNode::kVio, {.samples = 10}));
}

}  // namespace
}  // namespace ctn::vr
