// An app as a picture: its nodes from left to right, as data flow, with a box for each subchain. SVG without a script.
//
// How: a node's column is the longest path that leads to it. A subchain, which is a path, takes the stretch of a row
// from its head's column to its tail's; subchains and nodes whose stretches do not overlap share a row. Rows are
// assigned in topological order, each as near as possible to the rows of its predecessors.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "graph/app.h"

namespace ctn::page {

struct Cell {
  std::size_t column = 0;
  std::size_t row = 0;
  friend bool operator==(const Cell&, const Cell&) = default;
};

// The cell of each node; no two have the same.
std::vector<Cell> lay_out(const graph::Graph& graph);

// `notes`: a second line in each node's box. `colours`: by node, that of its subchain or, if it is
// unscheduled, its own; empty: none.
std::string graph_picture(const graph::Graph& graph, const std::vector<std::string>& notes,
                          const std::vector<std::string>& colours);

}  // namespace ctn::page
