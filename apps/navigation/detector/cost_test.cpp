#include "detector/cost.h"

#include <gtest/gtest.h>

namespace ctn::navigation {
namespace {

TEST(PictureCost, AddsUpAllKindsOfWorkAndSlowsDown) {
  const PictureWork work{1, 10, 100, 1000, 10000, 100000, 1000000};
  const PictureCosts costs{7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0};
  EXPECT_DOUBLE_EQ(cost(work, 1.0, costs), 1234567e-9);
  EXPECT_DOUBLE_EQ(cost(work, 3.0, costs), 3.0 * 1234567e-9);
  EXPECT_EQ(cost(PictureWork{}, 1.0, costs), 0.0);
}

}  // namespace
}  // namespace ctn::navigation
