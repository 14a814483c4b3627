#include "program/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ctn::program {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Optional;

TEST(Figures, OfNothingAreNothing) {
  EXPECT_EQ(mean_of({}), std::nullopt);
  EXPECT_EQ(percentile_of({}, 95.0), std::nullopt);
}

TEST(Figures, PercentilesAreSamples) {
  std::vector<double> values;
  for (int i = 100; i >= 1; --i) values.push_back(i);
  EXPECT_THAT(percentile_of(values, 95.0), Optional(95.0));
  EXPECT_THAT(percentile_of(values, 50.0), Optional(50.0));
  EXPECT_THAT(percentile_of(values, 100.0), Optional(100.0));
  EXPECT_THAT(percentile_of({7.0}, 1.0), Optional(7.0));
  EXPECT_THAT(percentile_of({3.0, 1.0, 2.0}, 50.0), Optional(2.0));
  EXPECT_THAT(mean_of({1.0, 2.0, 6.0}), Optional(3.0));
}

TEST(Figures, SpreadsAreOfTheRunsThatHaveThem) {
  const std::vector<FigureSpread> spreads =
      spreads_of({{{"a", 1.0}, {"b", std::nullopt}}, {{"a", 5.0}, {"c", 2.0}}, {{"a", 3.0}}});
  ASSERT_EQ(spreads.size(), 3U);
  EXPECT_EQ(spreads[0].figure, "a");
  EXPECT_EQ(spreads[0].spread.count, 3U);
  EXPECT_EQ(spreads[0].spread.mean, 3.0);
  EXPECT_EQ(spreads[0].spread.deviation, 2.0) << "((-2)^2 + 2^2 + 0) / 2 is its square";
  EXPECT_EQ(spreads[0].spread.median, 3.0);
  EXPECT_EQ(spreads[1].spread.count, 0U);
  EXPECT_EQ(spreads[2].spread.deviation, 0.0) << "of one run there is none";
}

TEST(Figures, QuartilesAreValuesThatOccurred) {
  const Spread spread = spread_of({4.0, 1.0, 3.0, 2.0});
  EXPECT_EQ(spread.count, 4U);
  EXPECT_EQ(spread.mean, 2.5);
  EXPECT_EQ(spread.min, 1.0);
  EXPECT_EQ(spread.lower_quartile, 1.0);
  EXPECT_EQ(spread.median, 2.0);
  EXPECT_EQ(spread.upper_quartile, 3.0);
  EXPECT_EQ(spread.max, 4.0);
}

TEST(MediansByTime, AreOfTheRunsThatLastedSoLong) {
  const std::vector<ByTime> runs{{10.0, 20.0, 30.0}, {30.0, std::nullopt}, {20.0, 40.0}};
  EXPECT_THAT(medians_by_time(runs), ElementsAre(Optional(20.0), Optional(20.0), Optional(30.0)));
  EXPECT_THAT(medians_by_time({{std::nullopt, 1.0}}), ElementsAre(std::nullopt, Optional(1.0)));
  EXPECT_THAT(medians_by_time({{}, {}}), IsEmpty());
}

TEST(MediansByTime, EndBeforeTooFewRunsAreLeft) {
  const std::vector<ByTime> runs{{1.0, 5.0, std::nullopt, 7.0}, {2.0, 6.0, std::nullopt}, {9.0}};
  EXPECT_THAT(medians_by_time(runs, 2), ElementsAre(Optional(2.0), Optional(5.0), std::nullopt));
  EXPECT_THAT(medians_by_time(runs, 4), IsEmpty());
}

}  // namespace
}  // namespace ctn::program
