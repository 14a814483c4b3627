#include "graph/ranking.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

namespace ctn::graph {

// All weights in one pass over the objective: `App::weight_of` for each would be quadratic.
std::vector<SubchainId> ranked_by_weight(const App& app) {
  std::vector<double> weights(app.graph.subchains().size(), 0.0);
  for (const Term& term : app.objective) {
    std::vector<SubchainId> part;
    for (const NodeId id : term.path) {
      if (const auto subchain = app.graph.node(id).subchain) part.push_back(*subchain);
    }
    std::sort(part.begin(), part.end());
    part.erase(std::unique(part.begin(), part.end()), part.end());
    for (const SubchainId id : part) weights[id.index()] += term.weight;
  }
  std::vector<SubchainId> ranking;
  for (std::size_t i = 0; i < weights.size(); ++i) ranking.emplace_back(i);
  // A weight that is no number was reported; compared as it is, it would break the sort.
  const auto weight = [&](SubchainId id) { return std::isnan(weights[id.index()]) ? 0.0 : weights[id.index()]; };
  std::stable_sort(ranking.begin(), ranking.end(), [&](SubchainId a, SubchainId b) { return weight(a) > weight(b); });
  return ranking;
}

// The output of a subchain is up to a frame old if the subchain that uses it has its slot earlier. So producers come
// first: along the chains of the objective, heavier ones before lighter ones where they disagree, and by weight where
// neither says anything.
std::vector<SubchainId> ordered_by_data_flow(const App& app) {
  const std::vector<SubchainId> ranking = ranked_by_weight(app);
  std::vector<std::set<SubchainId>> after(ranking.size());  // by subchain: those that must come later
  const auto leads_to = [&](SubchainId from, SubchainId to) {
    std::vector<SubchainId> reached{from};
    std::set<SubchainId> seen{from};
    while (!reached.empty() && !seen.contains(to)) {
      const SubchainId at = reached.back();
      reached.pop_back();
      for (const SubchainId next : after[at.index()]) {
        if (seen.insert(next).second) reached.push_back(next);
      }
    }
    return seen.contains(to);
  };
  std::vector<const Term*> terms;
  for (const Term& term : app.objective) {
    if (term.weight > 0.0) terms.push_back(&term);
  }
  std::stable_sort(terms.begin(), terms.end(), [](const Term* a, const Term* b) { return a->weight > b->weight; });
  for (const Term* term : terms) {
    std::optional<SubchainId> giver;
    for (const NodeId node : term->path) {
      const std::optional<SubchainId> user = app.graph.node(node).subchain;
      if (!user) continue;
      if (giver && !leads_to(*user, *giver)) after[giver->index()].insert(*user);
      giver = user;
    }
  }
  std::vector<SubchainId> order;
  std::vector<SubchainId> left = ranking;
  while (!left.empty()) {
    const auto first = std::find_if(left.begin(), left.end(), [&](SubchainId candidate) {
      return std::none_of(left.begin(), left.end(),
                          [&](SubchainId other) { return after[other.index()].contains(candidate); });
    });
    order.push_back(*first);
    left.erase(first);
  }
  return order;
}

}  // namespace ctn::graph
