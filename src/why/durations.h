// Many durations, of which only one is to be found by its rank: in half the memory of a vector of them, as long as they
// are below four seconds.
//
// Units: Nanos. Thread safety: none; one owner.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/time.h"

namespace ctn::why {

class Durations {
 public:
  // Precondition: not negative.
  void add(Nanos duration) {
    assert(duration >= Nanos{0});
    if (duration.count() <= std::numeric_limits<std::uint32_t>::max()) {
      short_.push_back(static_cast<std::uint32_t>(duration.count()));
    } else {
      long_.push_back(duration);
    }
  }
  std::size_t size() const { return short_.size() + long_.size(); }
  // The one that so many are no longer than, itself not counted. Precondition: rank < size().
  Nanos of_rank(std::size_t rank) {
    const auto place = [](auto& of, std::size_t index) {
      const auto at = of.begin() + static_cast<std::ptrdiff_t>(index);
      std::nth_element(of.begin(), at, of.end());
      return *at;
    };
    return rank < short_.size() ? Nanos{place(short_, rank)} : place(long_, rank - short_.size());
  }

 private:
  std::vector<std::uint32_t> short_;  // in ns
  std::vector<Nanos> long_;
};

}  // namespace ctn::why
