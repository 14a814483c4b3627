// In which order subchains come where the app file does not say.
//
// Thread safety: pure functions.
#pragma once

#include <vector>

#include "graph/app.h"

namespace ctn::graph {

// The heaviest first; of equals, in the order written. Precondition: the app has its graph and its objective.
std::vector<SubchainId> ranked_by_weight(const App& app);
// A subchain comes before those that take its outputs, along the chains of the objective; else by weight.
std::vector<SubchainId> ordered_by_data_flow(const App& app);

}  // namespace ctn::graph
