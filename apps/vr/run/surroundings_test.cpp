#include "run/surroundings.h"

#include <gtest/gtest.h>

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
