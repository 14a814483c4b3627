#include "plan/promise.h"

#include <algorithm>
#include <cmath>

#include "model/formulas.h"
#include "model/unscheduled.h"
#include "plan/batches.h"
#include "plan/limits.h"
#include "plan/trigger_line.h"

namespace ctn::plan {
namespace {

// Steps of the exact analysis before it is left to the line.
constexpr int kSteps = 64;
// A trigger that comes a hair before the end of a period (rounding) is the next period's.
constexpr double kRounding = 1e-9;
constexpr Millis kMinSpacing{graph::kShortestPeriod};
constexpr int kRounds = 1000;

class Analysis {
 public:
  Analysis(const Plan& plan, const graph::App& app, const model::CostTable& costs)
      : plan_(plan),
        app_(app),
        by_kind_(model::costs_by_kind(app, at_batches(costs, plan.batches, app.graph))),
        unscheduled_waits_(model::unscheduled_waits(app, by_kind_, first_cores(plan.subchains), plan.cores.size())),
        unscheduled_(plan.subchains.size()),
        promises_(plan.subchains.size()),
        cost_(plan.subchains.size()),
        wait_(plan.subchains.size()),
        spacing_(plan.subchains.size()),
        sooner_(plan.subchains.size()),
        jitter_(plan.subchains.size()) {
    for (std::size_t i = 0; i < plan_.subchains.size(); ++i) {
      const SubchainId id(i);
      const model::CostTable& there = by_kind_[app_.kind_of(plan_.subchains[i].cores.front())];
      cost_[i] = there.subchain_total(app_.graph, id) / (1.0 - plan_.slack);
      wait_[i] = there.subchain_wait(app_.graph, id);
      const std::size_t kind = app_.kind_of(plan_.subchains[i].cores.front());
      const Member* const member = member_of(plan_, id);
      unscheduled_[i] = model::unscheduled_loads(app_, by_kind_, unscheduled_waits_, id, kind, plan_.slack,
                                                 member != nullptr ? triggered_right_away_by(*member) : std::nullopt);
    }
    for (std::size_t i = 0; i < plan_.subchains.size(); ++i) know_spacing(SubchainId(i));
  }

  std::optional<std::vector<Promise>> run() {
    if (!find_responses()) return std::nullopt;
    for (std::size_t i = 0; i < plan_.subchains.size(); ++i) {
      promises_[i].spacing = spacing_[i];
      if (member_of(plan_, SubchainId(i)) != nullptr) promises_[i].period = period_of(SubchainId(i));
    }
    return std::move(promises_);
  }

 private:
  // T: between two triggers; of its leaders first. Where its period is longer than outputs are apart, that holds it
  // back, and one trigger comes so much sooner than it allows (plan::held_apart()).
  void know_spacing(SubchainId id) {
    Millis& spacing = spacing_[id.index()];
    if (spacing > Millis{0}) return;
    const Member* const member = member_of(plan_, id);
    spacing = member != nullptr ? member->period : plan_.subchains[id.index()].period;
    if (member != nullptr && member->after) {
      const SubchainId* const leader = member->after->subchain();
      if (leader != nullptr) know_spacing(*leader);
      const Millis apart = outputs_apart(*member->after, leader != nullptr ? spacing_[leader->index()] : Millis{0});
      if (member->period > apart * (1.0 + kRounding)) sooner_[id.index()] = member->period;
      spacing = std::max(member->period, apart);
    } else if (member != nullptr && member->pause) {
      spacing = std::max(member->period, cost_[id.index()] + *member->pause);
    }
    spacing = std::max(spacing, kMinSpacing);
  }

  // Every so-many-th output of the leader, at least; where that is a subchain, its runs come `runs_apart`.
  Millis outputs_apart(const After& after, Millis runs_apart) const {
    if (const NodeId* const leader = after.node())
      return to_millis(app_.graph.node(*leader).outputs_apart()) * after.every;
    const NodeId tail = app_.graph.subchain(*after.subchain()).tail();
    return std::max(runs_apart, to_millis(app_.graph.output_period_up_to(tail))) * after.every;
  }

