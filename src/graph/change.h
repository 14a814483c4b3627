// An app with other weights and bounds, for changes while it runs. Its nodes, edges and chains stay what they are.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "base/result.h"
#include "catan/changes.h"
#include "graph/app.h"

namespace ctn::graph {

// How a term is named: the chain of a response time ("scan -> LM"), the node of a period ("period of LM").
std::string term_name(const App& app, const Term& term);
// The term that is meant, as catan/changes.h says; an index into the objective. kCaller: none, or more than one.
Result<std::size_t> find_term(const App& app, std::string_view name);

// The app with these weights and bounds; CPUs are not its concern. Where the order of slots and of stealing was what
// follows from the weights, it is what follows from the new ones. Errors: everything that is wrong, of the kinds that
// an app file is refused for, under the same keys; kCaller.
Result<App> changed(const App& app, const Changes& changes);

}  // namespace ctn::graph
