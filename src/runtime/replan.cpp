#include "runtime/replan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "plan/limits.h"

namespace ctn::runtime {
namespace {

bool differs(Millis before, Millis after) {
  return std::abs((after - before).count()) > kSwapThreshold * std::max(before, after).count();
}

bool differs(const std::optional<plan::Expectation>& before, const std::optional<plan::Expectation>& after) {
  if (!before || !after) return before.has_value() != after.has_value();
  for (std::size_t index = 0; index < after->subchains.size(); ++index) {
    if (differs(before->subchains[index].period, after->subchains[index].period)) return true;
    if (differs(before->subchains[index].execution, after->subchains[index].execution)) return true;
  }
  return false;
}

}  // namespace

bool worth_a_swap(const plan::Plan& current, const plan::Plan& candidate) {
  for (std::size_t index = 0; index < candidate.subchains.size(); ++index) {
    const plan::SubchainPlan& before = current.subchains[index];
    const plan::SubchainPlan& after = candidate.subchains[index];
    if (before.cores != after.cores || before.threads != after.threads || before.every != after.every) return true;
    if (differs(before.period, after.period) || differs(before.execution, after.execution)) return true;
  }
  return differs(current.expected, candidate.expected);
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