  // The unscheduled node each or every so-many-th output of which triggers it, and which it never keeps waiting for its
  // period. None: there is none.
  std::optional<NodeId> triggered_right_away_by(const Member& member) const {
    if (!member.after || member.after->node() == nullptr) return std::nullopt;
    const NodeId leader = *member.after->node();
    const Millis late = model::output_lateness(app_.graph, by_kind_.front(), unscheduled_waits_, leader, plan_.slack);
    const Millis closest = outputs_apart(*member.after, Millis{0}) - late;
    return member.period <= closest ? std::optional(leader) : std::nullopt;
  }

  // So many times as long on average, where not every run of the leader gives an output.
  double runs_per_output(const After& after) const {
    if (const NodeId* const leader = after.node()) return by_kind_.front().runs_per_output(*leader);
    const graph::Subchain& leader = app_.graph.subchain(*after.subchain());
    return by_kind_.front().runs_per_output(leader, leader.tail());
  }

  // Where output periods let one of its runs give an output, and not another.
  Millis outputs_late(SubchainId id, Millis run) const {
    const graph::Subchain& subchain = app_.graph.subchain(id);
    if (app_.graph.output_period_up_to(subchain.tail()) == Nanos{0}) return Millis{0};
    return model::outputs_late(app_.graph, by_kind_.front(), subchain, period_of(id), run);
  }

  // J, at the responses found so far.
  Millis jitter_of(const Member& member) const {
    const std::size_t i = member.subchain.index();
    const Millis behind = std::max(promises_[i].execution - spacing_[i], Millis{0});
    if (!member.after) return member.pause ? Millis{0} : behind;
    const Millis late = behind + sooner_[i];
    // An output may come as late as the leader's run may end, and as early as a run costs nothing.
    if (const NodeId* const leader = member.after->node()) {
      return late + model::output_lateness(app_.graph, by_kind_.front(), unscheduled_waits_, *leader, plan_.slack);
    }
    const std::size_t leader = member.after->subchain()->index();
    const bool owns = member_of(plan_, *member.after->subchain()) == nullptr;
    const Millis run = owns ? plan_.subchains[leader].execution : promises_[leader].execution;
    return late + std::max(run, outputs_late(*member.after->subchain(), run)) + jitter_[leader];
  }

  // Calls `use` for each that holds its triggers apart, however early outputs come. What is triggered by a pause is
  // held back until its period is over.
  template <class Use>
  static void for_each_hold(const Member& member, Use use) {
    if (!member.after) {
      if (member.pause && member.period >= kMinSpacing) use(1, member.period);
      return;
    }
    for (const Hold& hold : holds_of_follower(to_nanos(member.period))) {
      if (to_millis(hold.apart) >= kMinSpacing) use(hold.at_once, to_millis(hold.apart));
    }
  }

  static Millis silence_limit(const Member& member) { return to_millis(plan::silence_limit(to_nanos(member.period))); }

  // Two ways to reckon with runs above that wait, each of which holds for all of them.
  enum class Waits {
    kBringRunsCloser,  // what a run has left after its wait comes close to the next
    kAreWork,          // as if it had the core meanwhile
  };
  Millis demand_of(const Member& member, Waits waits) const {
    const std::size_t i = member.subchain.index();
    return waits == Waits::kAreWork ? cost_[i] + wait_[i] : cost_[i];
  }
  // How much closer together than its triggers runs of the member may use the core.
  Millis carried_over(const Member& member, Waits waits) const {
    const std::size_t i = member.subchain.index();
    if (kept_away(member.subchain)) return std::max(promises_[i].execution - demand_of(member, waits), Millis{0});
    if (wait_[i] == Millis{0} || waits == Waits::kAreWork) return Millis{0};
    return std::max(promises_[i].execution - cost_[i], Millis{0});
  }

  // How often the member may be triggered within `window`, at most: as a fraction (the line), or in whole numbers.
  TriggerLine line_of(const Member& member, Millis window, Waits waits) const {
    const std::size_t i = member.subchain.index();
    const bool paused = !member.after && member.pause && member.period >= kMinSpacing;
    return trigger_line({.spacing = spacing_[i].count(),
                         .sooner = jitter_[i].count(),
                         .carried = carried_over(member, waits).count(),
                         .held = member.after ? to_nanos(member.period) : Nanos{0},
                         .held_back = paused ? member.period.count() : 0.0},
                        window.count());
  }
  double triggers_within(const Member& member, Millis window, Waits waits) const {
    const std::size_t i = member.subchain.index();
    const Millis reach = window + carried_over(member, waits);
    double least = std::ceil((reach + jitter_[i]) / spacing_[i] - kRounding);
    for_each_hold(member, [&](int at_once, Millis apart) {
      least = std::min(least, at_once - 1 + std::ceil(reach / apart - kRounding));
    });
    return least;
  }

