// What is asked of weights and rates, whether an app file says them or somebody changes them while the app runs. Each
// rule returns what is wrong, without its place; nothing: it is right. A `hint` says what the caller can change.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "base/result.h"
#include "graph/app.h"

namespace ctn::graph {

// Beyond this what is minimised could no longer be told from infinity.
constexpr double kMaxSumOfWeights = 1e100;

std::optional<Problem> wrong_weight(std::string key, double weight);

struct WrongSum {
  std::size_t term;  // the heaviest: to which it is reported
  Problem problem;
};
// Of weights that are right one by one: nothing where one is not.
std::optional<WrongSum> wrong_sum_of_weights(std::span<const double> weights);

// The rate that a node runs at at least, where a node before it in its subchain gives output less often.
std::optional<Problem> rate_above_outputs(const Graph& graph, NodeId node, Rate min_rate, std::string hint);

// A subchain that is triggered by arrival, of which a node has an exact rate.
std::optional<Problem> exact_rate_by_arrival(std::string key, const Graph& graph, const Subchain& subchain,
                                             std::string hint);

}  // namespace ctn::graph
