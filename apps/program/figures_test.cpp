#include "program/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ctn::program {
namespace {

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
  const std::vector<Spread> spreads =
      spreads_of({{{"a", 1.0}, {"b", std::nullopt}}, {{"a", 5.0}, {"c", 2.0}}, {{"a", 3.0}}});
  ASSERT_EQ(spreads.size(), 3U);
  EXPECT_EQ(spreads[0].figure, "a");
  EXPECT_EQ(spreads[0].count, 3U);
  EXPECT_EQ(spreads[0].mean, 3.0);
  EXPECT_EQ(spreads[0].deviation, 2.0) << "((-2)^2 + 2^2 + 0) / 2 is its square";
  EXPECT_EQ(spreads[0].median, 3.0);
  EXPECT_EQ(spreads[1].count, 0U);
  EXPECT_EQ(spreads[2].deviation, 0.0) << "of one run there is none";
}

}  // namespace
}  // namespace ctn::program
