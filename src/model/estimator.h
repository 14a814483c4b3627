// Estimates a node's compute time, and what it waits, from its runs: percentiles over a sliding window, that of compute
// times mode by mode (docs/planner.md; paper section 5.3). Pure: it is told of runs and never reads a clock.
//
// Of runs that take batches it says what they take without their items, as far as it is told what these add.
//
// Adding a run costs the same however long the window is, since it happens at every run of every node; sorting is left
// to profile(), which is asked for once per re-planning.
//
// Units: Nanos in, Millis out. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/time.h"
#include "model/cost.h"

namespace ctn::model {

class Estimator {
 public:
  // window >= 1 runs; percentile in (0, 100]; `modes` as the node declares them (empty: one mode, without a name).
  Estimator(int window, double percentile, std::vector<std::string> modes);

  // A run took so long (no less than 0) in mode `mode`, an index into the declared modes; an unknown mode counts as the
  // first. `items`: of its batch.
  void add(RunTime run, std::size_t mode, std::size_t items = 0);
  // What each item adds to a run's CPU time (>= 0): all that is told from now on is of runs without any.
  void set_per_item(Millis per_item) { per_item_ = per_item; }

  // The percentile of a mode's runs before and since something changed.
  struct Shift {
    Millis before{0};
    Millis after{0};
  };
  // The mode's runs have changed: all but the newest `runs` (>= 1) of those in the window are forgotten. None: nothing
  // is left of before.
  std::optional<Shift> forget_before(std::size_t mode, std::size_t runs);
  // All runs, or those of one mode, would have cost `factor` (> 0) times as much; waits stay.
  void rescale(double factor);
  void rescale(double factor, std::size_t mode);
  // What was seen so far may not hold any more: it is used only until the mode has run five more times.
  void invalidate();

  // How many runs it has seen in all, since the start.
  std::size_t count() const { return count_; }

  // Percentile (nearest rank) of each mode's runs, weighted with the mode's frequency. The window holds `window` runs
  // of each mode, so that a rare mode keeps a percentile of its own; frequencies are those of the last `window` x 10
  // runs. One entry a declared mode, in their order; a mode that has not occurred has probability 0 and cost 0.
  // Precondition: count() > 0.
  CostProfile profile() const { return profile(percentile_); }
  // The same with another percentile in (0, 100]: 50 is what a run typically costs.
  CostProfile profile(double percentile) const;
  // The same percentile of what runs wait, whatever their mode: of a window of them, in which each
  // mode is as frequent as it was of late. 0 where none is known.
  Millis wait(double percentile) const;
  // Runs that are distributed as recent ones are: of each mode so many as it is frequent, spread evenly
  // over its last `window` x 4 runs, since what is rare (a spike, a long search) is in a window or not by luck. A few
  // hundred; none where there was no run.
  std::vector<RunTime> sample() const;

 private:
  // The last `capacity` values.
  template <class T>
  struct Ring {
    std::vector<T> values;
    std::size_t oldest = 0;  // what the next value replaces, once full; 0 until then
  };

  struct Seen {
    RunTime run;
    std::size_t items = 0;
  };

  // In order of time; all, if there are no more.
  std::vector<Seen> newest(std::size_t mode, std::size_t max_count) const;
  std::vector<RunTime> newest_runs(std::size_t mode, std::size_t max_count) const;
  RunTime without_items(const Seen& seen) const;

  std::size_t window_;
  double percentile_;
  std::vector<std::string> names_;
  Millis per_item_{0};
  std::vector<Ring<Seen>> runs_;          // by mode
  std::vector<std::size_t> invalidated_;  // by mode: so many runs until all before them are forgotten; 0: all count
  Ring<std::size_t> recent_modes_;
  std::vector<std::size_t> recent_count_;  // by mode: how often it is in recent_modes_
  std::size_t count_ = 0;
};

}  // namespace ctn::model
