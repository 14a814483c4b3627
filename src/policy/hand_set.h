// Policies whose rates were set by hand, in the app file or on the command line. Where they were set for nodes within a
// subchain, it is cut there, so that each subchain has one rate, its head's.
//
// Units: in the types. Thread safety: as policy.h says.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "plan/plan.h"
#include "policy/policy.h"

namespace ctn::policy {

class HandSetPolicy : public Policy {
 public:
  bool follows_plan() const override { return false; }
  bool cuts_subchains() const override { return true; }

 protected:
  using Policy::Policy;

  // By subchain: each head's fallback_rate, but where `of_sources` is given heads that are sources have that. kCaller
  // names every head without a rate.
  Result<std::vector<Rate>> rates(const graph::App& app, std::optional<Rate> of_sources = {}) const;
  // All subchains on all CPUs at these rates, under ordinary scheduling.
  static Decision at(const std::vector<Rate>& rates, const os::CpuSet& cpus);
};

// As nodes run without a scheduler of their own.
class DefaultPolicy : public HandSetPolicy {
 public:
  DefaultPolicy() : HandSetPolicy("default") {}
  bool raises() const override { return false; }
  Result<Decision> decide(const Situation& situation) const override;
};

// The same, with one rate for all sources, which is that of their whole subchains: for sweeps.
class RatePolicy : public HandSetPolicy {
 public:
  RatePolicy(Rate rate, std::string name) : HandSetPolicy(std::move(name)), rate_(rate) {}
  bool cuts_subchains() const override { return false; }
  bool raises() const override { return false; }
  Result<Decision> decide(const Situation& situation) const override;

 private:
  Rate rate_;
};

// The rates of a plan, for whole subchains: what the plan says of cores and priorities is left to ordinary scheduling.
class PlannedRatesPolicy : public HandSetPolicy {
 public:
  // `plan` is of the situation's app, which is checked when it is decided upon, and for any number of cores.
  PlannedRatesPolicy(std::string name, plan::Plan plan) : HandSetPolicy(std::move(name)), plan_(std::move(plan)) {}
  bool cuts_subchains() const override { return false; }
  bool raises() const override { return false; }
  Result<Decision> decide(const Situation& situation) const override;

 private:
  plan::Plan plan_;
};

// One real-time priority a subchain, in the app's order of stealing; nodes that run by themselves above them, and
// controllers above all.
class FifoPolicy : public HandSetPolicy {
 public:
  FifoPolicy() : HandSetPolicy("fifo") {}
  bool raises() const override { return true; }
  Result<Decision> decide(const Situation& situation) const override;
};

}  // namespace ctn::policy
