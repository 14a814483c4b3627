// Lower bounds on what any allocation of any number of subchains costs under given prices.
//
// Units: milliseconds. Thread safety: pure but for the prices' memory.
#pragma once

#include <vector>

#include "planner/cover_program.h"
#include "planner/instance.h"
#include "planner/pieces.h"

namespace ctn::planner {

// Each subchain has a root y so that k cores of its own cost at least y^2 / k, and a group on one core at least the
// square of the sum of its roots; spreading the sum evenly is then the least. What gains nothing from a second core
// cannot be spread: it is a head, on a core of its own.
double spread_bound(const Instance& instance, Prices& prices);

// As if all cores were one that is so many times as fast, and no subchain's period shorter than its rate cap allows.
double pooled_bound(const Instance& instance, Prices& prices);

// Every subchain must be in one group: with a price on each for being covered, the cheapest groups that the cores have
// room for are a bound (Lagrangian relaxation of set partitioning). Knows of whole numbers in groups of two, and of
// larger groups what spread_bound does. The prices start from an allocation that is known, and are improved towards
// its cost; finite, so that cover.h can go on from them.
struct PairCover {
  double bound = 0.0;
  CoverPrices prices;
};
// What it takes, in steps of effort: mostly a price for every pair.
std::size_t pair_cover_effort(const Instance& instance);
PairCover cover_by_pairs(const Instance& instance, Prices& prices, const std::vector<Piece>& known, Effort& effort);

}  // namespace ctn::planner
