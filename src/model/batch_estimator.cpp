#include "model/batch_estimator.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <span>
#include <utility>

namespace ctn::model {
namespace {

constexpr double kErrorsApart = 4.0;
// Items that together come to less than this part of a run are not told of.
constexpr double kMinPart = 0.02;
// From the line, in standard deviations of a normal distribution; and where runs hardly differ, in parts of their mean.
constexpr double kOutlier = 4.0;
constexpr double kOutlierAnyway = 0.02;
constexpr double kDeviationsOfMedian = 1.4826;
// Compute times and numbers of items that differ by less are alike.
constexpr double kAlike = 0.1;

// What is far more precise than any clock is taken to be as precise as this part of a run.
constexpr double kMinDeviation = 1e-3;

// Means of the runs of each mode.
struct Means {
  double cpu = 0.0;
  double items = 0.0;
  double runs = 0.0;
};

std::map<std::size_t, Means> means_by_mode(const auto& runs) {
  std::map<std::size_t, Means> means;
  for (const auto& run : runs) {
    Means& of = means[run.mode];
    of.cpu += run.cpu;
    of.items += run.items;
    of.runs += 1.0;
  }
  for (auto& [mode, of] : means) {
    of.cpu /= of.runs;
    of.items /= of.runs;
  }
  return means;
}

}  // namespace

std::vector<BatchEstimator::Run> BatchEstimator::in_order() const {
  std::vector<Run> runs(runs_.begin() + static_cast<std::ptrdiff_t>(oldest_), runs_.end());
  runs.insert(runs.end(), runs_.begin(), runs_.begin() + static_cast<std::ptrdiff_t>(oldest_));
  return runs;
}

bool BatchEstimator::add(Nanos cpu, std::size_t items, std::size_t mode) {
  assert(cpu.count() >= 0);
  const Run run{to_millis(cpu).count(), static_cast<double>(items), mode};
  if (runs_.size() < kWindow) {
    runs_.push_back(run);
  } else {
    runs_[oldest_] = run;
    oldest_ = (oldest_ + 1) % kWindow;
  }
  ++since_fit_;
  if (since_fit_ < std::clamp(runs_.size() / 2, kMinRuns, kWindow / 4)) return false;
  since_fit_ = 0;
  return tell();
}

Nanos BatchEstimator::without_items(Nanos cpu, std::size_t items) const {
  return std::max(cpu - to_nanos(Millis{told_ * static_cast<double>(items)}), Nanos{0});
}

// None: the numbers of items are all the same in each mode, or there are too few runs.
std::optional<BatchEstimator::Line> BatchEstimator::fitted(const std::vector<Run>& runs) {
  if (runs.size() < kMinRuns) return std::nullopt;
  const auto means = means_by_mode(runs);
  double across = 0.0;
  double along = 0.0;
  Line line;
  for (const Run& run : runs) {
    const Means& mean = means.at(run.mode);
    across += (run.items - mean.items) * (run.items - mean.items);
    along += (run.items - mean.items) * (run.cpu - mean.cpu);
    line.mean_cpu += run.cpu / static_cast<double>(runs.size());
    line.mean_items += run.items / static_cast<double>(runs.size());
  }
  if (across <= 0.0) return std::nullopt;
  line.slope = along / across;
  double squares = 0.0;
  for (const Run& run : runs) {
    const Means& mean = means.at(run.mode);
    const double off = run.cpu - mean.cpu - line.slope * (run.items - mean.items);
    squares += off * off;
  }
  const double freedom = std::max(static_cast<double>(runs.size() - means.size()) - 1.0, 1.0);
  const double deviation = std::max(std::sqrt(squares / freedom), kMinDeviation * line.mean_cpu);
  line.error = deviation / std::sqrt(across);
  return line;
}

std::vector<BatchEstimator::Run> BatchEstimator::without_outliers(const std::vector<Run>& runs, double slope) {
  std::map<std::size_t, std::vector<double>> fixed;  // by mode
  double sum = 0.0;
  for (const Run& run : runs) {
    fixed[run.mode].push_back(run.cpu - slope * run.items);
    sum += run.cpu;
  }
  std::map<std::size_t, double> medians;
  const auto median_of = [](std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  for (auto& [mode, values] : fixed) medians[mode] = median_of(values);
  std::vector<double> off;
  for (const Run& run : runs) off.push_back(std::abs(run.cpu - slope * run.items - medians[run.mode]));
  const double far = std::max(kOutlier * kDeviationsOfMedian * median_of(off),
                              kOutlierAnyway * sum / static_cast<double>(runs.size()));
  std::vector<Run> near;
  for (const Run& run : runs) {
    if (std::abs(run.cpu - slope * run.items - medians[run.mode]) <= far) near.push_back(run);
  }
  return near;
}

std::optional<BatchEstimator::Line> BatchEstimator::robustly_fitted(const std::vector<Run>& runs) {
  const std::optional<Line> rough = fitted(runs);
  return rough ? fitted(without_outliers(runs, rough->slope)) : std::nullopt;
}

bool BatchEstimator::tell() {
  const std::optional<Line> line = robustly_fitted(in_order());
  if (!line) return false;
  const double slope = std::max(line->slope, 0.0);
  const bool first = told_ == 0.0;
  if (first && slope * line->mean_items < kMinPart * line->mean_cpu) return false;
  const bool moved = std::abs(slope - told_) > kErrorsApart * line->error;
  const bool known_better = !first && (!told_error_ || line->error < *told_error_);
  if (!moved && !known_better) return false;
  told_error_ = line->error;
  return std::exchange(told_, slope) != slope;
}

bool BatchEstimator::explains(std::size_t mode, std::size_t runs) {
  std::vector<Run> of_mode = in_order();
  std::erase_if(of_mode, [&](const Run& run) { return run.mode != mode; });
  if (of_mode.size() <= runs) return false;
  const std::span<const Run> all = of_mode;
  const Means old = means_by_mode(all.first(all.size() - runs)).at(mode);
  const Means now = means_by_mode(all.last(runs)).at(mode);
  if (std::abs(now.items - old.items) <= kAlike * std::max(now.items, old.items)) return false;
  const double slope = (now.cpu - old.cpu) / (now.items - old.items);
  // What is no slope: one that is known to be another, or with which runs would take less than nothing without items.
  if (slope <= 0.0 || old.cpu - slope * old.items < -kAlike * old.cpu) return false;
  if (told_error_ && std::abs(slope - told_) > kErrorsApart * *told_error_) return false;
  told_ = slope;
  told_error_.reset();
  since_fit_ = 0;
  return true;
}

void BatchEstimator::forget_before(std::size_t mode, std::size_t runs) {
  std::vector<Run> kept = in_order();
  std::size_t seen = 0;
  for (std::size_t at = kept.size(); at > 0; --at) {
    if (kept[at - 1].mode == mode && ++seen > runs) kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(at - 1));
  }
  runs_ = std::move(kept);
  oldest_ = 0;
}

void BatchEstimator::invalidate() {
  runs_.clear();
  oldest_ = 0;
  since_fit_ = 0;
  told_error_.reset();
}

void BatchEstimator::rescale(double factor) {
  assert(factor > 0.0);
  for (Run& run : runs_) run.cpu *= factor;
  told_ *= factor;
  if (told_error_) *told_error_ *= factor;
}

}  // namespace ctn::model
