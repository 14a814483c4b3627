#include "dispatch/shared_core_schedule.h"

#include <algorithm>
#include <cassert>

#include "plan/limits.h"

namespace ctn::dispatch {
namespace {

int rank_of(const graph::App& app, SubchainId subchain) {
  const std::vector<SubchainId>& priority = app.steal.priority;
  return static_cast<int>(std::find(priority.begin(), priority.end(), subchain) - priority.begin());
}

bool steals(const graph::App& app, SubchainId subchain) {
  const std::vector<SubchainId>& off = app.steal.off;
  return std::find(off.begin(), off.end(), subchain) == off.end();
}

Nanos hang_after(const plan::SubchainPlan& planned, const ScheduleOptions& options) {
  if (options.hang_multiple == 0.0) return Nanos{0};
  return std::max(options.shortest_hang, to_nanos(planned.execution * options.hang_multiple));
}

}  // namespace

SharedCoreSchedule shared_core_schedule(const graph::App& app, const plan::Plan& plan, int core,
                                        const ScheduleOptions& options) {
  assert(core >= 0 && static_cast<std::size_t>(core) < plan.cores.size());
  const plan::CorePlan& planned = plan.cores[static_cast<std::size_t>(core)];
  const bool elastic = planned.frames == graph::FrameMode::kElastic;
  SharedCoreSchedule schedule{.frames = planned.frames,
                              .frame = std::max(to_nanos(planned.frame), kShortestFrame),
                              .frame_min = to_nanos(plan::least_elastic_frame(app.graph, plan, planned)),
                              .slack = plan.slack,
                              .slots = {}};
  for (const plan::Slot& slot : planned.slots) {
    const plan::SubchainPlan& subchain = plan.subchains[slot.subchain.index()];
    const Nanos slice = to_nanos(slot.slice);
    const bool put_off = elastic && plan::is_put_off(subchain);
    const Millis least = plan::period_limits(app.graph, slot.subchain).least;
    schedule.slots.push_back({.subchain = slot.subchain,
                              .offset = to_nanos(slot.offset),
                              .slice = elastic ? std::max(slice, kShortestSlice) : slice,
                              .every = slot.every,
                              .phase = slot.phase,
                              .share = subchain.share,
                              .rank = rank_of(app, slot.subchain),
                              .may_steal = options.stealing && steals(app, slot.subchain),
                              .least_period = put_off ? to_nanos(least) : Nanos{0},
                              .hang_after = hang_after(subchain, options)});
  }
  return schedule;
}

}  // namespace ctn::dispatch
