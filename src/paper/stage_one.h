// Stage I (section 5.1 of the paper): which subchain runs on which cores, as though all that share a core took equal
// shares of it, p_i = |M| c(S_i) / (1 - slack). What owns its cores has the period of equation (1).
//
// The paper solves a mixed-integer linear program over the matrix a_ij. With equal shares only *how many* share a core
// matters, not which ones, so here each subchain chooses a class: k cores of its own, or one core among m. Branch and
// bound over these choices; what bounds a partial choice is table 1 with the rest at their shortest, and a Lagrangian
// bound, in which each core has a price. It is exact as long as it is not cut short (`steps`); what it begins with, and
// ends with where it is cut short, is what local search finds (local_search.h).
//
// One difference from the paper, which takes all nodes to gain from any number of cores here: a node's compute time on
// several cores is what is known of it, in stage I as in stage II.
//
// Units: milliseconds. Thread safety: pure functions. Deterministic.
#pragma once

#include <cstddef>

#include "paper/problem.h"

namespace ctn::paper {

struct StageOne {
  Allocation allocation;
  double factor = 1.0;     // by which bounds have to be relaxed, with equal shares; the least there is, once exact
                           // rates are missed by as little as can be
  double objective = 0.0;  // with equal shares; the least under that factor
  double gap = 0.0;        // how much less it could be at most, as a fraction; 0: it is proven
};

StageOne allocate_cores(const Problem& problem, std::size_t steps);

}  // namespace ctn::paper
