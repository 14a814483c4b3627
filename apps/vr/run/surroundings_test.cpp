#include "run/surroundings.h"

#include <gtest/gtest.h>

#include <numbers>

#include "run/testing/small_dataset.h"

namespace ctn::vr::run {
namespace {

using namespace std::chrono_literals;

// Beyond its ends nobody knows where the head was; the pose at the end used to be taken for the truth.
TEST(Surroundings, OfADataSetTheTruthIsKnownWithinItsSpanAlone) {
  const testing::SmallDataset dataset({0ms}, {1s, 1500ms, 2s});
  Options options;
  options.dataset = dataset.folder();
  const auto made = Surroundings::make(options, 5ms);
  ASSERT_TRUE(made.ok()) << made.error().message();
  const Surroundings& surroundings = **made;
  EXPECT_FALSE(surroundings.truth(999ms));
  EXPECT_FALSE(surroundings.true_eye(999ms));
  EXPECT_TRUE(surroundings.truth(1s));
  EXPECT_TRUE(surroundings.truth(1700ms));
  EXPECT_TRUE(surroundings.true_eye(2s));
  EXPECT_FALSE(surroundings.truth(2001ms));
}

// The truth of a data set may begin before its inertial samples: tracking began where the head had been then.
TEST(Surroundings, TrackingBeginsWhereTheHeadIsAtTheFirstSample) {
  const testing::SmallDataset dataset({0ms}, {0ms});
  // A metre and a quarter of a turn about z in two seconds, half of it before the first sample.
  dataset.write("state_groundtruth_estimate0/data.csv",
                "1403715272262142976,0,0,0,1,0,0,0,0,0,0,0,0,0,0.5,0,0\n"
                "1403715274262142976,1,0,0,0.70710678118654752,0,0,0.70710678118654752,2,0,0,0,0,0,1.5,0,0\n");
  Options options;
  options.dataset = dataset.folder();
  const auto made = Surroundings::make(options, 5ms);
  ASSERT_TRUE(made.ok()) << made.error().message();
  const auto& start = (*made)->start();
  ASSERT_TRUE(start);
  EXPECT_EQ(start->time, 0.0);
  EXPECT_NEAR(start->velocity.x(), 1.0, 1e-9);
  EXPECT_NEAR(start->accelerometer_bias.x(), 1.0, 1e-9);
  EXPECT_NEAR(Eigen::AngleAxisd(start->pose.orientation).angle(), std::numbers::pi / 4.0, 1e-6);
  EXPECT_NEAR((start->pose.position - Eigen::Vector3d(0.0, 0.0, 1.5)).norm(), 0.0, 1e-9) << "the middle of the room";
}

TEST(Surroundings, OfADataSetThatHasNoTruthNothingIsKnown) {
  const testing::SmallDataset dataset({0ms}, {});
  Options options;
  options.dataset = dataset.folder();
  const auto made = Surroundings::make(options, 5ms);
  ASSERT_TRUE(made.ok()) << made.error().message();
  EXPECT_FALSE((*made)->truth(1s));
}

}  // namespace
}  // namespace ctn::vr::run
