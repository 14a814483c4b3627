#include "statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace ctn::case_studies {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;

constexpr double kClose = 1e-9;

// Sum over all ways to choose so many of the values: the mean distance of those chosen from the rest.
double by_trying_all(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> all = a;
  all.insert(all.end(), b.begin(), b.end());
  // Twice the sum of ranks of those chosen, ties shared, from what it is by chance.
  const auto distance = [&](const std::vector<std::size_t>& chosen) {
    double sum = 0.0;
    for (const std::size_t one : chosen) {
      for (std::size_t other = 0; other < all.size(); ++other) {
        sum += all[one] > all[other] ? 1.0 : all[one] < all[other] ? -1.0 : 0.0;
      }
    }
    return std::abs(sum);
  };
  std::vector<std::size_t> first(a.size());
  std::iota(first.begin(), first.end(), 0U);
  const double observed = distance(first);
  std::size_t ways = 0;
  std::size_t far = 0;
  for (std::size_t set = 0; set < (1U << all.size()); ++set) {
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if ((set >> i & 1U) != 0) chosen.push_back(i);
    }
    if (chosen.size() != a.size()) continue;
    ++ways;
    if (distance(chosen) >= observed - kClose) ++far;
  }
  return static_cast<double>(far) / static_cast<double>(ways);
}

double signs_by_trying_all(const std::vector<double>& differences) {
  const auto rank = [&](double size) {
    double below = 0.0;
    double same = 0.0;
    for (const double other : differences) {
      below += std::abs(other) < size ? 1.0 : 0.0;
      same += std::abs(other) == size ? 1.0 : 0.0;
    }
    return below + (same + 1.0) / 2.0;
  };
  double observed = 0.0;
  for (const double difference : differences) observed += std::copysign(rank(std::abs(difference)), difference);
  std::size_t far = 0;
  const std::size_t ways = 1U << differences.size();
  for (std::size_t set = 0; set < ways; ++set) {
    double sum = 0.0;
    for (std::size_t i = 0; i < differences.size(); ++i) {
      sum += ((set >> i & 1U) != 0 ? 1.0 : -1.0) * rank(std::abs(differences[i]));
    }
    if (std::abs(sum) >= std::abs(observed) - kClose) ++far;
  }
  return static_cast<double>(far) / static_cast<double>(ways);
}

std::vector<double> drawn(std::mt19937& random, std::size_t count, int values) {
  std::vector<double> sample(count);
  for (double& value : sample) value = static_cast<double>(static_cast<int>(random() % static_cast<unsigned>(values)));
  return sample;
}

TEST(Statistics, FisherIsThatOfTheLadyTastingTea) {
  EXPECT_NEAR(fisher_exact({3, 4}, {1, 4}), 34.0 / 70.0, kClose);
  EXPECT_NEAR(fisher_exact({4, 4}, {0, 4}), 2.0 / 70.0, kClose);
  EXPECT_NEAR(fisher_exact({0, 4}, {4, 4}), 2.0 / 70.0, kClose);
}

TEST(Statistics, FisherOfThePapersCollisions) {
  EXPECT_LT(fisher_exact({3, 40}, {21, 40}), 0.001);
  EXPECT_GT(fisher_exact({3, 40}, {9, 40}), 0.05) << "the paper's 3 beside 9 of 40 may be chance";
  EXPECT_NEAR(fisher_exact({7, 40}, {7, 40}), 1.0, kClose);
}

TEST(Statistics, NothingIsNoDifference) {
  EXPECT_EQ(fisher_exact({0, 0}, {3, 4}), 1.0);
  EXPECT_EQ(mann_whitney({}, std::vector{1.0}), 1.0);
  EXPECT_EQ(signed_rank({}), 1.0);
  EXPECT_EQ(signed_rank(std::vector{0.0, 0.0}), 1.0);
  EXPECT_EQ(mann_whitney(std::vector{2.0, 2.0}, std::vector{2.0, 2.0}), 1.0);
}

