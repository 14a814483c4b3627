// Which subchain has which core, and what each core group's formula makes of it (docs/architecture.md; the planner's
// model).
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "model/formulas.h"
#include "plan/check.h"
#include "plan/limits.h"
#include "plan/predict.h"
#include "plan/promise.h"

namespace ctn::plan {
namespace {

using Members = std::vector<SubchainId>;

std::vector<Members> members_by_core(const Plan& plan) {
  std::vector<Members> members(plan.cores.size());
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    for (const int core : plan.subchains[i].cores) members[static_cast<std::size_t>(core)].emplace_back(i);
  }
  return members;
}

bool in_frames(const CorePlan& core, const Members& members) {
  return core.form == Form::kFrames && members.size() > 1;
}

std::string names_of(const graph::Graph& graph, const Members& members) {
  std::string names;
  for (const SubchainId id : members) names += (names.empty() ? "" : ", ") + graph.subchain(id).name;
  return names;
}

// On a core that no subchains share there are no turns to take: its frame is empty.
void check_no_frame(Check& check, std::size_t number) {
  const CorePlan& core = check.plan.cores[number];
  if (!core.slots.empty()) check.problem(Check::core_key(number, "slots"), "a core that is not shared has no slots");
  check.expect(Check::core_key(number, "frame_ms"), core.frame, Millis{0}, "a core that is not shared");
  check.expect(Check::core_key(number, "frame_min_ms"), core.frame_min, Millis{0}, "a core that is not shared");
  check.expect(Check::core_key(number, "idle_ms"), core.idle, Millis{0}, "a core that is not shared");
}

// Every slot is of a member, every member has one, and they stand in the app's order, one after the other.
void check_slots(Check& check, std::size_t number, const Members& members) {
  const CorePlan& core = check.plan.cores[number];
  std::vector<SubchainId> expected;
  std::copy_if(check.app.order.begin(), check.app.order.end(), std::back_inserter(expected),
               [&](SubchainId id) { return std::find(members.begin(), members.end(), id) != members.end(); });
  std::vector<SubchainId> planned;
  for (const Slot& slot : core.slots) planned.push_back(slot.subchain);
  if (planned != expected) {
    check.problem(Check::core_key(number, "slots"),
                  fmt::format("the slots of this core must be: {}", names_of(check.app.graph, expected)));
    return;
  }
  Millis offset{0};
  for (std::size_t i = 0; i < core.slots.size(); ++i) {
    const Slot& slot = core.slots[i];
    const SubchainPlan& subchain = check.plan.subchains[slot.subchain.index()];
    check.expect(Check::slot_key(number, i, "offset_ms"), slot.offset, offset, "the sum of the slices before");
    check.expect(Check::slot_key(number, i, "slice_ms"), slot.slice, subchain.slice, "the subchain's plan");
    if (slot.every != subchain.every) check.problem(Check::slot_key(number, i, "every"), "the subchain's differs");
    offset += slot.slice;
  }
  check.expect(Check::core_key(number, "frame_ms"), core.frame, (offset + core.idle) / (1.0 - check.plan.slack),
               "slices, idle time and slack");
  if (!at_least(core.frame, core.frame_min)) {
    check.problem(Check::core_key(number, "frame_min_ms"), "the shortest frame is longer than the frame");
  }
}

bool needs_fixed_frames(const graph::App& app, const Members& members) {
  return app.scheduler.frames == graph::FrameMode::kFixed ||
         std::any_of(members.begin(), members.end(),
                     [&](SubchainId id) { return period_limits(app.graph, id).exact.has_value(); });
}

void check_shared_core(Check& check, std::size_t number, const Members& members) {
  const CorePlan& core = check.plan.cores[number];
  check_slots(check, number, members);
  const bool fixed = core.frames == graph::FrameMode::kFixed;
  if (!fixed && needs_fixed_frames(check.app, members)) {
    check.problem(Check::core_key(number, "frames"), "frames are fixed where the app says so or a rate is exact");
  }
  if (fixed) return;
  for (const SubchainId id : members) {
    const Millis min = check.plan.subchains[id.index()].share * period_limits(check.app.graph, id).min;
    if (at_least(core.frame_min, min)) continue;
    check.problem(Check::core_key(number, "frame_min_ms"),
                  fmt::format("frames of {} ms would break a max_rate of subchain {}, which needs {} ms",
                              core.frame_min.count(), check.app.graph.subchain(id).name, min.count()));
  }
}

void check_share(Check& check, SubchainId id) {
  const SubchainPlan& subchain = check.plan.subchains[id.index()];
  const Millis cost = check.costs_of(id).subchain_total(check.app.graph, id);
  check.expect(check.subchain_key(id, "slice_ms"), subchain.slice, subchain.share * cost, "share x compute time");
  check.expect(check.subchain_key(id, "wait_ms"), subchain.wait, check.costs.subchain_wait(check.app.graph, id),
               "what its nodes wait");
  if (subchain.every.has_value() == takes_batches(check.app.graph, id)) {
    check.problem(check.subchain_key(id, "every"),
                  subchain.every ? "a queue node's rate is an average: it has none" : "only a queue node goes without");
  } else if (subchain.every) {
    check.expect(check.subchain_key(id, "share"), subchain.share, 1.0 / *subchain.every, "a run every n frames");
  }
}

void check_sharing_subchain(Check& check, SubchainId id) {
  const SubchainPlan& subchain = check.plan.subchains[id.index()];
  const CorePlan& core = check.plan.cores[static_cast<std::size_t>(subchain.cores.front())];
  const model::SharedTiming timing = model::shared_core({core.frame, subchain.share, subchain.slice, subchain.wait},
                                                        period_limits(check.app.graph, id).exact.has_value());
  const bool waits = subchain.wait > Millis{0};
  check.expect(check.subchain_key(id, "period_ms"), subchain.period, timing.period,
               waits ? "frame / share, and what a run that waits needs" : "frame / share");
  check.expect(check.subchain_key(id, "execution_ms"), subchain.execution, timing.execution,
               waits ? "frame / share, and what a run that waits needs" : "the period");
  if (subchain.threads != 1) check.problem(check.subchain_key(id, "threads"), "on a shared core there is but 1");
  const Millis min = to_millis(check.app.scheduler.min_slice);
  if (!at_least(subchain.slice, min) && subchain.share < 1.0 - kTolerance) {
    check.problem(check.subchain_key(id, "slice_ms"),
                  fmt::format("{} ms are less than min_slice ({} ms), and not a whole run either",
                              subchain.slice.count(), min.count()));
  }
}

void check_owning_subchain(Check& check, SubchainId id) {
  const SubchainPlan& subchain = check.plan.subchains[id.index()];
  const int cores = static_cast<int>(subchain.cores.size());
  if (subchain.threads > cores) {
    check.problem(check.subchain_key(id, "threads"),
                  fmt::format("{} threads a node are more than its {} cores", subchain.threads, cores));
    return;
  }
  const model::OwnedCores owned =
      model::owned_cores_with(check.app.graph, id, check.costs_of(id), cores, subchain.threads, check.plan.slack);
  const PeriodLimits limits = period_limits(check.app.graph, id);
  check.expect(check.subchain_key(id, "share"), subchain.share, 1.0, "owning its cores");
  check.expect(check.subchain_key(id, "execution_ms"), subchain.execution, owned.execution,
               "what its nodes cost and wait");
  if (!limits.exact) {
    check.expect(check.subchain_key(id, "period_ms"), subchain.period, std::max(owned.period, limits.min),
                 "what its nodes cost and wait on its cores, or a max_rate,");
  } else if (!at_least(subchain.period, owned.period)) {
    check.problem(check.subchain_key(id, "period_ms"),
                  fmt::format("{} ms are too short: its nodes need {} ms on its cores", subchain.period.count(),
                              owned.period.count()));
  }
}

// A subchain that keeps a phase to a clock of others has a period that its ticks can tell.
void check_clock(Check& check, std::size_t number, std::size_t index) {
  const Member& member = check.plan.cores[number].members[index];
  if (!member.clock) return;
  const std::string key = Check::member_key(number, index, "clock");
  if (member.pause || member.after) return check.problem(key, "it is not triggered by time");
  if (ticks_of(member.period, to_millis(*check.app.graph.node(*member.clock).period))) return;
  check.problem(key, fmt::format("its period ({} ms) is no multiple of the clock's", member.period.count()));
}

// Every member once, the highest priority first, each triggered in one way.
void check_priorities(Check& check, std::size_t number, const Members& members) {
  const CorePlan& core = check.plan.cores[number];
  check_no_frame(check, number);
  Members planned;
  for (const Member& member : core.members) planned.push_back(member.subchain);
  std::sort(planned.begin(), planned.end());
  if (planned != members) {
    check.problem(Check::core_key(number, "members"),
                  fmt::format("the members of this core must be: {}", names_of(check.app.graph, members)));
    return;
  }
  for (std::size_t i = 0; i < core.members.size(); ++i) {
    const Member& member = core.members[i];
    const auto key = [&](const char* field) { return Check::member_key(number, i, field); };
    if (member.priority != static_cast<int>(core.members.size() - i)) {
      check.problem(key("priority"), fmt::format("{} stands where {} belongs: they go down to 1", member.priority,
                                                 core.members.size() - i));
    }
    if (member.pause && member.after) check.problem(key("after"), "it is triggered after a pause, or by another");
    if (!member.after && member.period <= Millis{0}) {
      check.problem(key("period_ms"), "what is triggered by time needs a period");
    }
    if ((member.pause || member.after) ? member.phase > Millis{0}
                                       : member.phase > Millis{0} && member.phase >= member.period) {
      check.problem(key("phase_ms"), fmt::format("{} ms are no phase of its triggers", member.phase.count()));
    }
    check_clock(check, number, i);
    const PeriodLimits limits = period_limits(check.app.graph, member.subchain);
    if (limits.exact && (member.pause || member.after)) {
      check.problem(key("period_ms"), "an exact rate is triggered by time");
    }
    if (!at_least(member.budget, check.costs_of(member.subchain).subchain_total(check.app.graph, member.subchain))) {
      check.problem(key("budget_ms"),
                    fmt::format("{} ms are less than the compute time of a run", member.budget.count()));
    }
  }
}

// No subchain waits for outputs that wait for its own.
void check_following(Check& check, SubchainId id) {
  SubchainId at = id;
  for (std::size_t steps = 0; steps <= check.plan.subchains.size(); ++steps) {
    const Member* const member = member_of(check.plan, at);
    if (member == nullptr || !member->after || member->after->subchain() == nullptr) return;
    at = *member->after->subchain();
    if (at != id) continue;
    check.problem(check.subchain_key(id, "after"), "it is triggered by outputs that its own outputs trigger");
    return;
  }
}

void check_member_timing(Check& check, SubchainId id, const std::vector<Promise>& promises) {
  const SubchainPlan& subchain = check.plan.subchains[id.index()];
  const Promise& promised = promises[id.index()];
  check.expect(check.subchain_key(id, "share"), subchain.share, 1.0, "a fixed priority");
  check.expect(check.subchain_key(id, "period_ms"), subchain.period, promised.period, "response-time analysis");
  check.expect(check.subchain_key(id, "execution_ms"), subchain.execution, promised.execution,
               "response-time analysis");
  if (subchain.threads != 1) check.problem(check.subchain_key(id, "threads"), "with a fixed priority there is but 1");
}

}  // namespace

