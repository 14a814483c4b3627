// Stage II (section 5.2 of the paper): given which subchains run on which cores, the frame of each shared core and what
// fraction f_i of a run each of its members has in one:
//
//   frame T = (sum_i f_i c(S_i) + idle) / (1 - slack),   p_i = T / f_i,   1/f_i whole, but for queue nodes
//
// In the periods a core asks for sum_i c(S_i) / p_i <= 1 - slack, table 1 gives the terms of the objective and the
// bounds, and all of that is a geometric program (geometric_program.h) but for the whole numbers 1/f_i. How these are
// found:
//   1. the program is solved without them; its dual variables are prices under which the objective is at least a
//      weighted sum of periods (`Prices`);
//   2. under prices, what is left to the members without a whole number yet is known in closed form, by the inequality
//      of Cauchy and Schwarz: depth-first search over whole numbers, bounded by that;
//   3. once all are whole, each frame is as short as its core and the rate caps allow; where queue nodes leave a
//   choice,
//      the geometric program makes it.
// Exact as long as the search is not cut short (`steps`).
//
// Bounds are soft: without bounds first; where these do not all hold, the least factor by which they must be relaxed,
// and then the least objective under bounds so relaxed.
//
// Two things are not the paper's: a slice is at least `min_slice`, and no frame is longer than 100 times one run of all
// its members, unless a rate cap asks for it (weights of 0 would let it grow for ever).
//
// Units: milliseconds. Thread safety: pure functions. Deterministic.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "paper/problem.h"

namespace ctn::paper {

struct StageTwo {
  std::vector<Timing> timings;  // by subchain
  std::vector<double> frames;   // by shared core
  double gap = 0.0;             // how much less the objective could be at most, as a fraction; 0: it is proven
};

// None where no fractions keep the exact rates, or the search was cut short before it came to any.
std::optional<StageTwo> divide_cores(const Problem& problem, const Allocation& allocation, std::size_t steps);

}  // namespace ctn::paper
