// A number that looks like chance and is the same everywhere: the finaliser of splitmix64 (Steele, Lea and Flood,
// 2014). For draws that depend on what they are for alone, and carry no state along.
#pragma once

#include <cstdint>

#include "base/time.h"

namespace ctn {

// To be added to what is mixed next, so that small numbers come out apart.
constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15;

constexpr std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EB;
  return x ^ (x >> 31U);
}

// One number of several, whose order counts.
template <class... More>
constexpr std::uint64_t mixed_of(std::uint64_t first, More... more) {
  std::uint64_t x = mixed(first + kGolden);
  ((x = mixed(x ^ (static_cast<std::uint64_t>(more) + kGolden))), ...);
  return x;
}

// Evenly spread from 0 to 1, which it never is, by 64 bits of chance.
constexpr double fraction_of(std::uint64_t chance) { return static_cast<double>(chance >> 11U) * 0x1.0p-53; }

// Evenly spread from 0 to `limit` (> 0), by the so-and-so-many-th of a thing, below 2^48, and the thing, below 2^16.
constexpr Nanos chance_below(Nanos limit, std::uint64_t number, std::uint64_t of) {
  return Nanos{static_cast<Nanos::rep>(mixed_of(number << 16U ^ of) % static_cast<std::uint64_t>(limit.count()))};
}

}  // namespace ctn
