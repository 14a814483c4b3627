// The app's objective with what was measured in place of what was planned: over a whole run, and in each stretch of it.
//
// A response time counts as the mean of its chain's responses; a node's period as the inverse of its rate. Stretches
// are told apart by snapshots at their ends, which count from the end of the bootstrap: one that began before that has
// no value, and neither has one in which some chain had no response.
//
// Units: milliseconds, weights as in the app file. Thread safety: one thread.
#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "catan/snapshot.h"

namespace ctn::navigation::run {

inline constexpr std::chrono::nanoseconds kObjectiveBucket = std::chrono::seconds(10);

// Nothing where there is no objective, or a term was not measured.
std::optional<double> objective_of(const Snapshot& snapshot);

class ObjectiveByTime {
 public:
  // Whether a stretch has ended, so that a snapshot is to be added.
  bool due(std::chrono::nanoseconds now) const { return now >= end_; }
  void add(std::chrono::nanoseconds now, Snapshot snapshot);

  // Of each stretch that has ended.
  const ByTime& values() const { return values_; }

 private:
  std::chrono::nanoseconds end_ = kObjectiveBucket;  // of the stretch that lasts
  std::chrono::nanoseconds last_at_{};
  Snapshot last_;
  ByTime values_;
};

}  // namespace ctn::navigation::run
