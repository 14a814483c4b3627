// Estimates what each item of a batch adds to the CPU time of a run, where that can be told. Pure: it is told of runs
// and never reads a clock.
//
// How: least squares over the last kWindow runs, cpu = fixed part of the mode + per item x items, the slope alike in
// all modes and never below 0; then once more without the runs that are far from the line, as spikes are. Where the
// number of items hardly varies its slope means nothing: one is told only
//   - if it is more than four of its standard errors from what was told before (0 at first), and then
//   - again whenever it is known better than it was,
// so that noise does not move it, and a window of batches that are all alike does not make it forgotten.
//
// Batches change as plans do, and compute times with them. Before a slope is known, that looks like a lasting change of
// the compute time (change_detector.h); explains() tells the one from the other.
//
// Cost: the line is fitted as twice as many runs are known, and then every 50. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/time.h"

namespace ctn::model {

class BatchEstimator {
 public:
  static constexpr std::size_t kWindow = 200;
  // Fewer tell nothing.
  static constexpr std::size_t kMinRuns = 10;

  // A run took so long (>= 0) with so many items. Whether what is told has changed.
  bool add(Nanos cpu, std::size_t items, std::size_t mode);

  // What each item adds; 0: nothing, as far as is known.
  Millis per_item() const { return Millis{told_}; }
  // What a run would have taken without its items, by what is told.
  Nanos without_items(Nanos cpu, std::size_t items) const;

  // The compute time of the newest `runs` (>= 1) of that mode is not what it was before them. Whether that is because
  // their batches are not, either; then what is told has changed.
  bool explains(std::size_t mode, std::size_t runs);
  // Only the newest `runs` (>= 1) of that mode tell anything.
  void forget_before(std::size_t mode, std::size_t runs);

  // What was seen so far may not hold any more: what is told stays only until something else is known.
  void invalidate();
  // All runs would have taken `factor` (> 0) times as long.
  void rescale(double factor);

 private:
  struct Run {
    double cpu = 0.0;  // ms
    double items = 0.0;
    std::size_t mode = 0;
  };
  struct Line {
    double slope = 0.0;
    double error = 0.0;  // standard error of the slope
    double mean_cpu = 0.0;
    double mean_items = 0.0;
  };

  std::vector<Run> in_order() const;
  static std::optional<Line> fitted(const std::vector<Run>& runs);
  static std::vector<Run> without_outliers(const std::vector<Run>& runs, double slope);
  static std::optional<Line> robustly_fitted(const std::vector<Run>& runs);
  bool tell();

  std::vector<Run> runs_;      // the newest
  std::size_t oldest_ = 0;     // what the next replaces, once full
  std::size_t since_fit_ = 0;  // runs
  double told_ = 0.0;          // ms
  std::optional<double> told_error_;
};

}  // namespace ctn::model
