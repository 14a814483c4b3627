// Levels of detail: figures of many runs and samples, in equal parts (buckets) of the recorded run's time.
//
// Units: Micros; those of values are up to the caller. Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "page/story.h"

namespace ctn::page {

// The busy shares of each lane, by bucket. 255: busy all the time on all of the cores that the lane has then. A run's
// CPU time counts evenly from its begin to its end.
std::vector<std::vector<std::uint8_t>> busy_shares(const Story& story, std::size_t buckets);

struct Sample {
  Micros at = 0;
  double value = 0.0;
};

struct Band {
  std::size_t bucket = 0;
  std::size_t count = 0;
  double min = 0.0;
  double mean = 0.0;
  double p95 = 0.0;  // by nearest rank
  double max = 0.0;
  friend bool operator==(const Band&, const Band&) = default;
};

// A band for each bucket that has samples. `samples`: in order of time, all in [0, duration].
std::vector<Band> bands(std::span<const Sample> samples, Micros duration, std::size_t buckets);

// The bucket of an instant in [0, duration]; the last instant is in the last bucket. Precondition: duration > 0.
inline std::size_t bucket_of(Micros at, Micros duration, std::size_t buckets) {
  const auto bucket =
      static_cast<std::size_t>(static_cast<double>(at) / static_cast<double>(duration) * static_cast<double>(buckets));
  return bucket < buckets ? bucket : buckets - 1;
}

}  // namespace ctn::page
