// A set of CPUs, small and quick: two words, copied by value, where os::CpuSet is a sorted vector.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "os/cpu_set.h"

namespace ctn::sim {

// As many as two words have bits.
constexpr int kMaxCpus = 128;

class CpuMask {
 public:
  constexpr CpuMask() = default;
  explicit CpuMask(const os::CpuSet& cpus) {
    for (const int cpu : cpus.cpus()) add(cpu);
  }
  static CpuMask only(int cpu) {
    CpuMask mask;
    mask.add(cpu);
    return mask;
  }

  void add(int cpu) { words_[word(cpu)] |= bit(cpu); }
  bool has(int cpu) const { return (words_[word(cpu)] & bit(cpu)) != 0; }
  bool empty() const { return (words_[0] | words_[1]) == 0; }
  // Precondition for both: not empty.
  int lowest() const { return words_[0] != 0 ? std::countr_zero(words_[0]) : 64 + std::countr_zero(words_[1]); }
  int take_lowest() {
    const int cpu = lowest();
    words_[word(cpu)] &= ~bit(cpu);
    return cpu;
  }
  bool single() const { return std::popcount(words_[0]) + std::popcount(words_[1]) == 1; }
  friend constexpr bool operator==(const CpuMask&, const CpuMask&) = default;

 private:
  static std::size_t word(int cpu) { return static_cast<std::size_t>(cpu) / 64; }
  static std::uint64_t bit(int cpu) { return std::uint64_t{1} << (static_cast<unsigned>(cpu) % 64); }

  std::array<std::uint64_t, 2> words_{};
};

}  // namespace ctn::sim
