#include "policy/hand_set.h"

#include <fmt/format.h>

#include "plan/limits.h"
#include "plan/validate.h"
#include "policy/levels.h"
#include "policy/replan.h"

namespace ctn::policy {

Result<std::vector<Rate>> HandSetPolicy::rates(const graph::App& app, std::optional<Rate> of_sources) const {
  std::vector<Rate> rates;
  std::vector<Problem> problems;
  for (const graph::Subchain& subchain : app.graph.subchains()) {
    const graph::Node& head = app.graph.node(subchain.head());
    if (of_sources && head.predecessors.empty()) {
      rates.push_back(*of_sources);
    } else if (head.fallback_rate) {
      rates.push_back(*head.fallback_rate);
    } else {
      problems.push_back(
          {{},
           fmt::format("nodes.{}.fallback_rate", head.name),
           fmt::format("is not set, and scheduler '{}' needs a rate for subchain {}", name(), subchain.name),
           fmt::format("write {}: {{ fallback_rate: 10Hz }}", head.name)});
    }
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return rates;
}

Decision HandSetPolicy::at(const std::vector<Rate>& rates, const os::CpuSet& cpus) {
  Decision decision;
  decision.assignment.cores.resize(cpus.size());
  for (const Rate rate : rates) {
    SubchainPlace& place = decision.assignment.places.emplace_back();
    place.cpus = cpus;
    place.pacing.period = to_nanos(rate.period());
  }
  return decision;
}

Result<Decision> DefaultPolicy::decide(const Situation& situation) const {
  const Result<std::vector<Rate>> set = rates(situation.app);
  if (!set) return set.error();
  return at(*set, situation.cpus);
}

Result<Decision> RatePolicy::decide(const Situation& situation) const {
  const Result<std::vector<Rate>> set = rates(situation.app, rate_);
  if (!set) return set.error();
  return at(*set, situation.cpus);
}

Result<Decision> PlannedRatesPolicy::decide(const Situation& situation) const {
  const graph::App app = plan::as_planned(situation.app, plan_);
  if (Status valid = plan::validate_layout(plan_, app, static_cast<int>(plan_.cores.size())); !valid) {
    return valid.error();
  }
  std::vector<Rate> rates;
  for (std::size_t index = 0; index < plan_.subchains.size(); ++index) {
    rates.push_back(Rate::every(plan::usual_timing(plan_, SubchainId(index)).period));
  }
  return at(rates, situation.cpus);
}

Result<Decision> FifoPolicy::decide(const Situation& situation) const {
  const Result<std::vector<Rate>> set = rates(situation.app);
  if (!set) return set.error();
  const std::vector<SubchainId>& priority = situation.app.steal.priority;
  const auto count = static_cast<int>(priority.size());
  Decision decision = at(*set, situation.cpus);
  if (Status fits = rise_above(decision, priority.size(), "subchains"); !fits) return fits.error();
  for (int rank = 0; rank < count; ++rank) {
    SubchainPlace& place = decision.assignment.places[priority[static_cast<std::size_t>(count - 1 - rank)].index()];
    place.level = os::fixed_level(rank);
    place.pacing.hang_after = kShortestHang;
  }
  return decision;
}

}  // namespace ctn::policy
