// An app as a picture: its nodes from left to right in the order data flow, one box a subchain. SVG without a script.
//
// How: a node's column is the longest path that leads to it. A subchain, which is a path, takes the stretch of a row
// from its head's column to its tail's; each row is shared by those whose stretches are apart. Rows are given in
// topological order, each as near as possible to those that feed it.
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

// By node; no two alike.
std::vector<Cell> lay_out(const graph::Graph& graph);

// `notes`: a second line in each node's box. `colours`: of subchains and unscheduled nodes, by node; empty: none.
std::string graph_picture(const graph::Graph& graph, const std::vector<std::string>& notes,
                          const std::vector<std::string>& colours);

}  // namespace ctn::page