  // How often that member may come while a run of the one at `rank` is pending, if it goes back to outputs of one that
  // is not above that; none: it does not.
  std::optional<int> turns_of(const CorePlan& core, const Member& member, std::size_t rank) const {
    if (wait_[core.members[rank].subchain.index()] > Millis{0}) return std::nullopt;
    if (blocked_below(core, rank) > Millis{0} || excludes_unscheduled(core, rank)) return std::nullopt;
    const Member* at = &member;
    for (int turns = 1; at->after && at->after->subchain() != nullptr; ++turns) {
      if (wait_[at->subchain.index()] > Millis{0}) return std::nullopt;
      const auto leader = std::find_if(core.members.begin(), core.members.end(),
                                       [&](const Member& each) { return each.subchain == *at->after->subchain(); });
      if (leader == core.members.end()) return std::nullopt;
      if (leader - core.members.begin() >= static_cast<std::ptrdiff_t>(rank)) return turns;
      at = &*leader;
    }
    return std::nullopt;
  }

  // From below, until nothing changes: jitters grow with responses, and responses with jitters.
  bool find_responses() {
    for (int round = 0; round < kRounds; ++round) {
      bool changed = false;
      for (const CorePlan& core : plan_.cores) {
        for (std::size_t above = 0; above < core.members.size(); ++above) {
          const Member& member = core.members[above];
          const std::optional<Millis> response = response_of(core, above);
          if (!response) return false;
          Millis& known = promises_[member.subchain.index()].execution;
          changed = changed || *response > known * (1.0 + kRounding);
          known = std::max(known, *response);
          jitter_[member.subchain.index()] = jitter_of(member);
        }
      }
      if (!changed) return true;
    }
    return false;
  }

  // What a run takes where nothing is above it, and nothing of an exclusive group is on another core.
  Millis alone(const CorePlan& core, std::size_t rank) const {
    const std::size_t i = core.members[rank].subchain.index();
    return cost_[i] + wait_[i] + blocked_below(core, rank);
  }

  // --- Exclusive groups ---

  // Whether a run may leave its core since another has its exclusive group that waits or is on another core.
  bool kept_away(SubchainId subchain) const {
    for (const NodeId node : app_.graph.subchain(subchain).nodes) {
      const std::optional<std::size_t> exclusion = app_.graph.node(node).exclusive;
      if (!exclusion) continue;
      for (const NodeId other : app_.exclusive[*exclusion].nodes) {
        const std::optional<SubchainId> of = app_.graph.node(other).subchain;
        if (of == subchain) continue;
        if (!of || by_kind_.front().wait(other) > Millis{0}) return true;
        if (plan_.subchains[of->index()].cores != plan_.subchains[subchain.index()].cores) return true;
      }
    }
    return false;
  }

