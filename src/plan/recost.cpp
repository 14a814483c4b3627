#include "plan/recost.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "model/formulas.h"
#include "plan/batches.h"
#include "plan/limits.h"
#include "plan/predict.h"
#include "plan/promise.h"

namespace ctn::plan {
namespace {

class Recosting {
 public:
  Recosting(const Plan& plan, const graph::App& app, const model::CostTable& costs)
      : plan_(plan), app_(app), by_kind_(model::costs_by_kind(app, costs)) {}

  std::optional<Plan> run(const model::CostTable& costs) {
    for (std::size_t i = 0; i < plan_.subchains.size(); ++i) slice(SubchainId(i));
    for (CorePlan& core : plan_.cores) {
      if (!core.slots.empty() && !lay_out(core)) return std::nullopt;
    }
    for (std::size_t i = 0; i < plan_.subchains.size(); ++i) {
      if (member_of(plan_, SubchainId(i)) == nullptr && !time(SubchainId(i))) return std::nullopt;
    }
    if (!time_members(costs)) return std::nullopt;
    plan_.quality = Quality::kFeasible;
    plan_.gap = 1.0;
    plan_.expected.reset();
    fill_predictions(plan_, app_, costs);
    return std::move(plan_);
  }

 private:
  const model::CostTable& costs_of(const SubchainPlan& subchain) const {
    return by_kind_[app_.kind_of(subchain.cores.front())];
  }
  CorePlan& core_of(const SubchainPlan& subchain) {
    return plan_.cores[static_cast<std::size_t>(subchain.cores.front())];
  }

  void slice(SubchainId id) {
    SubchainPlan& subchain = plan_.subchains[id.index()];
    subchain.slice = subchain.share * costs_of(subchain).subchain_total(app_.graph, id);
    subchain.wait = costs_of(subchain).subchain_wait(app_.graph, id);
  }

  bool lay_out(CorePlan& core) const {
    Millis offset{0};
    bool exact = false;
    for (Slot& slot : core.slots) {
      slot.offset = offset;
      slot.slice = plan_.subchains[slot.subchain.index()].slice;
      offset += slot.slice;
      exact = exact || period_limits(app_.graph, slot.subchain).exact;
    }
    const double usable = 1.0 - plan_.slack;
    const Millis needed = offset / usable;
    if (exact && needed > core.frame * (1.0 + kTolerance)) return false;
    const Millis frame = exact ? core.frame : std::max(needed, min_frame(app_.graph, plan_, core));
    core.idle = std::max(Millis{0}, frame * usable - offset);
    core.frame = (offset + core.idle) / usable;
    return true;
  }

  bool time(SubchainId id) {
    SubchainPlan& subchain = plan_.subchains[id.index()];
    if (shares_core(plan_, subchain)) {
      const model::SharedTiming timing =
          model::shared_core({core_of(subchain).frame, subchain.share, subchain.slice, subchain.wait},
                             period_limits(app_.graph, id).exact.has_value());
      subchain.period = timing.period;
      subchain.execution = timing.execution;
      return true;
    }
    const model::OwnedCores owned = model::owned_cores_with(
        app_.graph, id, costs_of(subchain), static_cast<int>(subchain.cores.size()), subchain.threads, plan_.slack);
    const PeriodLimits limits = period_limits(app_.graph, id);
    subchain.execution = owned.execution;
    if (!limits.exact) {
      subchain.period = std::max(owned.period, limits.min);
      return true;
    }
    subchain.period = *limits.exact;
    return owned.period <= *limits.exact * (1.0 + kTolerance);
  }

  // Owners come first, since members may follow them.
  bool time_members(const model::CostTable& costs) {
    const std::optional<std::vector<Promise>> promises = promise(plan_, app_, costs);
    if (!promises) return false;
    for (CorePlan& core : plan_.cores) {
      for (Member& member : core.members) {
        SubchainPlan& subchain = plan_.subchains[member.subchain.index()];
        const Promise& promised = (*promises)[member.subchain.index()];
        subchain.period = promised.period;
        subchain.execution = promised.execution;
        member.budget = std::max(member.budget, subchain.slice);
        const PeriodLimits limits = period_limits(app_.graph, member.subchain);
        if (limits.exact && promised.period > *limits.exact * (1.0 + kTolerance)) return false;
      }
    }
    return true;
  }

  Plan plan_;
  const graph::App& app_;
  const std::vector<model::CostTable> by_kind_;
};

}  // namespace

std::optional<Plan> recost(const Plan& plan, const graph::App& app, const model::CostTable& costs) {
  return settle_batches(app, costs, [&](const std::vector<Batch>& batches) {
    const model::CostTable of_runs = at_batches(costs, batches, app.graph);
    Plan with_batches = plan;
    with_batches.batches = batches;
    return Recosting(with_batches, app, of_runs).run(of_runs);
  });
}

}  // namespace ctn::plan
