// An app as it runs where its rates are set by hand, each node at its own: a subchain runs at one rate, so it is cut in
// front of each of its nodes that has a fallback_rate.
//
//   subchains: { local: [scan, LM, LP] }, with a fallback_rate of LM and of LP, becomes
//   local: [scan], and LM and LP by themselves
//
// What is cut off is a subchain under the name of its first node, as if the app file had been written so: it is
// triggered by time, takes the newest outputs of its predecessors, and triggers the nodes behind it that have no rate
// of their own. In the orders of slots and of stealing it comes behind what it was cut from.
//
// Thread safety: pure functions.
#pragma once

#include "graph/app.h"

namespace ctn::graph {

// Cut once or several times, it is the same.
App cut_at_fallback_rates(const App& app);

}  // namespace ctn::graph
