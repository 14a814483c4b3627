#include "export/in_force.h"

#include <fmt/format.h>

#include <utility>

#include "plan/json.h"

namespace ctn::exports {

Result<InForce> InForce::at_start(const record::Reader& record) {
  auto plans = record.plans();
  if (!plans) return plans.error();
  auto changes = record.app_changes();
  if (!changes) return changes.error();
  return InForce(record, std::move(*plans), std::move(*changes));
}

InForce::InForce(const record::Reader& record, std::vector<record::PlanChange> plans,
                 std::vector<record::AppChange> changes)
    : record_(&record), plans_(std::move(plans)), changes_(std::move(changes)) {
  for (const graph::Term& term : record.app().objective) {
    const bool of_chain = term.metric == graph::Metric::kResponseTime;
    chains_.push_back(of_chain ? std::optional(bounds_.size()) : std::nullopt);
    if (of_chain) bounds_.push_back(term.max ? std::optional(to_millis(*term.max).count()) : std::nullopt);
  }
}

Status InForce::move_to(TimePoint now) {
  for (; next_change_ < changes_.size() && changes_[next_change_].at <= now; ++next_change_) {
    const record::AppChange& change = changes_[next_change_];
    if (change.what != record::AppChange::What::kMax) continue;
    if (const auto chain = chains_[change.item]) bounds_[*chain] = change.after;
  }
  const std::size_t before = next_plan_;
  while (next_plan_ < plans_.size() && plans_[next_plan_].at <= now) ++next_plan_;
  if (next_plan_ == before) return Done{};
  auto plan =
      plan::from_json(plans_[next_plan_ - 1].json, record_->app(), fmt::format("plan {} of the record", next_plan_));
  if (!plan) return plan.error();
  plan_ = std::move(*plan);
  plan::PredictedMeans means(record_->app(), now);
  means.in_force(now, *plan_);
  predictions_ = means.current();
  return Done{};
}

std::optional<plan::ChainPrediction> InForce::predicted(std::size_t chain) const {
  return predictions_ ? predictions_->chains[chain] : std::nullopt;
}

}  // namespace ctn::exports
