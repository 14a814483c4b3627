#include "graph/rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/text.h"

namespace ctn::graph {
namespace {

bool is_weight(double weight) { return std::isfinite(weight) && weight >= 0.0; }

}  // namespace

std::optional<Problem> wrong_weight(std::string key, double weight) {
  if (is_weight(weight)) return std::nullopt;
  return Problem{{},
                 std::move(key),
                 fmt::format("weight {} is no number from 0 up", weight),
                 "write 0 or more: what one millisecond counts"};
}

std::optional<WrongSum> wrong_sum_of_weights(std::span<const double> weights) {
  if (!std::all_of(weights.begin(), weights.end(), is_weight)) return std::nullopt;
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (sum <= kMaxSumOfWeights) return std::nullopt;
  const auto heaviest = static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  return WrongSum{heaviest,
                  {{},
                   fmt::format("objective[{}].weight", heaviest),
                   fmt::format("weight {} is too large: all weights together may be {} at most", weights[heaviest],
                               kMaxSumOfWeights),
                   "write smaller ones: only what they are to one another counts"}};
}

std::optional<Problem> rate_above_outputs(const Graph& graph, NodeId node, Rate min_rate, std::string hint) {
  const Nanos apart = graph.output_period_before(node);
  if (apart <= Nanos{0} || min_rate.period() >= apart) return std::nullopt;
  return Problem{
      {},
      fmt::format("nodes.{}.min_rate", graph.node(node).name),
      fmt::format("{}Hz cannot be had: a node before it in subchain {} gives output every {:.6g} ms at most",
                  min_rate.hertz(), quote(graph.subchain(*graph.node(node).subchain).name), to_millis(apart).count()),
      std::move(hint)};
}

std::optional<Problem> exact_rate_by_arrival(std::string key, const Graph& graph, const Subchain& subchain,
                                             std::string hint) {
  const auto is_exact = [&](NodeId id) {
    const Node& node = graph.node(id);
    return node.min_rate && node.min_rate == node.max_rate;
  };
  if (graph.node(subchain.head()).trigger != TriggerBy::kArrival) return std::nullopt;
  if (std::none_of(subchain.nodes.begin(), subchain.nodes.end(), is_exact)) return std::nullopt;
  return Problem{{},
                 std::move(key),
                 fmt::format("subchain {} has an exact rate, which is kept by time, and is triggered by arrival",
                             quote(subchain.name)),
                 std::move(hint)};
}

}  // namespace ctn::graph
