// How much longer or shorter than their mean the runs of a subchain are, and what a schedule loses by that: formulas
// that know means and variances alone (surrogate.h) do not see what only the long runs do.
//
//   lost_triggers()     triggers that come while a run is under way are lost, but one: a run that is no longer than
//                       they are apart loses none, one that is three times as long loses more than one
//   part_with_input()   where each run begins a pause after the one before, more comes in during a long run than
//                       during a short one, and what is more than one input is of no use
//
// Some of the runs that trials draw (trial/samples.h) are taken, sorted, and cut into kParts equal parts; each part
// stands for its mean.
//
// Units: milliseconds. Thread safety: immutable once made.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "graph/app.h"
#include "trial/samples.h"

namespace ctn::planner {

class RunSpread {
 public:
  static constexpr std::size_t kParts = 16;

  // Of these runs, in any order. Precondition: as many as kParts, or a multiple of that.
  explicit RunSpread(std::vector<double> runs);
  // Of the subchain's on a kind of core: each run takes one of the draws of each node.
  static RunSpread of(const graph::Subchain& subchain, const trial::Samples& samples, std::size_t kind);

  // By how much the runs of each part are longer than the mean, from the shortest on.
  const std::array<double, kParts>& parts() const { return parts_; }

  // Of `value(more)`, where a run costs `more` than the mean.
  template <class Value>
  double mean_of(const Value& value) const {
    double sum = 0.0;
    for (const double more : parts_) sum += value(more);
    return sum / static_cast<double>(kParts);
  }

  // How long runs take on a schedule: one that costs `more` than the mean, (mean + more) * stretch + waits.
  struct Lengths {
    double mean = 0.0;
    double stretch = 1.0;
    double waits = 0.0;
  };
  // Triggers that come this far `apart`: how many each run loses on average.
  double lost_triggers(const Lengths& lengths, double apart) const;

  // What part of the runs finds an input, > 0. `items(more)`: how many inputs come on average before the run that
  // follows one which costs `more` than the mean.
  template <class Items>
  double part_with_input(const Items& items) const {
    double with_input = kMinItems;
    for (const double more : parts_) with_input += std::min(1.0, items(more));
    return with_input / static_cast<double>(kParts);
  }
  // The same where all runs are equally far apart, whatever they cost.
  static double part_with_input(double items) { return std::clamp(items, kMinItems, 1.0); }

 private:
  static constexpr double kMinItems = 1e-6;

  std::array<double, kParts> parts_{};
};

}  // namespace ctn::planner
