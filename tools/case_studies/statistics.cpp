#include "statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ctn::case_studies {
namespace {

// More than rounding loses, so that outcomes that are equally likely are taken for such.
constexpr double kRounding = 1e-9;

double log_choose(std::size_t n, std::size_t k) {
  const auto log_factorial = [](std::size_t value) { return std::lgamma(static_cast<double>(value) + 1.0); };
  return log_factorial(n) - log_factorial(k) - log_factorial(n - k);
}

// Twice the rank of each value, from 2 on, in the order of the values; equal ones share the mean of their ranks. Twice,
// so that they are whole numbers.
std::vector<std::size_t> doubled_ranks(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, {}, [&](std::size_t index) { return values[index]; });
  std::vector<std::size_t> ranks(values.size());
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    for (std::size_t i = begin; i < end; ++i) ranks[order[i]] = begin + 1 + end;  // (begin + 1) to end
    begin = end;
  }
  return ranks;
}

// `ways[sum]`: in how many ways it comes about. The share of them at least as far from the mean as `observed`.
double as_far_from_the_mean(const std::vector<double>& ways, std::size_t observed, double mean) {
  const double distance = std::abs(static_cast<double>(observed) - mean);
  double all = 0.0;
  double far = 0.0;
  for (std::size_t sum = 0; sum < ways.size(); ++sum) {
    all += ways[sum];
    if (std::abs(static_cast<double>(sum) - mean) * (1.0 + kRounding) >= distance) far += ways[sum];
  }
  return std::min(1.0, far / all);
}

// Of differences by their sizes, but for those of 0.
struct SignedRanks {
  std::vector<std::size_t> ranks;  // doubled
  std::size_t total = 0;
  std::size_t positive = 0;  // the sum of those of positive differences
};

SignedRanks signed_ranks_of(std::span<const double> differences) {
  std::vector<double> sizes;
  std::vector<bool> is_positive;
  for (const double difference : differences) {
    if (difference == 0.0) continue;
    sizes.push_back(std::abs(difference));
    is_positive.push_back(difference > 0.0);
  }
  SignedRanks result{.ranks = doubled_ranks(sizes)};
  for (std::size_t i = 0; i < result.ranks.size(); ++i) {
    result.total += result.ranks[i];
    if (is_positive[i]) result.positive += result.ranks[i];
  }
  return result;
}

}  // namespace

double fisher_exact(Share a, Share b) {
  if (a.total == 0 || b.total == 0) return 1.0;
  const std::size_t counted = a.count + b.count;
  const auto log_probability = [&](std::size_t count) {
    return log_choose(a.total, count) + log_choose(b.total, counted - count) - log_choose(a.total + b.total, counted);
  };
  const double observed = log_probability(a.count);
  double sum = 0.0;
  for (std::size_t count = counted > b.total ? counted - b.total : 0; count <= std::min(counted, a.total); ++count) {
    const double probability = log_probability(count);
    if (probability <= observed + kRounding) sum += std::exp(probability);
  }
  return std::min(1.0, sum);
}

double smallest_fisher_exact(std::size_t runs, std::size_t others) {
  return fisher_exact({.count = 0, .total = runs}, {.count = others, .total = others});
}

double mann_whitney(std::span<const double> a, std::span<const double> b) {
  if (a.empty() || b.empty()) return 1.0;
  std::vector<double> values(a.begin(), a.end());
  values.insert(values.end(), b.begin(), b.end());
  const std::vector<std::size_t> ranks = doubled_ranks(values);
  const std::size_t total = std::accumulate(ranks.begin(), ranks.end(), std::size_t{0});
  // ways[chosen][sum]: how many ways there are to choose so many of the ranks looked at, with this sum.
  std::vector<std::vector<double>> ways(a.size() + 1, std::vector<double>(total + 1, 0.0));
  ways[0][0] = 1.0;
  std::size_t reached = 0;
  for (const std::size_t rank : ranks) {
    reached += rank;
    for (std::size_t chosen = a.size(); chosen > 0; --chosen) {
      for (std::size_t sum = rank; sum <= reached; ++sum) ways[chosen][sum] += ways[chosen - 1][sum - rank];
    }
  }
  const auto of_a = ranks.begin() + static_cast<std::ptrdiff_t>(a.size());
  const std::size_t observed = std::accumulate(ranks.begin(), of_a, std::size_t{0});
  const double mean = static_cast<double>(total) * static_cast<double>(a.size()) / static_cast<double>(values.size());
  return as_far_from_the_mean(ways[a.size()], observed, mean);
}

double signed_rank(std::span<const double> differences) {
  const SignedRanks signed_ranks = signed_ranks_of(differences);
  if (signed_ranks.ranks.empty()) return 1.0;
  std::vector<double> ways(signed_ranks.total + 1, 0.0);
  ways[0] = 1.0;
  for (const std::size_t rank : signed_ranks.ranks) {
    for (std::size_t sum = signed_ranks.total; sum >= rank; --sum) ways[sum] += ways[sum - rank];
  }
  return as_far_from_the_mean(ways, signed_ranks.positive, static_cast<double>(signed_ranks.total) / 2.0);
}

int sign_of_signed_ranks(std::span<const double> differences) {
  const SignedRanks signed_ranks = signed_ranks_of(differences);
  const std::size_t negative = signed_ranks.total - signed_ranks.positive;
  return signed_ranks.positive > negative ? 1 : signed_ranks.positive < negative ? -1 : 0;
}

std::vector<double> holm(const std::vector<double>& probabilities) {
  std::vector<std::size_t> order(probabilities.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, {}, [&](std::size_t index) { return probabilities[index]; });
  std::vector<double> adjusted(probabilities.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    largest = std::max(largest, static_cast<double>(order.size() - i) * probabilities[order[i]]);
    adjusted[order[i]] = std::min(1.0, largest);
  }
  return adjusted;
}

Interval wilson(Share share) {
  if (share.total == 0) return {};
  constexpr double kZ = 1.959963984540054;  // of the normal distribution, for 95 %
  const auto n = static_cast<double>(share.total);
  const double p = static_cast<double>(share.count) / n;
  const double middle = p + kZ * kZ / (2.0 * n);
  const double half = kZ * std::sqrt(p * (1.0 - p) / n + kZ * kZ / (4.0 * n * n));
  const double scale = 1.0 + kZ * kZ / n;
  return {std::max(0.0, (middle - half) / scale), std::min(1.0, (middle + half) / scale)};
}

}  // namespace ctn::case_studies
