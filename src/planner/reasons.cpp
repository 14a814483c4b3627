#include "planner/reasons.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "plan/limits.h"
#include "plan/predict.h"

namespace ctn::planner {
namespace {

bool same(double a, double b, double tolerance) {
  return std::abs(a - b) <= tolerance * std::max(std::abs(a), std::abs(b));
}

bool concerns(const Group& bound, std::size_t subchain) {
  for (const Form& form : bound.forms) {
    for (const Coefficient& c : form.coefficients) {
      if (static_cast<std::size_t>(c.subchain) == subchain) return true;
    }
  }
  return false;
}

class Reasons {
 public:
  Reasons(const graph::App& app, const model::CostTable& costs, const Instance& instance, const plan::Plan& plan,
          const std::vector<BoundCost>& bounds)
      : app_(app),
        costs_(model::costs_by_kind(app, costs)),
        instance_(instance),
        plan_(plan),
        bounds_(bounds),
        timings_(timings_of(instance, plan)) {}

  Reason of(std::size_t i) const {
    const plan::SubchainPlan& entry = plan_.subchains[i];
    Reason reason;
    reason.cost = run_time(i);
    for (const std::size_t other : rivals(i)) reason.others.emplace_back(other);
    if (entry.period.count() <= 0.0) {
      reason.binding = Binding::kNothing;
      return reason;
    }
    reason.core_part = on(i).cost / entry.period.count() / instance_.usable / static_cast<double>(entry.cores.size());
    if (own_rate(i, reason)) return reason;
    if (reason.others.empty()) {
      of_owner(i, reason);
    } else {
      of_sharer(i, reason);
    }
    return reason;
  }

 private:
  std::size_t kind_of(std::size_t i) const { return app_.kind_of(plan_.subchains[i].cores.front()); }
  // On the cores that it has.
  const OnKind& on(std::size_t i) const { return instance_.members[i].on[kind_of(i)]; }

  Millis node_time(std::size_t i, NodeId node) const {
    return costs_[kind_of(i)][node].with_threads(plan_.subchains[i].threads, app_.graph.node(node).max_threads);
  }

  Millis run_time(std::size_t i) const {
    Millis sum{0};
    for (const NodeId node : app_.graph.subchain(SubchainId(i)).nodes) sum += node_time(i, node);
    return sum;
  }

  std::vector<std::size_t> rivals(std::size_t i) const {
    std::vector<std::size_t> found;
    for (std::size_t j = 0; j < plan_.subchains.size(); ++j) {
      if (j != i && plan_.subchains[j].cores.front() == plan_.subchains[i].cores.front()) found.push_back(j);
    }
    return found;
  }

  bool own_rate(std::size_t i, Reason& reason) const {
    const plan::PeriodLimits limits = plan::period_limits(app_.graph, SubchainId(i));
    const double period = timings_[i].period;
    if (limits.exact) {
      reason.binding = Binding::kExactRate;
      reason.node = limits.exact_of;
      return true;
    }
    if (limits.min.count() <= 0.0 || !same(period, limits.min.count(), plan::kTolerance)) return false;
    reason.binding = Binding::kRateCap;
    reason.node = limits.capped;
    return true;
  }

  void of_owner(std::size_t i, Reason& reason) const {
    const plan::SubchainPlan& entry = plan_.subchains[i];
    const std::vector<NodeId>& nodes = app_.graph.subchain(SubchainId(i)).nodes;
    const NodeId longest = *std::max_element(nodes.begin(), nodes.end(),
                                             [&](NodeId a, NodeId b) { return node_time(i, a) < node_time(i, b); });
    const int pipelines = std::max(1, static_cast<int>(entry.cores.size()) / entry.threads);
    reason.binding = Binding::kCost;
    if (node_time(i, longest) < reason.cost / pipelines * (1.0 - plan::kTolerance)) return;
    reason.binding = Binding::kLongestNode;
    reason.node = longest;
    reason.cost = node_time(i, longest);
  }

  void of_sharer(std::size_t i, Reason& reason) const {
    if (waits_for_rate(i, reason)) return;
    if (would_gain_by_smaller_slice(i)) {
      reason.binding = Binding::kMinSlice;
      return;
    }
    for (std::size_t b = 0; b < bounds_.size(); ++b) {
      if (bounds_[b].binds && keeps_fast(b, i)) reason.bounds.push_back(bounds_[b].key);
    }
    if (!reason.bounds.empty()) {
      reason.binding = Binding::kBound;
      return;
    }
    for (std::size_t b = 0; b < bounds_.size(); ++b) {
      if (bounds_[b].binds) note_if_slowed(b, i, reason);
    }
    reason.binding = reason.bounds.empty() ? Binding::kCore : Binding::kOtherBound;
  }

