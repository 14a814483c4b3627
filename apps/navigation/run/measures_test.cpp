#include "run/measures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ctn::navigation::run {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;

TEST(Measures, OfNothingAreNothing) { EXPECT_TRUE(p95_by_time({}, 5s, 0s).empty()); }

TEST(Measures, StalenessIsPutIntoBucketsByWhenItWasUsed) {
  const std::vector<AgeSample> samples = {{0s, 10ms}, {4999ms, 30ms}, {5s, 70ms}, {15s, 1ms}, {17s, 2ms}};
  EXPECT_THAT(p95_by_time(samples, 5s, 16s), ElementsAre(30.0, 70.0, std::nullopt, 2.0));
  EXPECT_THAT(p95_by_time(samples, 5s, 15s), ElementsAre(30.0, 70.0, std::nullopt));
  EXPECT_THAT(ages_in_ms(samples), ElementsAre(10.0, 30.0, 70.0, 1.0, 2.0));
}

TEST(Measures, TheBarnScoreIsBoundedOnBothSides) {
  EXPECT_EQ(barn_score(false, 10.0, 20.0), 0.0);
  EXPECT_EQ(barn_score(true, 10.0, 12.0), 0.5) << "no better than twice the optimum";
  EXPECT_EQ(barn_score(true, 10.0, 20.0), 0.5);
  EXPECT_EQ(barn_score(true, 10.0, 40.0), 0.25);
  EXPECT_EQ(barn_score(true, 10.0, 80.0), 0.125);
  EXPECT_EQ(barn_score(true, 10.0, 800.0), 0.125);
}

TEST(PeriodByTime, IsTheMeanTimeBetweenOutputs) {
  EXPECT_THAT(period_by_time({1s, 3s, 4s, 11s, 35s}, 10s, 40s), ElementsAre(1500.0, 7000.0, std::nullopt, 24000.0));
  EXPECT_THAT(period_by_time({1s, 3s, 12s}, 10s, 10s), ElementsAre(2000.0)) << "what comes after the end is left out";
  EXPECT_THAT(period_by_time({5s}, 10s, 11s), ElementsAre(std::nullopt, std::nullopt));
}

// The period of a detector that had stopped was that of the time before.
TEST(PeriodByTime, CountsTheTimeThatIsOpenAtTheEnd) {
  EXPECT_THAT(period_by_time({1s, 3s}, 10s, 40s), ElementsAre(2000.0, std::nullopt, std::nullopt, 37000.0));
  EXPECT_THAT(period_by_time({5s}, 10s, 30s), ElementsAre(std::nullopt, std::nullopt, 25000.0));
  EXPECT_THAT(period_by_time({3s, 9s}, 10s, 11s), ElementsAre(6000.0, std::nullopt)) << "another may be about to come";
  EXPECT_THAT(period_by_time({}, 10s, 20s), ElementsAre(std::nullopt, std::nullopt));
}

}  // namespace
}  // namespace ctn::navigation::run
