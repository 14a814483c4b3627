#include "base/statistics.h"

#include <gtest/gtest.h>

#include <numeric>

namespace ctn {
namespace {

TEST(Percentile, IsBySmallestSampleThatCoversTheShare) {
  std::vector<double> samples(20);
  std::iota(samples.begin(), samples.end(), 1.0);
  EXPECT_EQ(percentile_of_sorted(samples, 95.0), 19.0);
  EXPECT_EQ(percentile_of_sorted(samples, 95.1), 20.0);
  EXPECT_EQ(percentile_of_sorted(samples, 5.0), 1.0);
  EXPECT_EQ(percentile_of_sorted(samples, 100.0), 20.0);
}

TEST(Percentile, OfOneSampleIsThatSample) {
  const std::vector<double> one{7.0};
  EXPECT_EQ(percentile_of_sorted(one, 0.1), 7.0);
  EXPECT_EQ(percentile_of_sorted(one, 100.0), 7.0);
}

TEST(Summary, OfNothingIsAllZero) {
  const Summary summary = summarize({});
  EXPECT_EQ(summary.count, 0U);
  EXPECT_EQ(summary.max, 0.0);
}

TEST(Summary, QuicklyIsTheSame) {
  std::vector<double> samples;
  for (int number = 0; number < 2000; ++number) {
    const Summary slowly = summarize(samples);
    const Summary quickly = summarize_quickly(samples);
    EXPECT_EQ(quickly.count, slowly.count);
    EXPECT_NEAR(quickly.mean, slowly.mean, 1e-9);
    EXPECT_EQ(quickly.p50, slowly.p50) << number;
    EXPECT_EQ(quickly.p95, slowly.p95) << number;
    EXPECT_EQ(quickly.p99, slowly.p99) << number;
    EXPECT_EQ(quickly.max, slowly.max) << number;
    samples.push_back(number * 7919 % 1013);
  }
}

TEST(Summary, DoesNotDependOnTheOrder) {
  const Summary summary = summarize({3.0, 1.0, 2.0, 10.0});
  EXPECT_EQ(summary.count, 4U);
  EXPECT_DOUBLE_EQ(summary.mean, 4.0);
  EXPECT_EQ(summary.p50, 2.0);
  EXPECT_EQ(summary.max, 10.0);
}

}  // namespace
}  // namespace ctn
