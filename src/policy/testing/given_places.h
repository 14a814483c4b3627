// A policy for tests: each subchain has the place that the test says.
#pragma once

#include <utility>
#include <vector>

#include "policy/levels.h"
#include "policy/policy.h"

namespace ctn::policy {

class GivenPlaces : public Policy {
 public:
  // By SubchainId.
  explicit GivenPlaces(std::vector<SubchainPlace> places) : Policy("given"), places_(std::move(places)) {}
  bool follows_plan() const override { return false; }
  bool raises() const override { return true; }
  Result<Decision> decide(const Situation& situation) const override {
    Decision decision;
    decision.assignment.places = places_;
    decision.assignment.cores.resize(situation.cpus.size());
    rise_above_assigned(decision);
    return decision;
  }

 private:
  std::vector<SubchainPlace> places_;
};

// Has a fixed priority on a CPU, and is triggered by time.
inline SubchainPlace place_by_phase(int rank, int cpu, Nanos period, Nanos phase, Nanos budget = Nanos{0}) {
  SubchainPlace place;
  place.cpus = os::CpuSet{cpu};
  place.level = os::fixed_level(rank);
  place.pacing = {.period = period, .max_in_flight = 1, .phase = phase, .budget = budget};
  return place;
}

// The same, triggered by outputs of another.
inline SubchainPlace place_after(int rank, int cpu, const plan::Leader& leader, int every, Nanos expected) {
  SubchainPlace place = place_by_phase(rank, cpu, expected, Nanos{0});
  place.pacing.phase.reset();
  place.pacing.after = plan::After{leader, every};
  return place;
}

}  // namespace ctn::policy
