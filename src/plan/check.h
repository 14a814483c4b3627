// What the parts of `validate` have in common. Internal to the module.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "plan/plan.h"

namespace ctn::plan {

// Equal to one part in 1 / kTolerance, or, near 0, to a millionth of a nanosecond.
bool same(double a, double b);
inline bool same(Millis a, Millis b) { return same(a.count(), b.count()); }
inline bool at_least(Millis a, Millis b) { return a >= b || same(a, b); }

// Collects what is wrong with a plan, each under its path in the plan's JSON.
class Check {
 public:
  Check(const Plan& checked, const graph::App& for_app, const model::CostTable& at_costs)
      : plan(checked), app(for_app), costs(at_costs), by_kind_(model::costs_by_kind(for_app, at_costs)) {}

  void problem(std::string key, std::string what);
  // Notes a problem unless the figure is what the formulas say it must be.
  void expect(const std::string& key, double planned, double must_be, const char* why);
  void expect(const std::string& key, Millis planned, Millis must_be, const char* why) {
    expect(key, planned.count(), must_be.count(), why);
  }

  // What nodes cost on the cores that a subchain has. Precondition: it has some, all of one kind.
  const model::CostTable& costs_of(SubchainId id) const {
    return by_kind_[app.kind_of(plan.subchains[id.index()].cores.front())];
  }

  bool ok() const { return problems_.empty(); }
  std::size_t problems() const { return problems_.size(); }
  std::vector<Problem> take_problems() { return std::move(problems_); }

  std::string subchain_key(SubchainId id, const char* field) const;
  static std::string core_key(std::size_t core, const char* field);
  static std::string member_key(std::size_t core, std::size_t member, const char* field);
  static std::string slot_key(std::size_t core, std::size_t slot, const char* field);

  const Plan& plan;
  const graph::App& app;
  const model::CostTable& costs;

 private:
  const std::vector<model::CostTable> by_kind_;
  std::vector<Problem> problems_;
};

// The steps, in their order; each relies on those before having found nothing.
void check_shape(Check& check, int core_count);
void check_cores(Check& check);    // which subchain has which core
void check_frames(Check& check);   // slots and frames of shared cores; others have none
bool check_members(Check& check);  // fixed priorities; false: what is promised cannot be computed
void check_groups(Check& check);   // owned and shared cores by their formulas
void check_rates(Check& check);    // caps and exact rates
// That batches are as large as the plan's own periods make them. `costs`: of runs without items.
void check_batches(Check& check, const model::CostTable& costs);
void check_promises(Check& check);  // chains, nodes, objective, relaxed bounds

}  // namespace ctn::plan
