#include "runtime/replan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

namespace ctn::runtime {
namespace {

constexpr int kHangMultiple = 10;
constexpr Nanos kShortestHang = std::chrono::seconds{1};

bool differs(Millis before, Millis after) {
  return std::abs((after - before).count()) > kSwapThreshold * std::max(before, after).count();
}

// The period of the lowest of the subchain's rate caps; zero where there is none.
Millis shortest_allowed(const graph::App& app, SubchainId subchain) {
  Millis shortest{0};
  for (const NodeId node : app.graph.subchain(subchain).nodes) {
    const std::optional<Rate>& cap = app.graph.node(node).max_rate;
    if (cap) shortest = std::max(shortest, cap->period());
  }
  return shortest;
}

}  // namespace

bool worth_a_swap(const plan::Plan& current, const plan::Plan& candidate) {
  for (std::size_t index = 0; index < candidate.subchains.size(); ++index) {
    const plan::SubchainPlan& before = current.subchains[index];
    const plan::SubchainPlan& after = candidate.subchains[index];
    if (before.cores != after.cores || before.threads != after.threads || before.every != after.every) return true;
    if (differs(before.period, after.period) || differs(before.execution, after.execution)) return true;
  }
  return false;
}

dispatch::Pacing pacing_of(const graph::App& app, const plan::Plan& plan, SubchainId subchain) {
  const plan::SubchainPlan& planned = plan.subchains[subchain.index()];
  const Nanos hang_after = std::max(kShortestHang, to_nanos(planned.execution * kHangMultiple));
  if (app.scheduler.frames == graph::FrameMode::kFixed) {
    return dispatch::pacing_of_owned(planned.period, planned.execution, hang_after);
  }
  const double used = 1.0 - plan.slack;
  const auto pipelines = std::max(1, static_cast<int>(planned.cores.size()) / std::max(1, planned.threads));
  const Millis busy = planned.execution / pipelines / used;
  const Millis shortest = shortest_allowed(app, subchain);
  const Millis period = std::min(planned.period, std::max({planned.period * used, busy, shortest}));
  return dispatch::elastic_pacing_of_owned(period, planned.execution, hang_after, to_nanos(shortest));
}

}  // namespace ctn::runtime
