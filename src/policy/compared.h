// Policies of others, which Catan is compared with (planner/compared/): chain-aware priorities, reservations, and the
// two methods that assign rates. Each decides once and is not asked again.
//
// They go by compute times, which somebody who uses them has measured before: `NAME:FILE` takes them from a cost file,
// whatever the situation says. Plain `NAME` takes those of the situation, which is right where they are known (a
// simulation), and refused where they are not (Policy::needs_costs).
//
// Units: in the types. Thread safety: as policy.h says.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "planner/compared/rate_plan.h"
#include "policy/hand_set.h"

namespace ctn::policy {

// Where compute times come from.
class GivenCosts {
 public:
  // `file` may be empty: from the situation.
  explicit GivenCosts(std::string file) : file_(std::move(file)) {}

  bool missing() const { return file_.empty(); }
  Result<model::CostTable> of(const Situation& situation) const;
  std::string name(const std::string& policy) const { return missing() ? policy : policy + ":" + file_; }

 private:
  std::string file_;
};

// "picas": rates set by hand, subchains kept together by chains, a fixed priority a node (planner/compared/picas.h).
class PicasPolicy : public HandSetPolicy {
 public:
  explicit PicasPolicy(const GivenCosts& costs) : HandSetPolicy(costs.name("picas")), costs_(costs) {}
  bool raises() const override { return true; }
  bool needs_costs() const override { return costs_.missing(); }
  Result<Decision> decide(const Situation& situation) const override;

 private:
  GivenCosts costs_;
};

// "deadline": rates set by hand, a reservation a node, on all CPUs (planner/compared/reservations.h). Rates are lowered
// by the least common factor where the reservations would not be admitted.
class DeadlinePolicy : public HandSetPolicy {
 public:
  explicit DeadlinePolicy(const GivenCosts& costs) : HandSetPolicy(costs.name("deadline")), costs_(costs) {}
  bool raises() const override { return true; }
  bool needs_costs() const override { return costs_.missing(); }
  Result<Decision> decide(const Situation& situation) const override;

 private:
  GivenCosts costs_;
};

// "davare", "verucchi": rates, cores and fixed priorities of subchains by one of the methods. Of what the second says
// of who waits for whom nothing is enforced but what follows from rates and priorities.
class RatesPolicy : public Policy {
 public:
  using Method = Result<planner::RatePlan> (*)(const graph::App&, const model::CostTable&, const planner::RateRequest&);

  RatesPolicy(const std::string& name, Method method, const GivenCosts& costs)
      : Policy(costs.name(name)), method_(method), costs_(costs) {}
  bool follows_plan() const override { return false; }
  bool raises() const override { return true; }
  bool needs_costs() const override { return costs_.missing(); }
  Result<Decision> decide(const Situation& situation) const override;

 private:
  Method method_;
  GivenCosts costs_;
};

// "picas", "deadline:COSTS.yaml" and so on; null: it is none of these.
std::shared_ptr<const Policy> make_compared_policy(std::string_view text);

}  // namespace ctn::policy
