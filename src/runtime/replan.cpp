#include "runtime/replan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "plan/limits.h"

namespace ctn::runtime {
namespace {

bool differs(double before, double after, double threshold) {
  return std::abs(after - before) > threshold * std::max(before, after);
}
bool differs(Millis before, Millis after) { return differs(before.count(), after.count(), kSwapThreshold); }

bool paced_differently(const plan::Plan& current, const plan::Plan& candidate, std::size_t index) {
  const plan::SubchainPlan& before = current.subchains[index];
  const plan::SubchainPlan& after = candidate.subchains[index];
  if (differs(before.period, after.period) || differs(before.execution, after.execution)) return true;
  if (!current.expected || !candidate.expected) return current.expected.has_value() != candidate.expected.has_value();
  return differs(current.expected->subchains[index].period, candidate.expected->subchains[index].period) ||
         differs(current.expected->subchains[index].execution, candidate.expected->subchains[index].execution);
}

bool does_better(const plan::Plan& current_now, const plan::Plan& candidate) {
  if (differs(current_now.relax_factor, candidate.relax_factor, kSwapThreshold)) {
    return candidate.relax_factor < current_now.relax_factor;
  }
  return candidate.objective < current_now.objective * (1.0 - kSwapThreshold);
}

}  // namespace

bool worth_a_swap(const plan::Plan& current, const std::optional<plan::Plan>& current_now,
                  const plan::Plan& candidate) {
  if (!current_now || does_better(*current_now, candidate)) return true;
  for (std::size_t index = 0; index < candidate.subchains.size(); ++index) {
    if (plan::shares_core(current, current.subchains[index])) {
      const Millis slice = current.subchains[index].slice;
      if (current_now->subchains[index].slice > slice * (1.0 + kOverrunThreshold)) return true;
    } else if (current.subchains[index].cores == candidate.subchains[index].cores) {
      if (paced_differently(current, candidate, index)) return true;
    }
  }
  return differs(current.objective, current_now->objective, kStaleThreshold);
}

dispatch::Pacing pacing_of(const graph::App& app, const plan::Plan& plan, SubchainId subchain) {
  const plan::SubchainPlan& planned = plan.subchains[subchain.index()];
  const Nanos hang_after = std::max(kShortestHang, to_nanos(planned.execution * kHangMultiple));
  const plan::PeriodLimits limits = plan::period_limits(app.graph, subchain);
  if (app.scheduler.frames == graph::FrameMode::kFixed || limits.exact) {
    return dispatch::pacing_of_owned(planned.period, planned.execution, hang_after);
  }
  const plan::Expectation::Timing timing = plan.expected ? plan.expected->subchains[subchain.index()]
                                                         : plan::Expectation::Timing{planned.period, planned.execution};
  return dispatch::elastic_pacing_of_owned(timing.period, timing.execution, hang_after, to_nanos(limits.least));
}

}  // namespace ctn::runtime
