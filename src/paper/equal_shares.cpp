// Section 5.1, case (i): the periods of those that share a core, and what follows from them.
#include "paper/equal_shares.h"

#include <algorithm>
#include <map>

namespace ctn::paper {

Timing shared_timing(const Problem& problem, std::size_t subchain, int kind, int rivals) {
  const double equal = rivals * problem.on(subchain, kind).cost / problem.usable;
  const double period = std::max(equal, problem.subchains[subchain].min_period);
  return {period, period};
}

Timing owned_timing(const Problem& problem, std::size_t subchain, int kind, int cores) {
  const std::vector<Owned>& owned = problem.on(subchain, kind).owned;
  return owned[std::min(owned.size(), static_cast<std::size_t>(cores)) - 1].timing;
}

EqualShares value_of(const Problem& problem, const std::vector<Timing>& timings) {
  return {factor_of(problem.exact, timings), factor_of(problem.bounds, timings), objective_of(problem.terms, timings)};
}

std::vector<Timing> equal_shares(const Problem& problem, const Allocation& allocation) {
  std::map<int, int> sharing;
  for (const Place& place : allocation) sharing[place.shared] += place.owned == 0 ? 1 : 0;
  std::vector<Timing> timings;
  for (std::size_t i = 0; i < allocation.size(); ++i) {
    const Place& place = allocation[i];
    timings.push_back(place.owned > 0 ? owned_timing(problem, i, place.kind, place.owned)
                                      : shared_timing(problem, i, place.kind, sharing[place.shared]));
  }
  return timings;
}

}  // namespace ctn::paper