void check_cores(Check& check) {
  const std::vector<Members> members = members_by_core(check.plan);
  const auto kind = [&](std::size_t core) { return check.app.kind_of(static_cast<int>(core)); };
  std::vector<char> sharing(check.app.kinds(), 0);
  const std::vector<std::vector<SubchainId>> joined = check.app.joined_by_exclusion();
  for (std::size_t core = 0; core < members.size(); ++core) {
    const bool could_part = std::any_of(members[core].begin(), members[core].end(), [&](SubchainId id) {
      const SubchainId first = members[core].front();
      const std::vector<SubchainId>& with = joined[first.index()];
      return id != first && std::find(with.begin(), with.end(), id) == with.end();
    });
    if (could_part) sharing[kind(core)] = 1;
  }
  for (std::size_t i = 0; i < check.plan.subchains.size(); ++i) {
    const std::vector<int>& cores = check.plan.subchains[i].cores;
    if (check.app.kind_of(cores.front()) == check.app.kind_of(cores.back())) continue;
    check.problem(check.subchain_key(SubchainId(i), "cores"), "it owns cores of different kinds");
  }
  for (std::size_t core = 0; core < members.size(); ++core) {
    // A core of another kind may be too slow to be of use.
    if (members[core].empty() && sharing[kind(core)]) {
      check.problem(fmt::format("cores[{}]", core), "no subchain has this core, while others are shared");
    }
    if (members[core].size() < 2 && check.plan.cores[core].form == Form::kFrames) continue;
    for (const SubchainId id : members[core]) {
      if (check.plan.subchains[id.index()].cores.size() == 1) continue;
      check.problem(check.subchain_key(id, "cores"),
                    fmt::format("it has several cores, and shares core {}: it may own cores or share one", core));
    }
  }
}

