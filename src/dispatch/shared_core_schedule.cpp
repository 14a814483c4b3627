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

// A subchain that is unfinished because its run waits would hold up the owner of the next slot while no run computes.
bool waits(const plan::SubchainPlan& planned) { return to_nanos(planned.wait) > kSwitchAllowance; }

Nanos hang_after(const plan::SubchainPlan& planned, const ScheduleOptions& options) {
  if (options.hang_multiple == 0.0) return Nanos{0};
  return std::max(options.shortest_hang, to_nanos(planned.execution * options.hang_multiple));
}

// A run may be woken later than any plan can know. If its slot is a little longer, the run still ends in it and the
// others lose only that little; otherwise the run ends a whole frame later. A slot that ends with its run takes no more
// than the run uses.
Nanos elastic_slice(Nanos slice, std::optional<int> every) {
  return std::max(every == 1 ? slice + kSwitchAllowance : slice, kShortestSlice);
}

// In fixed frames idle time goes to the slots first: waking and switching take a part of each slot that no plan
// knows, and a run that does not end in its slot comes too late for the next subchain, which may use its output.
void share_out_idle(Nanos idle, std::vector<SharedCoreSlot>& slots) {
  if (slots.empty()) return;
  const Nanos more = std::min(idle / static_cast<std::int64_t>(slots.size()), kSwitchAllowance);
  for (std::size_t index = 0; index < slots.size(); ++index) {
    slots[index].offset += static_cast<std::int64_t>(index) * more;
    slots[index].slice += more;
  }
}

}  // namespace

SharedCoreSchedule shared_core_schedule(const graph::App& app, const plan::Plan& plan, int core,
                                        const ScheduleOptions& options) {
  assert(core >= 0 && static_cast<std::size_t>(core) < plan.cores.size());
  const plan::CorePlan& planned = plan.cores[static_cast<std::size_t>(core)];
  const bool elastic = planned.frames == graph::FrameMode::kElastic;
  SharedCoreSchedule schedule{.frames = planned.frames,
                              .frame = std::max(to_nanos(planned.frame), kShortestFrame),
                              .frame_min = to_nanos(plan::min_elastic_frame(app.graph, plan, planned)),
                              .slack = plan.slack,
                              .slots = {}};
  for (const plan::Slot& slot : planned.slots) {
    const plan::SubchainPlan& subchain = plan.subchains[slot.subchain.index()];
    const Nanos slice = to_nanos(slot.slice);
    const bool deferred = elastic && plan::is_deferred(app.graph, plan, planned, slot.subchain);
    const Millis min = plan::period_limits(app.graph, slot.subchain).min;
    schedule.slots.push_back({.subchain = slot.subchain,
                              .offset = to_nanos(slot.offset),
                              .slice = elastic ? elastic_slice(slice, slot.every) : slice,
                              .every = slot.every,
                              .phase = slot.phase,
                              .share = subchain.share,
                              .rank = rank_of(app, slot.subchain),
                              .may_steal = options.stealing && steals(app, slot.subchain) && !waits(subchain),
                              .min_period = deferred ? to_nanos(min) : Nanos{0},
                              .hang_after = hang_after(subchain, options)});
  }
  if (!elastic) share_out_idle(to_nanos(planned.idle), schedule.slots);
  return schedule;
}

}  // namespace ctn::dispatch
