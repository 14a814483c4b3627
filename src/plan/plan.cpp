#include "plan/plan.h"

#include <algorithm>
#include <cstddef>

#include "model/formulas.h"

namespace ctn::plan {

const char* to_string(Form form) { return form == Form::kFrames ? "frames" : "priorities"; }

std::vector<int> first_cores(std::span<const SubchainPlan> subchains) {
  std::vector<int> cores;
  cores.reserve(subchains.size());
  for (const SubchainPlan& subchain : subchains) cores.push_back(subchain.cores.front());
  return cores;
}

std::optional<Millis> longest_gap(std::span<const CorePlan> cores, const SubchainPlan& subchain) {
  const auto core = static_cast<std::size_t>(subchain.cores.front());
  if (subchain.every || core >= cores.size() || cores[core].slots.empty()) return std::nullopt;
  // Where something shorter is expected of it, so it is of its frames.
  const Millis frame = std::min(cores[core].frame, subchain.period * subchain.share);
  const Millis gap = model::longest_gap(frame, subchain.share);
  return gap > subchain.period ? std::optional(gap) : std::nullopt;
}

Expectation::Timing usual_timing(const Plan& plan, SubchainId subchain) {
  if (plan.expected) return plan.expected->subchains[subchain.index()];
  const SubchainPlan& promised = plan.subchains[subchain.index()];
  return {promised.period, promised.execution};
}

Millis usual_period(const graph::Graph& graph, const Plan& plan, const NodePlan& node) {
  const std::optional<SubchainId> subchain = graph.node(node.node).subchain;
  return subchain ? usual_timing(plan, *subchain).period : node.period;
}

std::vector<std::size_t> chains_above_promise(const Plan& plan) {
  constexpr double kMargin = 0.01;
  std::vector<std::size_t> above;
  if (!plan.expected || plan.for_typical) return above;
  const std::size_t count = std::min(plan.chains.size(), plan.expected->chains.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (plan.expected->chains[i].response > plan.chains[i].response * (1.0 + kMargin)) above.push_back(i);
  }
  return above;
}

const Member* member_of(const Plan& plan, SubchainId subchain) {
  const int core = plan.subchains[subchain.index()].cores.front();
  const std::vector<Member>& members = plan.cores[static_cast<std::size_t>(core)].members;
  const auto found =
      std::find_if(members.begin(), members.end(), [&](const Member& member) { return member.subchain == subchain; });
  return found != members.end() ? &*found : nullptr;
}

}  // namespace ctn::plan
