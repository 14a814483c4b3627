// Stage II as a geometric program, and the prices that follow from its solution: what stage_two.h calls 1.
//
// Units: milliseconds. Thread safety: plain values, pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "paper/problem.h"

namespace ctn::paper {

// A core with several members.
struct SharedCore {
  int kind = 0;
  std::vector<std::size_t> members;  // in the order of their ids
  std::optional<std::size_t> exact;  // of these, one whose exact rate sets the frame: T = p / n
  double longest_frame = 0.0;
};

// What is to be divided: cores that are shared, beside subchains whose timing is given.
struct Division {
  const Problem& problem;
  std::vector<SharedCore> cores;
  std::vector<int> core_of;     // by subchain; -1: it has cores of its own
  std::vector<Timing> timings;  // of those; 0 for others

  double cost(std::size_t i) const { return problem.on(i, cores[static_cast<std::size_t>(core_of[i])].kind).cost; }
  double max_every(std::size_t i) const {
    return problem.on(i, cores[static_cast<std::size_t>(core_of[i])].kind).max_every;
  }
  // Its number of frames a run need not be whole.
  bool is_free(std::size_t i) const { return problem.subchains[i].queue && cost(i) > 0.0; }
  bool is_exact(std::size_t i) const { return problem.subchains[i].exact_period > 0.0; }
};

Division divide(const Problem& problem, const Allocation& allocation);

// What is to be least: the objective while all bounds hold if relaxed by `factor` (infinite: whatever they are), or
// that factor itself.
struct Goal {
  bool minimise_factor = false;
  double factor = 0.0;
};

// The goal is at least constant + sum_i price_i p_i, summed over members of shared cores. As long as a member's number
// of frames is open, part of its price goes into what limits its period p on a core with frames of T,
//
//   shortest period <= p,   T <= p <= max_every T   (of a free number only the last),
//
// so that price p >= open.period p + open.frame T + open.constant for every p within these limits.
struct Prices {
  struct Open {
    double period = 0.0;  // >= 0
    double frame = 0.0;
    double constant = 0.0;
  };
  double constant = 0.0;
  std::vector<double> of;  // by subchain, >= 0
  std::vector<Open> open;  // by subchain
};

struct Relaxed {
  std::vector<double> periods;  // by subchain; 0 for those with cores of their own
  std::vector<double> frames;   // by shared core
  Prices prices;
};

// `every`: whole numbers that are given, by subchain; empty: none are, and any number will do. None where nothing meets
// the goal's bounds, or the exact rates.
std::optional<Relaxed> relax(const Division& division, const Goal& goal, const std::vector<int>& every);

}  // namespace ctn::paper
