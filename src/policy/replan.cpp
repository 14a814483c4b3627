#include "policy/replan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "plan/limits.h"
#include "plan/predict.h"
#include "plan/recost.h"

namespace ctn::policy {
namespace {

bool differs(double before, double after, double threshold) {
  return std::abs(after - before) > threshold * std::max(before, after);
}
bool differs(Millis before, Millis after) { return differs(before.count(), after.count(), kSwapThreshold); }

bool paced_differently(const plan::Plan& current, const plan::Plan& candidate, std::size_t index) {
  const plan::SubchainPlan& before = current.subchains[index];
  const plan::SubchainPlan& after = candidate.subchains[index];
  if (differs(before.period, after.period) || differs(before.execution, after.execution)) return true;
  if (!current.expected || !candidate.expected) return current.expected.has_value() != candidate.expected.has_value();
  return differs(current.expected->subchains[index].period, candidate.expected->subchains[index].period) ||
         differs(current.expected->subchains[index].execution, candidate.expected->subchains[index].execution);
}

// What is said of relaxed bounds is what is planned, so it has to change when they do: where a bound gives way that
// held, by more than noise, or none has to give way any more.
bool relaxing_changed(const plan::Plan& current, const plan::Plan& current_now) {
  if (current.relax_factor > 1.0 && current_now.relax_factor <= 1.0) return true;
  if (current.relax_factor <= 1.0) return current_now.relax_factor > 1.0 + kSwapThreshold;
  return differs(current.relax_factor, current_now.relax_factor, kStaleThreshold);
}

// Runs have outgrown their slices, or what was promised is not so any more.
bool out_of_date(const plan::Plan& current, const plan::Plan& current_now) {
  for (std::size_t index = 0; index < current.subchains.size(); ++index) {
    if (!plan::shares_core(current, current.subchains[index])) continue;
    const Millis slice = current.subchains[index].slice;
    if (current_now.subchains[index].slice > slice * (1.0 + kOverrunThreshold)) return true;
  }
  return relaxing_changed(current, current_now) || differs(current.objective, current_now.objective, kStaleThreshold);
}

bool does_better(const plan::Plan& current_now, const plan::Plan& candidate) {
  if (differs(current_now.relax_factor, candidate.relax_factor, kSwapThreshold)) {
    return candidate.relax_factor < current_now.relax_factor;
  }
  return candidate.objective < current_now.objective * (1.0 - kSwapThreshold);
}

}  // namespace

bool worth_swapping(const plan::Plan& current, const std::optional<plan::Plan>& current_now,
                    const plan::Plan& candidate) {
  if (!current_now || does_better(*current_now, candidate) || out_of_date(current, *current_now)) return true;
  for (std::size_t index = 0; index < candidate.subchains.size(); ++index) {
    if (plan::shares_core(current, current.subchains[index])) continue;
    if (current.subchains[index].cores != candidate.subchains[index].cores) continue;
    if (paced_differently(current, candidate, index)) return true;
  }
  return false;
}

dispatch::Pacing pacing_of(const graph::App& app, const plan::Plan& plan, SubchainId subchain) {
  const Millis execution = plan.subchains[subchain.index()].execution;
  const Nanos hang_after = std::max(kShortestHang, to_nanos(execution * kHangMultiple));
  return dispatch::pacing_of_owner(app, plan, subchain, hang_after);
}

const char* to_string(PlanReason reason) {
  switch (reason) {
    case PlanReason::kBootstrap:
      return "bootstrap";
    case PlanReason::kStatic:
      return "static";
    case PlanReason::kMeasured:
      return "measured";
    case PlanReason::kPeriodic:
      return "periodic";
    case PlanReason::kChange:
      return "change";
    case PlanReason::kPower:
      return "power";
    case PlanReason::kCpus:
      return "cpus";
    case PlanReason::kAsked:
      return "asked";
  }
  return "";
}

Incumbent::Incumbent(const plan::Plan& plan, PlanReason why, const graph::App& app, const model::CostTable& costs,
                     const model::CostTable& typical)
    : plan_(plan), unconditional_(is_unconditional(why)) {
  if (unconditional_) return;
  const graph::App planned = plan::as_planned(app, plan);
  now_ = plan::recost(plan, planned, costs);
  if (now_) now_->expected = plan::expect(*now_, planned, typical);
}

bool Incumbent::yields_to(const plan::Plan& candidate) const {
  return unconditional_ || worth_swapping(plan_, now_, candidate);
}

Result<std::optional<Decision>> replacement(const Policy& policy, const Situation& situation,
                                            const Decision& in_force) {
  if (!in_force.plan || policy.judges()) return policy.decide_again(situation, in_force);
  const Incumbent incumbent(*in_force.plan, situation.why, situation.app, situation.costs, situation.typical);
  Result<std::optional<Decision>> decision = policy.decide_again(situation, in_force);
  if (decision && *decision && !incumbent.yields_to(*(*decision)->plan)) decision->reset();
  return decision;
}

void ReplanClock::changed(PlanReason what) {
  if (!change_) change_ = what;
}

std::optional<PlanReason> ReplanClock::due(TimePoint now, std::size_t known, bool more) const {
  if (!measured_plan_made_) return now >= due_ && known > 0 ? std::optional(PlanReason::kMeasured) : std::nullopt;
  const bool spaced = now >= last_ + std::min(kChangeSpacing, interval_);
  if (spaced && budget_.allows(now, PlanningBudget::Urgency::kChange)) {
    if (known > known_) return PlanReason::kMeasured;
    if (change_) return change_;
  }
  if ((now >= due_ || (more && spaced)) && budget_.allows(now, PlanningBudget::Urgency::kRoutine))
    return PlanReason::kPeriodic;
  return std::nullopt;
}

void ReplanClock::made(TimePoint now, PlanReason why, Nanos cpu, std::size_t known) {
  budget_.spend(now, cpu);
  last_ = now;
  known_ = known;
  change_.reset();
  periodic_ = why == PlanReason::kPeriodic ? periodic_ + 1 : 0;
  if (why == PlanReason::kMeasured) measured_plan_made_ = true;
  if (measured_plan_made_) due_ = now + interval_;
}

}  // namespace ctn::policy
