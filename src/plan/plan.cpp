#include "plan/plan.h"

#include <algorithm>

namespace ctn::plan {

const char* to_string(Form form) { return form == Form::kFrames ? "frames" : "priorities"; }

Expectation::Timing usual_timing(const Plan& plan, SubchainId subchain) {
  if (plan.expected) return plan.expected->subchains[subchain.index()];
  const SubchainPlan& promised = plan.subchains[subchain.index()];
  return {promised.period, promised.execution};
}

Millis usual_period(const graph::Graph& graph, const Plan& plan, const NodePlan& node) {
  const std::optional<SubchainId> subchain = graph.node(node.node).subchain;
  return subchain ? usual_timing(plan, *subchain).period : node.period;
}

const Member* member_of(const Plan& plan, SubchainId subchain) {
  const int core = plan.subchains[subchain.index()].cores.front();
  const std::vector<Member>& members = plan.cores[static_cast<std::size_t>(core)].members;
  const auto found =
      std::find_if(members.begin(), members.end(), [&](const Member& member) { return member.subchain == subchain; });
  return found != members.end() ? &*found : nullptr;
}

}  // namespace ctn::plan
