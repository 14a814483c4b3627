#include "base/statistics.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <vector>

#include "base/quick_summary.h"

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

TEST(Summary, DoesNotDependOnTheOrder) {
  const Summary summary = summarize({3.0, 1.0, 2.0, 10.0});
  EXPECT_EQ(summary.count, 4U);
  EXPECT_DOUBLE_EQ(summary.mean, 4.0);
  EXPECT_EQ(summary.p50, 2.0);
  EXPECT_EQ(summary.max, 10.0);
}

// The same percentiles, whatever the number and the order of samples, and whether some are alike.
TEST(Summary, IsTheSameQuickly) {
  std::mt19937 random(7);
  for (std::size_t count = 0; count < 300; ++count) {
    std::vector<double> samples(count);
    for (double& sample : samples) sample = static_cast<double>(random() % (count % 2 == 0 ? 10 : 100'000));
    const Summary exact = summarize(samples);
    const Summary quick = summarize_quickly(samples);
    EXPECT_EQ(quick.count, exact.count);
    EXPECT_NEAR(quick.mean, exact.mean, 1e-9 * exact.mean);
    EXPECT_EQ(quick.p50, exact.p50) << count;
    EXPECT_EQ(quick.p95, exact.p95) << count;
    EXPECT_EQ(quick.p99, exact.p99) << count;
    EXPECT_EQ(quick.max, exact.max) << count;
  }
}

}  // namespace
}  // namespace ctn
