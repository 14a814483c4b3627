// Random numbers that are the same with every standard library.
//
// `Noise` is a function of (seed, stream, index), so that the noise of a scan does not depend on which scans were made
// before it. `Draws` are one after the other.
//
// Thread safety: Noise is immutable, Draws is for one thread.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace ctn::program {

// The finaliser of splitmix64: neighbouring numbers become unrelated ones.
inline std::uint64_t scrambled(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

// In [0, 1).
inline double unit_of(std::uint64_t bits) { return static_cast<double>(bits >> 11U) * 0x1.0p-53; }

class Noise {
 public:
  Noise(std::uint64_t seed, std::uint64_t stream) : key_(scrambled(scrambled(seed) ^ stream)) {}

  double uniform(std::uint64_t index) const { return unit_of(scrambled(key_ ^ scrambled(index))); }
  // Normally distributed, mean 0 and standard deviation 1: by the transform of Box and Muller, of which each pair of
  // indices shares the radius.
  double normal(std::uint64_t index) const {
    const std::uint64_t pair = index & ~std::uint64_t{1};
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform(pair)));
    const double angle = 2.0 * std::numbers::pi * uniform(pair + 1);
    return radius * ((index & 1U) == 0 ? std::cos(angle) : std::sin(angle));
  }

 private:
  std::uint64_t key_;
};

class Draws {
 public:
  Draws(std::uint64_t seed, std::uint64_t stream) : noise_(seed, stream) {}

  double between(double low, double high) { return low + (high - low) * noise_.uniform(next_++); }
  int between(int low, int high) {  // both included
    return low + static_cast<int>(std::floor(noise_.uniform(next_++) * (high - low + 1)));
  }

 private:
  Noise noise_;
  std::uint64_t next_ = 0;
};

}  // namespace ctn::program
