// Counts of durations, for percentiles of as many samples as there may be in bounded memory: below 512 ns exact, above
// in steps of at most 1/256 of their length. Count, sum and maximum are exact.
//
// Units: Nanos. Cost of a sample: a few instructions. Memory: 2 KB for each doubling of the length that occurs.
// Thread safety: none; one owner.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "base/statistics.h"
#include "base/time.h"

namespace ctn::sim {

class Histogram {
 public:
  // A negative one counts as 0.
  void add(Nanos duration);

  std::uint64_t count() const { return count_; }
  // In milliseconds. Percentiles by nearest rank; each is the middle of its step, but no more than the largest sample.
  Summary summary_ms() const;

 private:
  static constexpr unsigned kBits = 8;
  static constexpr std::size_t kSteps = std::size_t{1} << kBits;
  using Octave = std::array<std::uint64_t, kSteps>;

  double percentile_ms(double percent) const;

  // [0]: 0 to 255 ns; [k]: 2^(k+7) to 2^(k+8) - 1.
  std::array<std::unique_ptr<Octave>, 64 - kBits + 1> octaves_;
  std::uint64_t count_ = 0;
  std::uint64_t sum_ = 0;
  std::uint64_t max_ = 0;
};

}  // namespace ctn::sim
