#include "plan/predict.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "model/evaluate.h"
#include "model/unscheduled.h"
#include "plan/batches.h"
#include "plan/limits.h"
#include "plan/promise.h"

namespace ctn::plan {
namespace {

// What is known of subchains by themselves, from the plan alone.
class Timings {
 public:
  Timings(const graph::App& app, const model::CostTable& costs, std::span<const SubchainPlan> subchains,
          std::span<const CorePlan> cores)
      : app_(app), costs_(costs), subchains_(subchains), cores_(cores), members_(subchains.size(), nullptr) {
    for (const CorePlan& core : cores) {
      for (const Member& member : core.members) members_[member.subchain.index()] = &member;
    }
    unscheduled_waits_ =
        model::unscheduled_waits(app, model::costs_by_kind(app, costs), first_cores(subchains), cores.size());
  }

  // Of unscheduled nodes, by NodeId (model/unscheduled.h).
  const std::vector<Millis>& unscheduled_waits() const { return unscheduled_waits_; }

  model::SubchainTiming of(SubchainId id) const {
    const SubchainPlan& planned = subchains_[id.index()];
    model::SubchainTiming timing{planned.period, planned.execution};
    const Member* const member = members_[id.index()];
    if (member == nullptr) {
      timing.longest_gap = longest_gap(cores_, planned);
      return timing;
    }
    if (member->after) {
      timing.longest_gap = timing.period + outputs_late(*member->after, members_.size());
      if (may_be_held_back(*member) || may_come_too_close(*member, planned)) return timing;
      if (const SubchainId* const leader = member->after->subchain()) timing.follows = *leader;
      if (const NodeId* const leader = member->after->node()) timing.follows_node = *leader;
    } else if (!member->pause && timing.period <= member->period * (1.0 + kTolerance)) {
      timing.by_phase = {.grid = {to_nanos(member->phase), to_nanos(member->period)},
                         .clock = member->clock,
                         .core = planned.cores.front(),
                         .priority = member->priority,
                         .runs_through = planned.wait == Millis{0}};
    }
    return timing;
  }

  std::vector<model::SubchainTiming> all() const {
    std::vector<model::SubchainTiming> timings;
    timings.reserve(subchains_.size());
    for (std::size_t i = 0; i < subchains_.size(); ++i) timings.push_back(of(SubchainId(i)));
    return timings;
  }

 private:
  // By how much more than so many periods outputs may be apart: the one late, the next as early as a run costs nothing.
  // `steps`: no more leaders than that are asked, since plans that are checked may go in circles.
  Millis outputs_late(const After& after, std::size_t steps) const {
    if (const NodeId* const leader = after.node())
      return model::output_lateness(app_.graph, costs_, unscheduled_waits_, *leader, 0.0);
    const SubchainId leader = *after.subchain();
    const SubchainPlan& planned = subchains_[leader.index()];
    const Millis left_out =
        model::outputs_late(app_.graph, costs_, app_.graph.subchain(leader), planned.period, planned.execution);
    const Millis run = std::max(planned.execution, left_out);
    const Member* const member = members_[leader.index()];
    if (member == nullptr || steps == 0) return run;
    // It waits for its own end, but where it is held back longer.
    if (member->pause) {
      const Millis held = std::clamp(after.every * (member->period - *member->pause), Millis{0}, planned.execution);
      return std::max(held, left_out);
    }
    return member->after ? outputs_late(*member->after, steps - 1) + run : run;
  }

  // Whether outputs may come so close that it is not triggered by each that counts, but later, by its period.
  bool may_be_held_back(const Member& member) const {
    return member.period > member.after->every * shortest_apart(*member.after) * (1.0 + kTolerance);
  }

  // Whether an unscheduled node may give an output so soon after a late one that it is held back, or that the run for
  // the one before is under way.
  bool may_come_too_close(const Member& member, const SubchainPlan& planned) const {
    if (member.after->node() == nullptr) return false;
    const Millis closest = member.after->every * shortest_apart(*member.after) - outputs_late(*member.after, 0);
    return closest < std::max(planned.execution, to_millis(held_apart(to_nanos(member.period))));
  }

