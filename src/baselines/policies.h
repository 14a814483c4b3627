// Policies of others, which Catan is compared with: chain-aware priorities, reservations, and the two methods that
// assign rates. Each decides once and is not asked again.
//
// They go by compute times, which their user has measured before. Compute times that are given count, whatever the
// situation says; without any, the situation's do, which must be real ones then (Policy::needs_costs), as they are in a
// simulation.
//
// Units: in the types. Thread safety: as policy/policy.h says.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "baselines/rate_plan.h"
#include "baselines/reservations.h"
#include "model/cost.h"
#include "policy/hand_set.h"
#include "policy/policy.h"
#include "sim/reservation.h"

namespace ctn::baselines {

using GivenCosts = std::optional<model::CostTable>;

// "picas": rates set by hand, subchains kept together by chains, a fixed priority a node (picas.h).
class PicasPolicy : public policy::HandSetPolicy {
 public:
  PicasPolicy(std::string name, GivenCosts costs) : HandSetPolicy(std::move(name)), costs_(std::move(costs)) {}
  bool raises() const override { return true; }
  bool needs_costs() const override { return !costs_; }
  Result<policy::Decision> decide(const policy::Situation& situation) const override;

 private:
  GivenCosts costs_;
};

// "deadline": rates set by hand, a reservation a node, on all CPUs (reservations.h). Rates are lowered by the smallest
// common factor where the reservations would not be admitted. What decide() says is without the reservations, which
// only a simulation can have: by reserve().
class DeadlinePolicy : public policy::HandSetPolicy {
 public:
  DeadlinePolicy(std::string name, GivenCosts costs) : HandSetPolicy(std::move(name)), costs_(std::move(costs)) {}
  bool raises() const override { return true; }
  bool needs_costs() const override { return !costs_; }
  Result<policy::Decision> decide(const policy::Situation& situation) const override;
  Result<std::vector<sim::Reservation>> reserve(const policy::Situation& situation) const;

 private:
  Reservations reservations_for(const policy::Situation& situation, const std::vector<Rate>& rates) const;

  GivenCosts costs_;
};

// "davare", "verucchi": rates, cores and fixed priorities of subchains by one of the methods. Of what the second says
// of runs that wait for one another nothing is enforced but what follows from rates and priorities.
class RatesPolicy : public policy::Policy {
 public:
  using Method = Result<RatePlan> (*)(const graph::App&, const model::CostTable&, const RateRequest&);

  RatesPolicy(std::string name, Method method, GivenCosts costs)
      : Policy(std::move(name)), method_(method), costs_(std::move(costs)) {}
  bool follows_plan() const override { return false; }
  bool raises() const override { return true; }
  bool needs_costs() const override { return !costs_; }
  Result<policy::Decision> decide(const policy::Situation& situation) const override;

 private:
  Method method_;
  GivenCosts costs_;
};

struct Baseline {
  std::shared_ptr<const policy::Policy> policy;
  sim::Reserve reserve{};  // where the policy needs it: it can only be simulated
};

// "picas", "deadline", "davare", "verucchi".
bool is_baseline(std::string_view method);
// The policy is called `name`. Precondition: is_baseline(method).
Baseline make_baseline(std::string_view method, std::string name, GivenCosts costs);

}  // namespace ctn::baselines