  // A core has idle time on purpose only to keep somebody to a rate.
  bool waits_for_rate(std::size_t i, Reason& reason) const {
    const plan::CorePlan& core = core_of(i);
    if (core.idle <= core.frame * plan::kTolerance) return false;
    std::optional<std::size_t> through;
    for (const std::size_t j : rivals(i)) {
      if (is_at_rate(j) && (!through || holds_frame(j) > holds_frame(*through))) through = j;
    }
    if (!through) return false;
    reason.binding = Binding::kOtherRate;
    reason.through = SubchainId(*through);
    return true;
  }

  // How surely one that is at its rate keeps the frame from being shorter. At its least slice: for sure. Else a whole
  // number of frames more would have to fit, and a queue node could do with any shorter slice.
  int holds_frame(std::size_t i) const {
    const Member& member = instance_.members[i];
    if (1.0 / plan_.subchains[i].share >= on(i).most_every * (1.0 - kMet)) return 2;
    return member.queue ? 0 : 1;
  }

  bool is_at_rate(std::size_t i) const {
    const Member& member = instance_.members[i];
    return member.exact_period > 0.0 || same(timings_[i].period, member.min_period, plan::kTolerance);
  }

  const plan::CorePlan& core_of(std::size_t i) const {
    return plan_.cores[static_cast<std::size_t>(plan_.subchains[i].cores.front())];
  }

  // Whether it is at its least slice, and a run spread over one frame more, all else as it is, would be better.
  bool would_gain_by_smaller_slice(std::size_t i) const {
    const Member& member = instance_.members[i];
    const plan::SubchainPlan& entry = plan_.subchains[i];
    if (member.queue) return 1.0 / entry.share >= on(i).most_every * (1.0 - kMet);
    if (*entry.every < on(i).most_every) return false;
    const plan::CorePlan& core = core_of(i);
    const int every = *entry.every + 1;
    const double saved = (entry.slice.count() - on(i).cost / every) / instance_.usable;
    const double frame = std::max(core.frame.count() - saved, plan::min_frame(app_.graph, plan_, core).count());
    std::vector<Timing> timings = timings_;
    for (const std::size_t j : rivals(i)) {
      timings[j].period *= frame / core.frame.count();
      timings[j].execution = timings[j].period;
    }
    timings[i] = {frame * every, frame * every};
    return objective_of(instance_, timings) < objective_of(instance_, timings_) * (1.0 - plan::kTolerance) &&
           factor_of(instance_, timings) <= factor_of(instance_, timings_) * (1.0 + plan::kTolerance);
  }

  // Its period without the bound, in parts of the planned one.
  double period_without(std::size_t b, std::size_t i) const {
    const auto& without = bounds_[b].without.plan;
    return without ? without->subchains[i].period.count() / timings_[i].period : 1.0;
  }

  bool keeps_fast(std::size_t b, std::size_t i) const {
    if (!concerns(instance_.bounds[b], i)) return false;
    const double without = period_without(b, i);
    return without > 1.0 + kMet || (bounds_[b].met && without > 1.0 - kMet);
  }

  void note_if_slowed(std::size_t b, std::size_t i, Reason& reason) const {
    const double without = period_without(b, i);
    if (without > 1.0 + kMet || (without > 1.0 - kMet && !bounds_[b].met)) return;
    // The one that gains most by the bound.
    std::optional<std::size_t> through;
    for (const std::size_t j : rivals(i)) {
      if (!concerns(instance_.bounds[b], j)) continue;
      if (!through || period_without(b, j) > period_without(b, *through)) through = j;
    }
    if (!through) return;
    reason.bounds.push_back(bounds_[b].key);
    if (!reason.through) reason.through = SubchainId(*through);
  }

  const graph::App& app_;
  const std::vector<model::CostTable> costs_;  // by kind of cores
  const Instance& instance_;
  const plan::Plan& plan_;
  const std::vector<BoundCost>& bounds_;
  const std::vector<Timing> timings_;
};

}  // namespace

std::vector<Timing> timings_of(const Instance& instance, const plan::Plan& plan) {
  std::vector<Timing> timings;
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const plan::SubchainPlan& subchain = plan.subchains[i];
    if (subchain.wait == Millis{0}) {
      timings.push_back({subchain.period.count(), subchain.execution.count()});
    } else if (plan::shares_core(plan, subchain)) {
      const plan::CorePlan& core = plan.cores[static_cast<std::size_t>(subchain.cores.front())];
      const double period = (core.frame / subchain.share).count();
      timings.push_back({period, period});
    } else {
      const int kind = instance.kind_of_core(subchain.cores.front());
      const Owned& owned = instance.members[i].on_kind(kind).owned[subchain.cores.size() - 1];
      timings.push_back({owned.period, owned.execution});
    }
  }
  return timings;
}

std::vector<Reason> reasons_of(const graph::App& app, const model::CostTable& costs, const Instance& instance,
                               const plan::Plan& plan, const std::vector<BoundCost>& bounds) {
  const Reasons reasons(app, costs, instance, plan, bounds);
  std::vector<Reason> all;
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) all.push_back(reasons.of(i));
  return all;
}

}  // namespace ctn::planner