  // Its position among the members of the core; none: it is not among them.
  std::optional<std::size_t> position_of(const CorePlan& core, NodeId node) const {
    const std::optional<SubchainId> of = app_.graph.node(node).subchain;
    const auto member = std::find_if(core.members.begin(), core.members.end(),
                                     [&](const Member& each) { return of && each.subchain == *of; });
    if (member == core.members.end()) return std::nullopt;
    return static_cast<std::size_t>(member - core.members.begin());
  }
  // Calls `use` for each node of another subchain, or unscheduled, that is in an exclusive group with one of the
  // member's.
  template <class Use>
  void for_each_excluded(const CorePlan& core, std::size_t rank, Use use) const {
    const SubchainId own = core.members[rank].subchain;
    for (const NodeId node : app_.graph.subchain(own).nodes) {
      const std::optional<std::size_t> exclusion = app_.graph.node(node).exclusive;
      if (!exclusion) continue;
      for (const NodeId other : app_.exclusive[*exclusion].nodes) {
        if (app_.graph.node(other).subchain != own) use(other);
      }
    }
  }
  // How long a run of the node keeps its exclusive group, on the core of that member.
  Millis hold_of(const Member& member, NodeId node) const {
    const model::CostTable& costs = by_kind_[app_.kind_of(plan_.subchains[member.subchain.index()].cores.front())];
    return costs[node].single_thread() / (1.0 - plan_.slack) + costs.wait(node);
  }
  bool excludes_unscheduled(const CorePlan& core, std::size_t rank) const {
    bool any = false;
    for_each_excluded(core, rank, [&](NodeId other) { any = any || app_.graph.node(other).unscheduled; });
    return any;
  }
  // For runs below it that had an exclusive group before, which it, one above it or an unscheduled node wants.
  Millis blocked_below(const CorePlan& core, std::size_t rank) const {
    if (app_.exclusive.empty()) return Millis{0};
    const Member& member = core.members[rank];
    Millis sum{0};
    // Where it never leaves its core before it has ended, none below it begins a run meanwhile.
    const bool leaves = kept_away(member.subchain) || wait_[member.subchain.index()] > Millis{0};
    const auto times = leaves ? 1 + app_.graph.subchain(member.subchain).nodes.size() : 1;
    for (const graph::ExclusiveGroup& group : app_.exclusive) {
      bool wanted = false;
      Millis longest{0};
      for (const NodeId node : group.nodes) {
        const std::optional<std::size_t> at = position_of(core, node);
        wanted = wanted || app_.graph.node(node).unscheduled || (at && *at <= rank);
        if (at && *at > rank) longest = std::max(longest, hold_of(member, node));
      }
      if (wanted) sum += static_cast<double>(times) * longest;
    }
    return sum;
  }
  // By those that are elsewhere: as often as they come in the window, and once more.
  TriggerLine blocked_elsewhere(const CorePlan& core, std::size_t rank, Millis window) const {
    TriggerLine sum;
    for_each_excluded(core, rank, [&](NodeId other) {
      const std::optional<SubchainId> of = app_.graph.node(other).subchain;
      if (!of || position_of(core, other)) return;
      const Member* const member = member_of(plan_, *of);
      const SubchainPlan& planned = plan_.subchains[of->index()];
      const Millis run = member != nullptr ? promises_[of->index()].execution : planned.execution;
      const Millis apart = member != nullptr ? spacing_[of->index()] : std::max(planned.period, kMinSpacing);
      const TriggerLine line =
          member != nullptr ? line_of(*member, window, Waits::kBringRunsCloser) : TriggerLine{1.0, 1.0 / apart.count()};
      sum.at_once += run.count() * (1.0 + line.at_once);
      sum.rate += run.count() * line.rate;
    });
    return sum;
  }
  // By unscheduled nodes: those that are above it, and those that have an exclusive group of its own.
  Millis by_unscheduled(SubchainId subchain, Millis window) const {
    Millis sum{0};
    for (const model::UnscheduledLoad& load : unscheduled_[subchain.index()]) {
      sum += load.runs_within(window) * load.run;
    }
    return sum;
  }

  // Whether one above it may wait while it holds an exclusive group.
  bool held_by_waiting(const CorePlan& core, std::size_t rank) const {
    bool any = false;
    for_each_excluded(core, rank, [&](NodeId other) {
      const std::optional<std::size_t> at = position_of(core, other);
      any = any || (at && *at < rank && by_kind_.front().wait(other) > Millis{0});
    });
    return any;
  }

  // Of the member with `above` members above it.
  std::optional<Millis> response_of(const CorePlan& core, std::size_t above) const {
    const std::optional<Millis> closer = response_of(core, above, Waits::kBringRunsCloser);
    const bool any = std::any_of(core.members.begin(), core.members.begin() + static_cast<std::ptrdiff_t>(above),
                                 [&](const Member& each) { return wait_[each.subchain.index()] > Millis{0}; });
    if (!any) return closer;
    if (held_by_waiting(core, above)) return response_of(core, above, Waits::kAreWork);
    const std::optional<Millis> work = response_of(core, above, Waits::kAreWork);
    return closer && work ? std::min(closer, work) : closer ? closer : work;
  }

  // `without`: as if that one above it never ran; null: none.
  std::optional<Millis> response_of(const CorePlan& core, std::size_t above, Waits waits,
                                    const Member* without = nullptr) const {
    const Millis own = alone(core, above);
    std::vector<std::optional<int>> turns;
    for (std::size_t j = 0; j < above; ++j) turns.push_back(turns_of(core, core.members[j], above));
    Millis response = own;
    for (int step = 0; step < kSteps; ++step) {
      const TriggerLine elsewhere = blocked_elsewhere(core, above, response);
      Millis longer = own + Millis{elsewhere.within(response.count())};
      longer += by_unscheduled(core.members[above].subchain, response);
      for (std::size_t j = 0; j < above; ++j) {
        if (&core.members[j] == without) continue;
        double triggers = triggers_within(core.members[j], response, waits);
        if (turns[j] && response < silence_limit(core.members[j])) triggers = std::min<double>(triggers, *turns[j]);
        longer += triggers * demand_of(core.members[j], waits);
      }
      if (longer > kLongestPromise) return std::nullopt;
      if (longer <= response * (1.0 + kRounding)) return response;
      response = longer;
    }
    return by_lines(core, above, response, waits, without);
  }

