// Estimates how many of a node's runs come to one output, where it emits less often than it runs. Pure: it is told of
// runs and never reads a clock.
//
// How: what is known is the runs from one output to the next (gaps). They are watched as compute times are
// (change_detector.h): a lasting change is told from noise, and what was before it is forgotten. What is estimated is
// the mean of the last kWindow of them. What is told stays as it is while chance explains the difference; it follows
//   - as twice as many gaps are known as when it was told last,
//   - at once when there was a lasting change,
//   - when the mean has moved by more than four of its standard errors,
// each if it has moved by more than a tenth. A node that gives no output any more keeps what was told of it.
//
// Cost: a node that emits on every run pays two comparisons and two additions a run, and no memory. Thread safety:
// none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/change_detector.h"

namespace ctn::model {

class OutputEstimator {
 public:
  static constexpr std::size_t kWindow = 200;
  // Fewer gaps tell nothing.
  static constexpr std::size_t kMinGaps = 5;

  // A run has ended that could have given an output.
  void add(bool emitted);

  // 1: each run gives one, as far as is known.
  double runs_per_output() const { return told_; }

 private:
  void add_gap(std::uint64_t runs);
  void tell();

  bool started_ = false;      // an output was given
  std::uint64_t since_ = 0;   // runs since the last one
  std::size_t even_ = 0;      // gaps of one run before any other, at most kWindow
  std::vector<double> gaps_;  // the newest; empty: all were of one run
  std::size_t oldest_ = 0;    // what the next gap replaces, once full
  ChangeDetector detector_;   // of gaps, as milliseconds
  double told_ = 1.0;
  std::size_t told_from_ = 0;  // gaps
};

}  // namespace ctn::model
