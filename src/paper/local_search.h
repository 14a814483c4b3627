// Stage I by local search: a good allocation under equal shares, soon. Subchains are moved and swapped, and cores lent
// to those that have one to themselves, as long as that is better.
//
// Units: milliseconds. Thread safety: pure functions. Deterministic.
#pragma once

#include <cstddef>

#include "paper/problem.h"

namespace ctn::paper {

// `steps`: how many allocations it may look at, each of which takes a look at all subchains.
Allocation search_locally(const Problem& problem, std::size_t steps);

}  // namespace ctn::paper