void check_frames(Check& check) {
  const std::vector<Members> members = members_by_core(check.plan);
  for (std::size_t core = 0; core < members.size(); ++core) {
    if (in_frames(check.plan.cores[core], members[core])) {
      check_shared_core(check, core, members[core]);
    } else {
      check_no_frame(check, core);
    }
  }
}

bool check_members(Check& check) {
  const std::size_t before = check.problems();
  const std::vector<Members> members = members_by_core(check.plan);
  for (std::size_t core = 0; core < members.size(); ++core) {
    if (check.plan.cores[core].form == Form::kPriorities) {
      check_priorities(check, core, members[core]);
    } else if (!check.plan.cores[core].members.empty()) {
      check.problem(Check::core_key(core, "members"), "a core in frames has slots, not members");
    }
  }
  if (check.problems() > before) return false;
  for (std::size_t i = 0; i < check.plan.subchains.size(); ++i) check_following(check, SubchainId(i));
  return check.problems() == before;
}

void check_groups(Check& check) {
  const std::vector<Members> members = members_by_core(check.plan);
  const std::optional<std::vector<Promise>> promises = promise(check.plan, check.app, check.costs);
  if (!promises) {
    check.problem("cores", "on a core with fixed priorities, subchains leave those below them no time");
    return;
  }
  for (std::size_t i = 0; i < check.plan.subchains.size(); ++i) {
    const SubchainId id{i};
    check_share(check, id);
    const auto core = static_cast<std::size_t>(check.plan.subchains[i].cores.front());
    if (check.plan.cores[core].form == Form::kPriorities) {
      check_member_timing(check, id, *promises);
    } else if (in_frames(check.plan.cores[core], members[core])) {
      check_sharing_subchain(check, id);
    } else {
      check_owning_subchain(check, id);
    }
  }
}

}  // namespace ctn::plan
