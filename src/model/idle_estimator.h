// Estimates what a node does when it finds nothing new in any of its inputs: which part of such runs are idle, so give
// no output, and what an idle run costs. Pure: it is told of runs and never reads a clock.
//
// How: of the last kWindow runs that found nothing new the part that was idle, told once there are kMinRuns of them and
// then whenever it has moved by more than a tenth; what lies within a twentieth of none or all is none or all. What an
// idle run costs is the mean of the last kWindow idle ones, told whenever it has moved by more than a tenth of what was
// told. So what is told moves seldom, and plans do not follow chance.
//
// Cost: a few additions a run. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <vector>

#include "base/time.h"
#include "model/cost.h"

namespace ctn::model {

class IdleEstimator {
 public:
  static constexpr std::size_t kWindow = 100;
  // Fewer tell nothing.
  static constexpr std::size_t kMinRuns = 10;

  // A run that found nothing new has ended; with that CPU time (>= 0).
  void add(bool idle, Nanos cpu);

  // Part 0 where nothing is known.
  IdleRuns idle() const { return told_; }

 private:
  // The mean of the newest kWindow values.
  class MovingMean {
   public:
    void add(double value);
    std::size_t count() const { return values_.size(); }
    double mean() const { return sum_ / static_cast<double>(values_.size()); }

   private:
    std::vector<double> values_;
    std::size_t oldest_ = 0;  // what the next replaces, once full
    double sum_ = 0.0;
  };

  MovingMean part_;
  MovingMean cost_;  // ns
  IdleRuns told_;
};

}  // namespace ctn::model
