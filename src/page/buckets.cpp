#include "page/buckets.h"

#include <algorithm>
#include <cmath>

#include "base/statistics.h"

namespace ctn::page {
namespace {

// Sums up, by bucket, values that are spread evenly over intervals; adding one takes constant time.
class Spreader {
 public:
  Spreader(Micros duration, std::size_t buckets)
      : duration_(duration),
        step_(static_cast<double>(duration) / static_cast<double>(buckets)),
        alone_(buckets),
        slope_(buckets + 1) {}

  void add(Micros begin, Micros end, double amount) {
    const std::size_t first = bucket_of(begin, duration_, alone_.size());
    const std::size_t last = bucket_of(end, duration_, alone_.size());
    if (first == last) {
      alone_[first] += amount;
      return;
    }
    const double rate = amount / static_cast<double>(end - begin);
    alone_[first] += rate * (static_cast<double>(first + 1) * step_ - static_cast<double>(begin));
    alone_[last] += rate * (static_cast<double>(end) - static_cast<double>(last) * step_);
    slope_[first + 1] += rate * step_;
    slope_[last] -= rate * step_;
  }

  // Of a bucket's length.
  std::vector<double> shares() const {
    std::vector<double> shares(alone_.size());
    double level = 0.0;
    for (std::size_t i = 0; i < shares.size(); ++i) {
      level += slope_[i];
      shares[i] = (alone_[i] + level) / step_;
    }
    return shares;
  }

 private:
  Micros duration_;
  double step_;
  std::vector<double> alone_;
  std::vector<double> slope_;  // by how much each bucket differs from the one before
};

std::size_t cores_of(const PlanSpan* plan, std::size_t lane) {
  if (plan == nullptr) return 1;
  const auto cores = std::count_if(plan->placements.begin(), plan->placements.end(),
                                   [&](const Placement& placement) { return placement.lane == lane; });
  return std::max<std::size_t>(static_cast<std::size_t>(cores), 1);
}

}  // namespace

std::vector<std::vector<std::uint8_t>> busy_shares(const Story& story, std::size_t buckets) {
  std::vector<Spreader> spreaders(story.lanes.size(), Spreader(story.duration, buckets));
  for (const RunSpan& run : story.runs) {
    spreaders[story.lane_of[run.node]].add(run.begin, run.end, 1e3 * static_cast<double>(run.cpu_ms));
  }
  std::vector<std::vector<std::uint8_t>> result(story.lanes.size(), std::vector<std::uint8_t>(buckets));
  for (std::size_t lane = 0; lane < result.size(); ++lane) {
    const std::vector<double> shares = spreaders[lane].shares();
    std::size_t cores = 1;
    const PlanSpan* plan = nullptr;
    for (std::size_t i = 0; i < buckets; ++i) {
      const auto middle = static_cast<Micros>((static_cast<double>(i) + 0.5) * static_cast<double>(story.duration) /
                                              static_cast<double>(buckets));
      if (const PlanSpan* const now = plan_at(story, middle); now != plan) {
        plan = now;
        cores = cores_of(plan, lane);
      }
      const double share = std::clamp(shares[i] / static_cast<double>(cores), 0.0, 1.0);
      result[lane][i] = static_cast<std::uint8_t>(std::lround(255.0 * share));
    }
  }
  return result;
}

std::vector<Band> bands(std::span<const Sample> samples, Micros duration, std::size_t buckets) {
  std::vector<Band> result;
  std::vector<double> values;
  const auto finish = [&](std::size_t bucket) {
    if (values.empty()) return;
    std::sort(values.begin(), values.end());
    double sum = 0.0;
    for (const double value : values) sum += value;
    result.push_back({bucket, values.size(), values.front(), sum / static_cast<double>(values.size()),
                      percentile_of_sorted(values, 95.0), values.back()});
    values.clear();
  };
  std::size_t bucket = 0;
  for (const Sample& sample : samples) {
    const std::size_t now = bucket_of(sample.at, duration, buckets);
    if (now != bucket) finish(bucket);
    bucket = now;
    values.push_back(sample.value);
  }
  finish(bucket);
  return result;
}

}  // namespace ctn::page