TEST(Statistics, RankSumsCountAllWays) {
  EXPECT_NEAR(mann_whitney(std::vector{1.0, 2.0, 3.0}, std::vector{4.0, 5.0, 6.0}), 2.0 / 20.0, kClose);
  EXPECT_NEAR(mann_whitney(std::vector{4.0, 5.0, 6.0}, std::vector{1.0, 2.0, 3.0}), 2.0 / 20.0, kClose);
  std::mt19937 random(1);
  for (int trial = 0; trial < 40; ++trial) {
    const std::size_t first = 1 + random() % 5;
    const std::size_t second = 1 + random() % 5;
    const std::vector<double> a = drawn(random, first, 6);  // with ties
    const std::vector<double> b = drawn(random, second, 6);
    EXPECT_NEAR(mann_whitney(a, b), by_trying_all(a, b), kClose);
  }
}

TEST(Statistics, NeverIsLaterThanAnyTime) {
  const double never = std::numeric_limits<double>::infinity();
  EXPECT_NEAR(mann_whitney(std::vector{1.0, 2.0, 3.0}, std::vector{never, never, never}), 2.0 / 20.0, kClose);
}

TEST(Statistics, RankSumsOfManyRuns) {
  std::vector<double> a(100);
  std::iota(a.begin(), a.end(), 0.0);
  std::vector<double> b = a;
  EXPECT_NEAR(mann_whitney(a, b), 1.0, 0.02);
  for (double& value : b) value += 30.0;
  EXPECT_LT(mann_whitney(a, b), 1e-6);
}

TEST(Statistics, SignedRanksCountAllSigns) {
  EXPECT_NEAR(signed_rank(std::vector{1.0, 2.0, 3.0, 4.0, 5.0}), 2.0 / 32.0, kClose);
  EXPECT_NEAR(signed_rank(std::vector{-1.0, 0.0, -2.0, -3.0}), 2.0 / 8.0, kClose);
  std::mt19937 random(2);
  for (int trial = 0; trial < 40; ++trial) {
    const std::size_t count = 1 + random() % 8;
    std::vector<double> differences = drawn(random, count, 7);
    for (double& difference : differences) difference = difference < 3.0 ? difference - 3.0 : difference - 2.0;
    EXPECT_NEAR(signed_rank(differences), signs_by_trying_all(differences), kClose);
  }
}

TEST(Statistics, HolmAsksMoreOfTheSmallest) {
  EXPECT_THAT(holm({0.04, 0.01, 0.03}),
              ElementsAre(DoubleNear(0.06, kClose), DoubleNear(0.03, kClose), DoubleNear(0.06, kClose)));
  EXPECT_THAT(holm({0.9, 0.6}), ElementsAre(1.0, 1.0));
  EXPECT_TRUE(holm({}).empty());
}

TEST(Statistics, WilsonsIntervalIsTheEquationsSolution) {
  // Where the share and the limit are apart by 1.96 standard deviations at the limit.
  for (const Share share : {Share{3, 40}, Share{20, 40}, Share{1, 7}}) {
    const double p = static_cast<double>(share.count) / static_cast<double>(share.total);
    const Interval interval = wilson(share);
    for (const double limit : {interval.low, interval.high}) {
      const double deviation = std::sqrt(limit * (1.0 - limit) / static_cast<double>(share.total));
      EXPECT_NEAR(std::abs(p - limit), 1.959963984540054 * deviation, kClose);
    }
  }
  EXPECT_EQ(wilson({0, 40}).low, 0.0);
  EXPECT_EQ(wilson({40, 40}).high, 1.0);
  EXPECT_EQ(wilson({0, 0}).high, 1.0);
}

TEST(Statistics, SignedRanksHaveADirectionOfTheirOwn) {
  std::vector<double> differences(100, -1.0);
  std::fill(differences.begin() + 90, differences.end(), 500.0);
  EXPECT_EQ(sign_of_signed_ranks(differences), -1) << "though their mean is positive";
  EXPECT_EQ(sign_of_signed_ranks(std::vector{-1.0, 0.0, 2.0}), 1);
  EXPECT_EQ(sign_of_signed_ranks(std::vector{-1.0, 1.0, 0.0}), 0);
  EXPECT_EQ(sign_of_signed_ranks({}), 0);
}

TEST(Statistics, FewRunsCannotDifferByMoreThanChance) {
  EXPECT_NEAR(smallest_fisher_exact(2, 2), 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(smallest_fisher_exact(4, 4), 1.0 / 35.0, 1e-12);
  EXPECT_EQ(smallest_fisher_exact(0, 4), 1.0);
}

}  // namespace
}  // namespace ctn::case_studies
