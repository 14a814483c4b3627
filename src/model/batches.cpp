#include "model/batches.h"

#include <algorithm>
#include <cmath>

namespace ctn::model {
namespace {

// Two periods in whose ratio there is no more than this of rounding are in a whole ratio.
constexpr double kRounding = 1e-9;

double no_more_than_fit(double items) { return std::min(items, kMaxItems); }

}  // namespace

double BatchInput::mean_items(Millis window, Millis runs_apart) const {
  if (one_a_run) return 1.0;
  const Millis outputs = subchain ? std::max(runs_apart * runs_per_output, output_period) : apart * runs_per_output;
  return outputs > Millis{0} ? no_more_than_fit(window / outputs) : kMaxItems;
}

double BatchInput::max_items(Millis window, Millis runs_apart) const {
  if (one_a_run) return 1.0;
  const Millis outputs = subchain ? std::max(runs_apart, output_period) : apart;
  return outputs > Millis{0} ? no_more_than_fit(std::ceil(window / outputs - kRounding) + 1.0) : kMaxItems;
}

std::vector<BatchInput> batch_inputs(const graph::Graph& graph, const CostTable& costs, NodeId node) {
  std::vector<BatchInput> inputs;
  const std::optional<SubchainId> own = graph.node(node).subchain;
  for (const NodeId from : graph.node(node).predecessors) {
    const graph::Node& giver = graph.node(from);
    if (giver.external) continue;
    BatchInput& input = inputs.emplace_back();
    input.subchain = giver.subchain;
    input.one_a_run = own && giver.subchain == own;
    if (giver.subchain) {
      input.output_period = to_millis(graph.output_period_up_to(from));
      input.runs_per_output = costs.runs_per_output(graph.subchain(*giver.subchain), from);
    } else {
      input.apart = to_millis(giver.outputs_apart());
      input.runs_per_output = costs.runs_per_output(from);
    }
  }
  return inputs;
}

}  // namespace ctn::model
