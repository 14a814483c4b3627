#include "run/measures.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace ctn::navigation::run {
namespace {

double in_ms(std::chrono::nanoseconds time) { return std::chrono::duration<double, std::milli>(time).count(); }

// How many stretches of time have begun by `end`.
std::size_t stretches_by(std::chrono::nanoseconds width, std::chrono::nanoseconds end) {
  return static_cast<std::size_t>((end + width - std::chrono::nanoseconds(1)) / width);
}

}  // namespace

std::vector<double> ages_in_ms(const std::vector<AgeSample>& samples) {
  std::vector<double> ages(samples.size());
  std::transform(samples.begin(), samples.end(), ages.begin(),
                 [](const AgeSample& sample) { return in_ms(sample.age); });
  return ages;
}

ByTime p95_by_time(const std::vector<AgeSample>& samples, std::chrono::nanoseconds width,
                   std::chrono::nanoseconds end) {
  std::vector<std::vector<double>> ages(stretches_by(width, end));
  for (const AgeSample& sample : samples) {
    const auto bucket = static_cast<std::size_t>(sample.at / width);
    if (bucket < ages.size()) ages[bucket].push_back(in_ms(sample.age));
  }
  ByTime result;
  result.reserve(ages.size());
  for (std::vector<double>& bucket : ages) result.push_back(percentile_of(std::move(bucket), 95.0));
  return result;
}

ByTime period_by_time(const std::vector<std::chrono::nanoseconds>& instants, std::chrono::nanoseconds width,
                      std::chrono::nanoseconds end) {
  std::vector<std::vector<double>> gaps(stretches_by(width, end));
  for (std::size_t index = 1; index < instants.size(); ++index) {
    const auto bucket = static_cast<std::size_t>(instants[index] / width);
    if (bucket < gaps.size()) gaps[bucket].push_back(in_ms(instants[index] - instants[index - 1]));
  }
  ByTime result;
  result.reserve(gaps.size());
  for (const std::vector<double>& bucket : gaps) result.push_back(mean_of(bucket));
  if (instants.empty() || result.empty() || result.back()) return result;
  const std::chrono::nanoseconds open = end - instants.back();
  const std::chrono::nanoseconds before =
      instants.size() > 1 ? instants.back() - instants[instants.size() - 2] : std::chrono::nanoseconds(width);
  if (open > before) result.back() = in_ms(open);
  return result;
}

double barn_score(bool success, double optimal, double actual) {
  return success ? optimal / std::clamp(actual, 2.0 * optimal, 8.0 * optimal) : 0.0;
}

}  // namespace ctn::navigation::run
