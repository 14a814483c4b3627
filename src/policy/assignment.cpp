#include "policy/assignment.h"

#include <algorithm>
#include <utility>

#include "plan/limits.h"
#include "policy/replan.h"

namespace ctn::policy {
namespace {

// What is promised of a run may be many times what ever happens. It ends once a period on average. A promise for
// typical compute times is exceeded by a run that takes its whole budget, which is no reason to think that it hangs.
Millis longest_usual_run(const plan::Plan& plan, const plan::Member& member, Millis usual_period) {
  const plan::SubchainPlan& planned = plan.subchains[member.subchain.index()];
  const Millis longest = std::max(usual_period, planned.slice + planned.wait);
  const Millis usual = std::min(planned.execution, longest);
  return plan.for_typical ? std::max(usual, member.budget + planned.wait) : usual;
}

// What a run that waits for its turn may have to wait for, and its own: each above it keeps the core for all of its
// budget. Nothing hangs in that time, however short its own runs usually are.
Millis turns_up_to(const plan::Plan& plan, const plan::Member& member) {
  Millis sum{0};
  const int core = plan.subchains[member.subchain.index()].cores.front();
  for (const plan::Member& other : plan.cores[static_cast<std::size_t>(core)].members) {
    sum += other.budget + plan.subchains[other.subchain.index()].wait;
    if (other.subchain == member.subchain) break;
  }
  return sum;
}

dispatch::Pacing pacing_of_member(const graph::App& app, const plan::Plan& plan, const plan::Member& member) {
  const plan::SubchainPlan& planned = plan.subchains[member.subchain.index()];
  const Nanos shortest_hang = plan.assumed.empty() ? kShortestHang : kShortestHangIfAssumed;
  dispatch::Pacing pacing;
  pacing.max_in_flight = 1;
  const Millis usual = plan::usual_timing(plan, member.subchain).period;
  pacing.hang_after = std::max({shortest_hang, to_nanos(longest_usual_run(plan, member, usual) * kHangMultiple),
                                to_nanos(turns_up_to(plan, member))});
  pacing.budget = to_nanos(member.budget);
  const Nanos cap = to_nanos(plan::period_limits(app.graph, member.subchain).min);
  const auto at_least_shortest = [](Nanos period) { return std::max(period, dispatch::kShortestPeriod); };
  pacing.shortest = at_least_shortest(std::max(cap, to_nanos(member.period)));
  if (member.pause) {
    // No less than those below it were promised (plan/promise.h).
    pacing.period = std::max(pacing.shortest, to_nanos(std::max(usual, planned.slice + *member.pause)));
    pacing.after_completion = std::max(to_nanos(*member.pause), Nanos{1});
  } else if (member.after) {
    pacing.period = at_least_shortest(to_nanos(usual));
    pacing.after = member.after;
  } else {
    pacing.period = at_least_shortest(to_nanos(member.period));
    pacing.phase = to_nanos(member.phase);
    pacing.clock = member.clock;
    if (member.clock) {
      const Millis tick = to_millis(*app.graph.node(*member.clock).period);
      pacing.ticks = plan::ticks_of(member.period, tick).value_or(TickCount{});
    }
  }
  return pacing;
}

SubchainPlace place_of(const graph::App& app, const plan::Plan& plan, const os::CpuSet& cpus, SubchainId id) {
  const plan::SubchainPlan& planned = plan.subchains[id.index()];
  SubchainPlace place;
  place.threads = planned.threads;
  std::vector<int> numbers;
  for (const int core : planned.cores) numbers.push_back(cpus.cpus()[static_cast<std::size_t>(core)]);
  place.cpus = os::CpuSet(std::move(numbers));
  if (plan::shares_core(plan, planned)) {
    place.core = planned.cores.front();
  } else if (const plan::Member* const member = plan::member_of(plan, id)) {
    place.pacing = pacing_of_member(app, plan, *member);
    place.level = os::fixed_level(member->priority - 1);
  } else {
    place.pacing = pacing_of(app, plan, id);
    place.level = os::Level::kActive;
  }
  return place;
}

}  // namespace

Assignment assignment_of(const graph::App& app, const plan::Plan& plan, const os::CpuSet& cpus,
                         const AssignmentOptions& options) {
  Assignment assignment;
  for (std::size_t index = 0; index < plan.subchains.size(); ++index) {
    assignment.places.push_back(place_of(app, plan, cpus, SubchainId(index)));
  }
  const dispatch::ScheduleOptions schedule{
      .stealing = options.stealing, .hang_multiple = kHangMultiple, .shortest_hang = kShortestHang};
  for (std::size_t core = 0; core < plan.cores.size(); ++core) {
    assignment.cores.push_back(dispatch::shared_core_schedule(app, plan, static_cast<int>(core), schedule));
  }
  return assignment;
}

void remove_absent(Assignment& assignment, const std::vector<bool>& present) {
  for (std::size_t index = 0; index < present.size(); ++index) {
    SubchainPlace& place = assignment.places[index];
    place.present = present[index];
    // A follower of a subchain that is not there goes by time.
    const SubchainId* const leader = place.pacing.after ? place.pacing.after->subchain() : nullptr;
    if (leader != nullptr && !present[leader->index()]) place.pacing.after.reset();
  }
  for (dispatch::SharedCoreSchedule& core : assignment.cores) {
    std::erase_if(core.slots, [&](const dispatch::SharedCoreSlot& slot) { return !present[slot.subchain.index()]; });
  }
}

}  // namespace ctn::policy
