// Two runs side by side: what their apps have in common, and by how much figures differ.
//
// Chains are matched by their paths, nodes by their names. Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "report/metrics.h"
#include "report/table.h"

namespace ctn::page {

// What only one of the apps has, in words: nodes, edges, subchains, response times; empty: nothing. `name` and
// `other_name` are those of the records. kCaller: no node is in both.
Result<std::vector<std::string>> differences_of(const graph::App& app, const std::string& name, const graph::App& other,
                                                const std::string& other_name);

std::optional<std::size_t> find_chain(const report::RunFigures& figures, const std::string& path);

// Tables of the whole runs, and of the chains and nodes that both have. A cell has the figure of the first run, a, that
// of the other, b, and in brackets by how much b differs, in percent of a. Captions say which run is which.
std::vector<report::Table> comparison_tables(const report::RunFigures& run, const std::string& name,
                                             const report::RunFigures& other, const std::string& other_name);

}  // namespace ctn::page
