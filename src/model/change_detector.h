// Tells that the compute time of a node has changed permanently, from its runs one by one: soon, but not for noise,
// single spikes or slow growth. One detector a node, mode and kind of core.
//
// How: a two-sided cumulative sum of sequential ranks (Page, "Continuous inspection schemes", Biometrika 41, 1954;
// McDonald, "A CUSUM procedure based on sequential ranks", Naval Research Logistics 37, 1990). Each run is compared
// with the up to 50 before it: its score is half of (the part of them that it exceeds - the part that exceeds it),
// between -1/2 and 1/2 and on average 0 while nothing changes. The sum of scores less an allowance, never below 0,
// raises the alarm at a limit. The newest runs, since the sum was last 0, are those after the change.
//   - Nothing is assumed of the distribution: ranks are alike for all of them, so false alarms are, too. A run counts
//     for no more than 1/2, however long it was, so spikes do not add up.
//   - Only what differs by more than a tenth and by 20 us counts as more or less: smaller changes are no reason to plan
//     again (policy/replan.h), and compute times that grow by less within 50 runs raise no alarm.
//   - Each alarm doubles the limit, up to four times what it was; within some hundred runs without another it is back.
//     So a node whose compute times wander, each like the last, raises few alarms, for which no distribution can
//     answer.
//   - The mean of the scores after a change is P(new > old) - 1/2 at first: a change that leaves it below the allowance
//     is left to the sliding window of the estimator, as is one that moves only the tail.
//
// What that gives, as `change_detection_bench` measures it: docs/decisions/0010-change-detection.md.
//
// Units: Nanos. Cost: two binary searches and two moves within 50 numbers a run, no allocation after the first 50.
// Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/time.h"

namespace ctn::model {

class ChangeDetector {
 public:
  // Runs that a run is compared with.
  static constexpr std::size_t kReference = 50;
  // Fewer tell nothing.
  static constexpr std::size_t kMinReference = 10;

  // A run used `cpu` (>= 0). Where the compute time has changed permanently: how many of the newest runs, this one
  // included, came after the change. It then starts again with these.
  std::optional<std::size_t> add(Nanos cpu);

  // All that it has seen so far would have taken `factor` (> 0) times as long.
  void rescale(double factor);

 private:
  static constexpr double kThreshold = 3.0;

  // One side of the sum.
  struct Sum {
    double value = 0.0;
    std::size_t runs = 0;  // since it was last 0

    void add(double score);
  };

  double score(Nanos cpu) const;
  void trust_all_but(std::size_t newest);
  void begin_with_newest(std::size_t runs);
  void exchange(Nanos::rep before, Nanos::rep after);

  std::vector<Nanos::rep> reference_;
  std::vector<Nanos::rep> ranked_;    // the same in ascending order
  std::size_t oldest_ = 0;            // what the next run replaces, once full
  std::vector<Nanos::rep> suspects_;  // the newest runs, which are not in the reference yet; oldest first
  Sum up_;
  Sum down_;
  double threshold_ = kThreshold;
};

}  // namespace ctn::model