  Millis shortest_apart(const After& after) const {
    if (const NodeId* const leader = after.node()) return to_millis(app_.graph.node(*leader).outputs_apart());
    const SubchainId leader = *after.subchain();
    if (const Member* const member = members_[leader.index()]) return member->period;
    const SubchainPlan& planned = subchains_[leader.index()];
    if (planned.share > 1.0) return planned.slice / planned.share;  // one right after the other
    return has_fixed_frames(app_, cores_, planned) ? planned.period : period_limits(app_.graph, leader).min;
  }

  const graph::App& app_;
  const model::CostTable& costs_;
  const std::span<const SubchainPlan> subchains_;
  const std::span<const CorePlan> cores_;
  std::vector<const Member*> members_;  // by subchain; null: it has no fixed priority
  std::vector<Millis> unscheduled_waits_;
};

}  // namespace

Prediction predict(const graph::App& app, const model::CostTable& costs, std::span<const SubchainPlan> subchains,
                   std::span<const CorePlan> cores) {
  const Timings known(app, costs, subchains, cores);
  const std::vector<model::SubchainTiming> timings = known.all();
  Prediction prediction;
  std::vector<Millis> of_term;  // the figure that the term weighs
  for (const graph::Term& term : app.objective) {
    if (term.metric == graph::Metric::kPeriod) {
      of_term.push_back(model::evaluate_period(app.graph, term.path.front(), timings));
      prediction.nodes.push_back({term.path.front(), of_term.back(), term.weight});
    } else {
      const model::ChainTiming timing =
          model::evaluate_chain(app.graph, term.path, costs, timings, known.unscheduled_waits());
      of_term.push_back(timing.response);
      prediction.chains.push_back({term.path, timing.response, timing.latency, timing.period, term.weight});
    }
    prediction.objective += term.weight * of_term.back().count();
  }
  for (const SoftBound& bound : soft_bounds(app)) {
    const Millis planned = bound.term ? of_term[*bound.term] : model::evaluate_period(app.graph, *bound.node, timings);
    if (planned <= bound.asked * (1.0 + kTolerance)) continue;
    prediction.relaxed.push_back({bound.key, bound.asked, planned});
    prediction.relax_factor = std::max(prediction.relax_factor, planned / bound.asked);
  }
  return prediction;
}

void fill_predictions(Plan& plan, const graph::App& app, const model::CostTable& costs) {
  const model::CostTable of_runs = at_batches(costs, plan.batches, app.graph);
  Prediction prediction = predict(app, of_runs, plan.subchains, plan.cores);
  plan.chains = std::move(prediction.chains);
  plan.nodes = std::move(prediction.nodes);
  plan.objective = prediction.objective;
  plan.relax_factor = prediction.relax_factor;
  plan.relaxed = std::move(prediction.relaxed);
}

namespace {

class Expecting {
 public:
  Expecting(const Plan& plan, const graph::App& app, const model::CostTable& typical)
      : plan_(plan),
        app_(app),
        typical_(model::costs_by_kind(app, typical)),
        by_priority_(promise(plan, app, typical)) {}

  Expectation::Timing of(SubchainId id) const {
    const SubchainPlan& planned = plan_.subchains[id.index()];
    const CorePlan& core = plan_.cores[static_cast<std::size_t>(planned.cores.front())];
    if (member_of(plan_, id) != nullptr) return of_member(id, planned);
    return shares_core(plan_, planned) ? of_sharer(id, planned, core) : of_owner(id, planned);
  }

 private:
  const model::CostTable& costs_of(const SubchainPlan& planned) const {
    return typical_[app_.kind_of(planned.cores.front())];
  }

