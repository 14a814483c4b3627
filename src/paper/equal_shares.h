// What stage I takes an allocation to come to: equal shares of every shared core.
//
// Units: milliseconds. Thread safety: plain values, pure functions.
#pragma once

#include <cstddef>
#include <vector>

#include "base/numbers.h"
#include "paper/problem.h"

namespace ctn::paper {

// Figures that differ by no more than this part are equal.
constexpr double kValueRounding = 1e-11;

// Exact rates come before bounds, bounds before the objective. All of them can be had here by relaxing them.
struct EqualShares {
  double exact = kInfinity;   // the factor by which exact rates are missed
  double factor = kInfinity;  // that of bounds
  double objective = kInfinity;

  // By more than rounding.
  bool clearly_below(const EqualShares& other) const {
    for (const double EqualShares::*part : {&EqualShares::exact, &EqualShares::factor}) {
      if (this->*part < other.*part * (1.0 - kValueRounding)) return true;
      if (this->*part > other.*part * (1.0 + kValueRounding)) return false;
    }
    return objective < other.objective * (1.0 - kValueRounding);
  }
  bool same_factors(const EqualShares& other) const {
    return exact <= other.exact * (1.0 + kValueRounding) && factor <= other.factor * (1.0 + kValueRounding);
  }
};

// Of one of `rivals` on a core of that kind.
Timing shared_timing(const Problem& problem, std::size_t subchain, int kind, int rivals);
// Of one with so many cores of that kind to itself.
Timing owned_timing(const Problem& problem, std::size_t subchain, int kind, int cores);

EqualShares value_of(const Problem& problem, const std::vector<Timing>& timings);

// The timings of all subchains.
std::vector<Timing> equal_shares(const Problem& problem, const Allocation& allocation);

}  // namespace ctn::paper
