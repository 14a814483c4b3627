#include "plan/above_promise.h"

#include <algorithm>
#include <cstddef>

#include "plan/limits.h"

namespace ctn::plan {

std::string why_above_promise(const Plan& plan, const graph::App& app) {
  const auto& nodes = app.graph.nodes();
  const bool unscheduled = std::any_of(nodes.begin(), nodes.end(), [](const auto& node) { return node.unscheduled; });
  bool without_priority = false;
  bool deferred = false;
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const SubchainId id(i);
    const CorePlan& core = plan.cores[static_cast<std::size_t>(plan.subchains[i].cores.front())];
    without_priority = without_priority || member_of(plan, id) == nullptr;
    deferred =
        deferred || (shares_core(plan, plan.subchains[i]) && !has_fixed_frames(app, plan.cores, plan.subchains[i]) &&
                     period_limits(app.graph, id).min > Millis{0} && is_deferred(app.graph, plan, core, id));
  }
  std::string text = "no promise has in it what scheduling itself takes";
  if (unscheduled && without_priority) {
    text += ", nor what load unscheduled nodes are for subchains in frames or with cores of their own";
  }
  if (deferred) text += ", nor for how long elastic frames defer a run whose rate is capped";
  return text;
}

}  // namespace ctn::plan
