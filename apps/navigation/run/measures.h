// The formulas of what is measured, on plain numbers.
//
// Units: as each says. Thread safety: pure functions.
#pragma once

#include <chrono>
#include <vector>

#include "program/figures.h"

namespace ctn::navigation::run {

using program::ByTime;
using program::mean_of;
using program::percentile_of;

// Something of this age was used at that time.
struct AgeSample {
  std::chrono::nanoseconds at{};
  std::chrono::nanoseconds age{};
  bool operator==(const AgeSample&) const = default;
};

// In ms: for each stretch of `width` from the beginning, the 95th percentile of the ages in it; nothing where there was
// none. As many stretches as have begun by `end`.
ByTime p95_by_time(const std::vector<AgeSample>& samples, std::chrono::nanoseconds width, std::chrono::nanoseconds end);
// In ms: for each stretch of `width` from the beginning, the mean time between two consecutive instants of which the
// second is in it; nothing where none is. `instants` ascend. As many stretches as have begun by `end`. Where the last
// one has nothing, the time that has passed since the last instant counts there if that is more than passed between the
// two before it (after a single one: more than `width`): what has stopped coming has a long period.
ByTime period_by_time(const std::vector<std::chrono::nanoseconds>& instants, std::chrono::nanoseconds width,
                      std::chrono::nanoseconds end);
std::vector<double> ages_in_ms(const std::vector<AgeSample>& samples);

// The score of the BARN challenge: `optimal` / `actual`, where `actual` counts as 2 x `optimal` at least and 8 x at
// most, so 0.5 at best; 0 without success. Both in the same unit, `optimal` above 0.
double barn_score(bool success, double optimal, double actual);

}  // namespace ctn::navigation::run
