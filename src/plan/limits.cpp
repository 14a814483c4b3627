#include "plan/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "plan/predict.h"

namespace ctn::plan {
namespace {

bool has_exact_rate(const graph::Node& node) {
  return node.min_rate && node.max_rate && *node.min_rate == *node.max_rate && !node.relaxes_exact_rate;
}

std::string min_rate_key(const graph::Node& node) { return fmt::format("nodes.{}.min_rate", node.name); }

}  // namespace

PeriodLimits period_limits(const graph::Graph& graph, SubchainId subchain) {
  PeriodLimits limits;
  for (const NodeId id : graph.subchain(subchain).nodes) {
    const graph::Node& node = graph.node(id);
    if (node.max_rate && node.max_rate->period() > limits.min) {
      limits.min = node.max_rate->period();
      limits.capped = id;
    }
    if (has_exact_rate(node)) {
      limits.exact = node.max_rate->period();
      limits.exact_of = id;
    }
  }
  return limits;
}

std::vector<UsefulPeriod> useful_periods(const graph::Graph& graph) {
  std::vector<UsefulPeriod> useful(graph.subchains().size());
  // Of the node's outputs, at least; 0: anything. What feeds its subchain's head is known by then.
  const auto outputs_apart = [&](NodeId id) {
    const graph::Node& node = graph.node(id);
    if (node.external) return to_millis(*node.period);
    if (!node.subchain) return to_millis(node.outputs_apart());
    return std::max({period_limits(graph, *node.subchain).min, useful[node.subchain->index()].min,
                     to_millis(graph.output_period_up_to(id))});
  };
  for (const NodeId id : graph.topological_order()) {
    const graph::Node& node = graph.node(id);
    if (!node.subchain || graph.subchain(*node.subchain).head() != id || !graph.awaits_input(id)) continue;
    UsefulPeriod& of = useful[node.subchain->index()];
    for (const NodeId from : node.predecessors) {
      const Millis apart = outputs_apart(from);
      if (of.from && apart >= of.min) continue;
      of = {apart, from};
    }
  }
  return useful;
}

bool has_exact_rates(const graph::Graph& graph) {
  return std::any_of(graph.nodes().begin(), graph.nodes().end(), has_exact_rate);
}

graph::App relaxing_exact_rates(const graph::App& app) {
  graph::App other = app;
  other.graph = app.graph.relaxing_exact_rates();
  return other;
}

bool relaxes_exact_rates(const Plan& plan, const graph::App& app) {
  return std::any_of(app.graph.nodes().begin(), app.graph.nodes().end(), [&](const graph::Node& node) {
    return has_exact_rate(node) &&
           std::any_of(plan.relaxed.begin(), plan.relaxed.end(),
                       [&](const RelaxedBound& bound) { return bound.key == min_rate_key(node); });
  });
}

graph::App as_planned(const graph::App& app, const Plan& plan) {
  return relaxes_exact_rates(plan, app) ? relaxing_exact_rates(app) : app;
}

std::vector<SoftBound> soft_bounds(const graph::App& app) {
  std::vector<SoftBound> bounds;
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    if (!app.objective[term].max) continue;
    bounds.push_back({fmt::format("objective[{}].max", term), to_millis(*app.objective[term].max), {}, term});
  }
  for (std::size_t index = 0; index < app.graph.nodes().size(); ++index) {
    const graph::Node& node = app.graph.nodes()[index];
    if (!node.subchain || !node.min_rate || has_exact_rate(node)) continue;
    bounds.push_back({min_rate_key(node), node.min_rate->period(), NodeId{index}, {}});
  }
  return bounds;
}

bool is_deferred(const graph::Graph& graph, const Plan& plan, const CorePlan& core, SubchainId subchain) {
  const double every = 1.0 / plan.subchains[subchain.index()].share;
  if (every >= kDeferredFrom * (1.0 - kTolerance)) return true;
  // Saved credit lets a queue's runs follow each other in one slot, where no cap is looked at.
  if (takes_batches(graph, subchain)) return false;
  Millis slices{0};
  for (const Slot& slot : core.slots) slices += slot.slice;
  return period_limits(graph, subchain).min * (1.0 - plan.slack) >= kDeferredFrom * slices;
}

namespace {

Millis held_frame(const graph::Graph& graph, const Plan& plan, const CorePlan& core, bool elastic) {
  Millis min{0};
  for (const Slot& slot : core.slots) {
    const SubchainPlan& subchain = plan.subchains[slot.subchain.index()];
    if (elastic && is_deferred(graph, plan, core, slot.subchain)) continue;
    min = std::max(min, subchain.share * period_limits(graph, slot.subchain).min);
  }
  return min;
}

}  // namespace

Millis min_frame(const graph::Graph& graph, const Plan& plan, const CorePlan& core) {
  return held_frame(graph, plan, core, false);
}

Millis min_elastic_frame(const graph::Graph& graph, const Plan& plan, const CorePlan& core) {
  return held_frame(graph, plan, core, true);
}

bool takes_batches(const graph::Graph& graph, SubchainId subchain) {
  return graph.node(graph.subchain(subchain).head()).input == graph::InputKind::kQueue;
}

std::optional<TickCount> ticks_of(Millis period, Millis clock) {
  constexpr double kDigits = 1e-3;
  constexpr double kMaxTicks = 1e6;
  constexpr int kMaxParts = 4;
  for (int parts = 1; parts <= kMaxParts; ++parts) {
    const double ticks = parts * (period / clock);
    const double whole = std::round(ticks);
    if (whole < 1.0 || whole > kMaxTicks || std::abs(ticks - whole) > kDigits * whole / parts) continue;
    return TickCount{static_cast<int>(whole), parts};
  }
  return std::nullopt;
}

}  // namespace ctn::plan