  Expectation::Timing of_owner(SubchainId id, const SubchainPlan& planned) const {
    const model::OwnedCores owned = model::owned_cores_with(
        app_.graph, id, costs_of(planned), static_cast<int>(planned.cores.size()), planned.threads, plan_.slack);
    const Millis execution = std::min(owned.execution, planned.execution);
    const PeriodLimits limits = period_limits(app_.graph, id);
    if (has_fixed_frames(app_, plan_.cores, planned) || limits.exact) return {planned.period, execution};
    return {std::min(planned.period, std::max(owned.period, limits.min)), execution};
  }

  Expectation::Timing of_member(SubchainId id, const SubchainPlan& planned) const {
    if (!by_priority_) return {planned.period, planned.execution};
    const Promise& typical = (*by_priority_)[id.index()];
    return {std::min(planned.period, typical.period), std::min(planned.execution, typical.execution)};
  }

  // A frame takes what its slots use of it; a run goes on in as many slots as its cost fills.
  Expectation::Timing of_sharer(SubchainId id, const SubchainPlan& planned, const CorePlan& core) const {
    const Millis cost = std::min(costs_of(planned).subchain_total(app_.graph, id), planned.slice / planned.share);
    const Millis frame = frame_of(core);
    const double slots = planned.slice.count() > 0.0 ? std::ceil(cost / planned.slice - kTolerance) : 1.0;
    const double before_last = std::max(0.0, slots - 1.0);
    const Millis work = planned.share >= 1.0 ? cost : before_last * frame + (cost - before_last * planned.slice);
    const Millis execution = work + costs_of(planned).subchain_wait(app_.graph, id);
    Millis period = std::max(frame / planned.share, period_limits(app_.graph, id).min);
    if (planned.wait > Millis{0}) period = std::max(period, execution);
    return {std::min(planned.period, period), std::min(planned.execution, execution)};
  }

  // A subchain that is deferred uses what its cap leaves it; how much of a frame that is depends on the frame.
  Millis frame_of(const CorePlan& core) const {
    if (core.frames == graph::FrameMode::kFixed) return core.frame;
    const Millis min = std::min(min_elastic_frame(app_.graph, plan_, core), core.frame);
    Millis frame = core.frame;
    constexpr int kRounds = 4;
    for (int round = 0; round < kRounds; ++round) {
      Millis used{0};
      for (const Slot& slot : core.slots) used += used_of(slot, frame);
      frame = std::clamp(used / (1.0 - plan_.slack), min, core.frame);
    }
    return frame;
  }

  Millis used_of(const Slot& slot, Millis frame) const {
    const SubchainPlan& planned = plan_.subchains[slot.subchain.index()];
    const Millis cost = costs_of(planned).subchain_total(app_.graph, slot.subchain);
    const Millis min = period_limits(app_.graph, slot.subchain).min;
    const double runs = min.count() > 0.0 ? std::min(planned.share, frame / min) : planned.share;
    return std::min(slot.slice, runs * cost);
  }

  const Plan& plan_;
  const graph::App& app_;
  const std::vector<model::CostTable> typical_;  // by kind of cores
  const std::optional<std::vector<Promise>> by_priority_;
};

}  // namespace

Expectation expect(const Plan& plan, const graph::App& app, const model::CostTable& costs) {
  const model::CostTable typical = at_mean_batches(plan, app.graph, costs);
  const Expecting expecting(plan, app, typical);
  Expectation expected;
  std::vector<SubchainPlan> retimed = plan.subchains;
  for (std::size_t i = 0; i < retimed.size(); ++i) {
    expected.subchains.push_back(expecting.of(SubchainId(i)));
    retimed[i].period = expected.subchains.back().period;
    retimed[i].execution = expected.subchains.back().execution;
  }
  const Prediction prediction = predict(app, typical, retimed, plan.cores);
  expected.objective = prediction.objective;
  for (const ChainPlan& chain : prediction.chains) {
    expected.chains.push_back({chain.response, chain.latency, chain.period});
  }
  return expected;
}

}  // namespace ctn::plan
