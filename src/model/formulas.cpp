#include "model/formulas.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace ctn::model {

OwnedCores owned_cores_with(const graph::Graph& graph, SubchainId subchain, const CostTable& costs, int cores,
                            int threads, double slack) {
  assert(1 <= threads && threads <= cores && slack >= 0.0 && slack < 1.0);
  const double usable = 1.0 - slack;
  const Millis wait = costs.subchain_wait(graph, subchain);
  Millis longest{0};
  Millis sum{0};
  for (const NodeId node : graph.subchain(subchain).nodes) {
    const Millis cost = costs[node].with_threads(threads, graph.node(node).max_threads);
    longest = std::max(longest, cost / usable + costs.wait(node));
    sum += cost;
  }
  const Millis all = sum / usable + wait;
  return {threads, std::max(longest, all / (cores / threads)), sum + wait};
}

OwnedCores owned_cores(const graph::Graph& graph, SubchainId subchain, const CostTable& costs, int cores,
                       double slack) {
  assert(cores >= 1);
  OwnedCores best = owned_cores_with(graph, subchain, costs, cores, 1, slack);
  for (int threads = 2; threads <= cores; ++threads) {
    const OwnedCores other = owned_cores_with(graph, subchain, costs, cores, threads, slack);
    if (other.execution + other.period < best.execution + best.period) best = other;
  }
  return best;
}

namespace {

// So many frames, at most, until the shares of a run add up to one.
double frames_of_run(double share) {
  constexpr double kHair = 1e-9;
  return std::max(1.0, std::ceil(1.0 / share - kHair));
}

}  // namespace

SharedTiming shared_core(const SharedCore& on, bool exact_rate) {
  const Millis spread = on.frame / on.share;
  const double frames = frames_of_run(on.share);
  const Millis execution = frames * on.frame + on.slice / on.share - frames * on.slice;
  if (on.wait == Millis{0}) return {spread, execution};
  if (exact_rate || (on.wait <= kShortWait && on.share <= 1.0)) return {spread, execution + on.wait};
  const Millis late = frames * on.frame + on.wait + on.frame + on.slice;
  return {late, late};
}

Millis longest_gap(Millis frame, double share) { return frames_of_run(share) * frame; }

std::optional<InStep> InStep::of(const Grid& first, const Grid& second) {
  const auto [shorter, longer] = std::minmax(first.period, second.period);
  if (longer % shorter != Nanos{0}) return std::nullopt;
  InStep step;
  step.shorter_ = to_millis(shorter);
  step.apart_ = to_millis(((second.phase - first.phase) % shorter + shorter) % shorter);
  step.more_ = to_millis(std::max(second.period - first.period, Nanos{0}));
  return step;
}

InputWait InStep::wait(Millis execution, bool below) const {
  InputWait wait{apart_ - execution, more_};
  if (wait.last >= Millis{0}) return wait;
  const double missed = std::ceil(-wait.last.count() / shorter_.count());
  wait.last = below && apart_ >= kTogether ? Millis{0} : wait.last + missed * shorter_;
  return wait;
}

LeftOut left_out(const graph::Graph& graph, const CostTable& costs, const graph::Subchain& subchain, NodeId node) {
  LeftOut left;
  for (const NodeId each : subchain.nodes) {
    if (graph.node(each).output_period) {
      left.periods += to_millis(*graph.node(each).output_period);
      left.runs += 1.0;
    } else {
      left.periods *= costs.runs_per_output(each);
      left.runs *= costs.runs_per_output(each);
    }
    if (each == node) break;
  }
  return left;
}

LeftOut left_out(const graph::Node& unscheduled) {
  if (!unscheduled.output_period) return {};
  return {to_millis(*unscheduled.output_period), 1.0};
}

Millis outputs_late(const graph::Graph& graph, const CostTable& costs, const graph::Subchain& subchain, Millis period,
                    Millis execution) {
  const Millis runs = costs.runs_per_output(subchain, subchain.tail()) * period;
  const Millis usual = std::max(runs, to_millis(graph.output_period_up_to(subchain.tail())));
  return runs + left_out(graph, costs, subchain, subchain.tail()).most(execution) - usual;
}

ChainTiming chain_timing(std::span<const ElementTiming> elements) {
  assert(!elements.empty());
  ChainTiming timing;
  for (const ElementTiming& element : elements) {
    if (&element != &elements.front()) timing.latency += element.wait.value_or(element.period);
    timing.latency += element.execution;
    timing.period = std::max(timing.period, element.period * element.runs_per_output);
  }
  for (const ElementTiming& element : elements) timing.period += element.left_out;
  const ElementTiming& first = elements.front();
  if (first.wait) timing.period += std::max(*first.wait - first.period, Millis{0});
  timing.response = timing.latency + timing.period;
  return timing;
}

}  // namespace ctn::model
