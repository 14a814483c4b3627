// What was in force at each time of a record: the plan, what it promised of each chain, and the chain's bound.
//
// Units: milliseconds where the names say so. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "plan/plan.h"
#include "plan/predicted_means.h"
#include "record/reader.h"

namespace ctn::exports {

class InForce {
 public:
  // As of the start of the record, which outlives it.
  static Result<InForce> at_start(const record::Reader& record);

  // Moves on to a later time. kCaller: a plan that cannot be read.
  Status move_to(TimePoint now);

  // The plan in force; none: there is no plan yet.
  const std::optional<plan::Plan>& plan() const { return plan_; }
  std::optional<plan::ChainPrediction> predicted(std::size_t chain) const;
  std::optional<double> bound_ms(std::size_t chain) const { return bounds_[chain]; }

  // All plans and changes, in the order of the record.
  const std::vector<record::PlanChange>& plans() const { return plans_; }
  const std::vector<record::AppChange>& changes() const { return changes_; }
  // The chain that a term of the objective is, counted among its response times; none: the term is a period.
  std::optional<std::size_t> chain_of(std::size_t term) const { return chains_[term]; }
  std::size_t chains() const { return bounds_.size(); }

 private:
  InForce(const record::Reader& record, std::vector<record::PlanChange> plans, std::vector<record::AppChange> changes);

  const record::Reader* record_;
  std::vector<record::PlanChange> plans_;
  std::vector<record::AppChange> changes_;
  std::vector<std::optional<std::size_t>> chains_;  // by term
  std::size_t next_plan_ = 0;
  std::size_t next_change_ = 0;
  std::optional<plan::Plan> plan_;
  std::optional<plan::Predictions> predictions_;
  std::vector<std::optional<double>> bounds_;  // by chain
};

}  // namespace ctn::exports
