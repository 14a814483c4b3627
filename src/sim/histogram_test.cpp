#include "sim/histogram.h"

#include <gtest/gtest.h>

#include <vector>

namespace ctn::sim {
namespace {

TEST(Histogram, OfNothing) {
  const Histogram histogram;
  EXPECT_EQ(histogram.summary_ms().count, 0U);
}

TEST(Histogram, OneSampleIsAllPercentiles) {
  Histogram histogram;
  histogram.add(std::chrono::milliseconds{7});
  const Summary summary = histogram.summary_ms();
  EXPECT_EQ(summary.count, 1U);
  EXPECT_DOUBLE_EQ(summary.mean, 7.0);
  EXPECT_DOUBLE_EQ(summary.max, 7.0);
  EXPECT_NEAR(summary.p50, 7.0, 7.0 / 512);
}

TEST(Histogram, ShortOnesAreExact) {
  Histogram histogram;
  for (int nanos = 1; nanos <= 200; ++nanos) histogram.add(Nanos{nanos});
  EXPECT_DOUBLE_EQ(histogram.summary_ms().p50, 100e-6);
  EXPECT_DOUBLE_EQ(histogram.summary_ms().p95, 190e-6);
}

TEST(Histogram, AgreesWithASortToHalfAStep) {
  Histogram histogram;
  std::vector<double> all;
  std::uint64_t state = 7;
  for (int i = 0; i < 50'000; ++i) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    const auto nanos = static_cast<Nanos::rep>((state >> 33U) % (1U << (8 + i % 22)));
    histogram.add(Nanos{nanos});
    all.push_back(to_millis(Nanos{nanos}).count());
  }
  const Summary exact = summarize(all);
  const Summary counted = histogram.summary_ms();
  EXPECT_EQ(counted.count, exact.count);
  EXPECT_NEAR(counted.mean, exact.mean, 1e-9 * exact.mean);
  EXPECT_NEAR(counted.p50, exact.p50, exact.p50 / 511);
  EXPECT_NEAR(counted.p95, exact.p95, exact.p95 / 511);
  EXPECT_NEAR(counted.p99, exact.p99, exact.p99 / 511);
  EXPECT_DOUBLE_EQ(counted.max, exact.max);
}

}  // namespace
}  // namespace ctn::sim
