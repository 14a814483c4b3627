// A set of subchains, as bits: small enough to be copied, hashed and compared by the thousand.
//
// Units: none. Thread safety: plain values.
#pragma once

#include <array>
#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace ctn::planner {

class Set {
 public:
  static constexpr std::size_t kMost = 256;  // subchains

  constexpr Set() = default;
  // That one alone.
  static constexpr Set of(std::size_t subchain) {
    Set set;
    set.words_[subchain / kBits] = std::uint64_t{1} << subchain % kBits;
    return set;
  }
  // Of the first 64, those whose bits are set.
  static constexpr Set of_bits(std::uint64_t bits) {
    Set set;
    set.words_[0] = bits;
    return set;
  }
  // The first so many.
  static constexpr Set up_to(std::size_t count) {
    Set set;
    for (std::size_t i = 0; i < count; ++i) set |= of(i);
    return set;
  }

  constexpr bool empty() const { return (words_[0] | words_[1] | words_[2] | words_[3]) == 0; }
  constexpr std::size_t size() const {
    int sum = 0;
    for (const std::uint64_t word : words_) sum += std::popcount(word);
    return static_cast<std::size_t>(sum);
  }
  // It has just one member.
  constexpr bool single() const {
    std::uint64_t any = 0;
    std::uint64_t more = 0;
    for (const std::uint64_t word : words_) {
      more |= word & (word - 1);
      more |= any != 0 ? word : 0;
      any |= word;
    }
    return any != 0 && more == 0;
  }
  // The least of them; the set is not empty.
  constexpr int first() const {
    std::size_t word = 0;
    while (words_[word] == 0) ++word;
    return static_cast<int>(word * kBits) + std::countr_zero(words_[word]);
  }
  constexpr bool within(const Set& other) const { return (*this - other).empty(); }

  constexpr Set& operator|=(const Set& other) {
    for (std::size_t w = 0; w < kWords; ++w) words_[w] |= other.words_[w];
    return *this;
  }
  // Without those of the other.
  constexpr Set& operator-=(const Set& other) {
    for (std::size_t w = 0; w < kWords; ++w) words_[w] &= ~other.words_[w];
    return *this;
  }
  friend constexpr Set operator|(Set a, const Set& b) { return a |= b; }
  friend constexpr Set operator-(Set a, const Set& b) { return a -= b; }
  friend constexpr bool operator==(const Set& a, const Set& b) {
    std::uint64_t differ = 0;
    for (std::size_t w = 0; w < kWords; ++w) differ |= a.words_[w] ^ b.words_[w];
    return differ == 0;
  }
  // As numbers of so many bits.
  friend constexpr std::strong_ordering operator<=>(const Set& a, const Set& b) {
    for (std::size_t w = kWords; w-- > 0;) {
      if (a.words_[w] != b.words_[w]) return a.words_[w] <=> b.words_[w];
    }
    return std::strong_ordering::equal;
  }

  // The members, ascending.
  class Iterator {
   public:
    constexpr Iterator(const Set& set, std::size_t word) : words_(set.words_), word_(word) { skip(); }
    constexpr int operator*() const { return static_cast<int>(word_ * kBits) + std::countr_zero(words_[word_]); }
    constexpr Iterator& operator++() {
      words_[word_] &= words_[word_] - 1;
      skip();
      return *this;
    }
    // Only of use against end().
    friend constexpr bool operator!=(const Iterator& a, const Iterator& b) { return a.word_ != b.word_; }

   private:
    constexpr void skip() {
      while (word_ < kWords && words_[word_] == 0) ++word_;
    }

    std::array<std::uint64_t, kMost / 64> words_;
    std::size_t word_;
  };
  constexpr Iterator begin() const { return {*this, 0}; }
  constexpr Iterator end() const { return {*this, kWords}; }

  constexpr std::size_t hash() const {
    std::uint64_t mixed = words_[0];
    for (std::size_t w = 1; w < kWords; ++w) mixed = mixed * 0x9e3779b97f4a7c15U + words_[w];
    mixed *= 0x9e3779b97f4a7c15U;
    return static_cast<std::size_t>(mixed ^ mixed >> 32U);
  }

 private:
  static constexpr std::size_t kBits = 64;
  static constexpr std::size_t kWords = kMost / kBits;

  std::array<std::uint64_t, kWords> words_{};
};

}  // namespace ctn::planner

template <>
struct std::hash<ctn::planner::Set> {
  std::size_t operator()(const ctn::planner::Set& set) const { return set.hash(); }
};