  // Valid wherever the lines are chosen, tightest where they are chosen near what comes out.
  std::optional<Millis> by_lines(const CorePlan& core, std::size_t above, Millis near, Waits waits,
                                 const Member* without) const {
    const TriggerLine elsewhere = blocked_elsewhere(core, above, near);
    const TriggerLine unscheduled = plan::line_of(unscheduled_[core.members[above].subchain.index()]);
    Millis sum = alone(core, above) + Millis{elsewhere.at_once + unscheduled.at_once};
    double used = elsewhere.rate + unscheduled.rate;
    for (std::size_t j = 0; j < above; ++j) {
      if (&core.members[j] == without) continue;
      const TriggerLine line = line_of(core.members[j], near, waits);
      const Millis cost = demand_of(core.members[j], waits);
      sum += cost * line.at_once;
      used += cost.count() * line.rate;
    }
    if (used >= 1.0 || sum / (1.0 - used) > kLongestPromise) return std::nullopt;
    return sum / (1.0 - used);
  }

  Millis period_of(SubchainId id) const { return std::max(planned_period_of(id), kMinSpacing); }
  Millis planned_period_of(SubchainId id) const {
    const Member* const member = member_of(plan_, id);
    if (member == nullptr) return plan_.subchains[id.index()].period;
    const Millis response = promises_[id.index()].execution;
    if (member->after) return std::max({member->period, triggers_apart(*member), response});
    return std::max(member->period, response + member->pause.value_or(Millis{0}));
  }

  // Of a follower, on average over many. Its own run is in one of the runs of its leader from one trigger to the next.
  Millis triggers_apart(const Member& member) const {
    const After& after = *member.after;
    const SubchainId* const leader = after.subchain();
    const Millis apart = outputs_apart(after, leader != nullptr ? period_of(*leader) : Millis{0});
    const double per_output = runs_per_output(after);
    const std::optional<Millis> alone = leader != nullptr ? leaders_period_without(member) : std::nullopt;
    if (!alone) return apart * per_output;
    const double runs = after.every * per_output;
    return std::max(outputs_apart(after, *alone) * per_output, period_of(*leader) + (runs - 1.0) * *alone);
  }

  // The period of its leader where that does not meet it. None: it may meet it at any time, or that makes no
  // difference. Above a leader on its core that waits for a pause after each run, it has ended before that one has run
  // again.
  std::optional<Millis> leaders_period_without(const Member& member) const {
    const SubchainId id = *member.after->subchain();
    for (const CorePlan& core : plan_.cores) {
      for (std::size_t rank = 0; rank < core.members.size(); ++rank) {
        const Member& leader = core.members[rank];
        if (leader.subchain != id || !leader.pause || turns_of(core, member, rank) != 1) continue;
        if (promises_[id.index()].execution >= silence_limit(member)) return std::nullopt;
        const std::optional<Millis> response = response_of(core, rank, Waits::kBringRunsCloser, &member);
        if (!response) return std::nullopt;
        return std::max(leader.period, *response + *leader.pause);
      }
    }
    return std::nullopt;
  }

  const Plan& plan_;
  const graph::App& app_;
  const std::vector<model::CostTable> by_kind_;
  const std::vector<Millis> unscheduled_waits_;
  std::vector<std::vector<model::UnscheduledLoad>> unscheduled_;  // by subchain
  std::vector<Promise> promises_;
  std::vector<Millis> cost_;
  std::vector<Millis> wait_;
  std::vector<Millis> spacing_;
  std::vector<Millis> sooner_;
  std::vector<Millis> jitter_;
};

}  // namespace

std::optional<std::vector<Promise>> promise(const Plan& plan, const graph::App& app, const model::CostTable& costs) {
  return Analysis(plan, app, costs).run();
}

}  // namespace ctn::plan
