#include "run/exposures.h"

#include <gtest/gtest.h>

#include "run/testing/small_dataset.h"

namespace ctn::vr::run {
namespace {

using namespace std::chrono_literals;

// Guards: a signal was not looked at before all pictures were there, which may take minutes.
TEST(ReadyExposures, AreNotMadeAnyMoreWhereTheRunEnds) {
  const testing::SmallDataset dataset({0ms, 50ms, 100ms}, {});
  Options options;
  options.dataset = dataset.folder();
  const auto surroundings = Surroundings::make(options, 5ms);
  ASSERT_TRUE(surroundings.ok()) << surroundings.error().message();
  const Clock clock{0ms, 50ms};
  EXPECT_FALSE(ready_exposures(**surroundings, clock, 1s).ok()) << "its pictures cannot be opened";
  int asked = 0;
  const auto none = ready_exposures(**surroundings, clock, 1s, [&] { return ++asked > 0; });
  ASSERT_TRUE(none.ok()) << none.error().message();
  EXPECT_EQ(asked, 1);
  EXPECT_TRUE((*none)->newest(1s)->picture.empty());
}

TEST(ClockOf, GoesByTimeStampsOverWhatWasLost) {
  const auto clock = clock_of(std::vector<double>{0.002, 0.012, 0.022, 0.052});
  ASSERT_TRUE(clock);
  EXPECT_EQ(clock->period, 10ms);
  EXPECT_EQ(clock->first, 2ms);
  EXPECT_FALSE(clock_of(std::vector<double>{1.0}));
}

}  // namespace
}  // namespace ctn::vr::run
