// What a user is told when a plan comes into force: which bounds it relaxes, which compute times it assumes,
// and which chains are expected to take longer than they are promised. While
// that lasts it is said in the plan itself; told is when it begins, when it changes much, and when it ends.
//
// As long as no scheduled node has run, all compute times are a guess. What such a plan makes of an app's bounds says
// nothing of the app and lasts for the bootstrap as a rule, so it is told only where an exact rate would not have been
// met: then the guess was lowered, or the rate is relaxed.
//
// Units: in the names. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "base/ids.h"
#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::driver {

class PlanNews {
 public:
  struct Notice {
    std::string kind;  // "relaxed", "assumed-costs", "above-promise"
    std::string detail;

    friend bool operator==(const Notice&, const Notice&) = default;
  };

  // `app` outlives it.
  explicit PlanNews(const graph::App& app) : app_(app) {}

  // A plan has come into force.
  std::vector<Notice> in_force(const plan::Plan& plan);

 private:
  bool rests_on_nothing(const plan::Plan& plan) const;
  void tell_relaxed(const plan::Plan& plan, std::vector<Notice>& notices);
  void tell_lower_guess(const plan::Plan& plan, std::vector<Notice>& notices);
  void tell_assumed(const plan::Plan& plan, std::vector<Notice>& notices);
  void tell_above_promise(const plan::Plan& plan, std::vector<Notice>& notices);
  std::string names(const std::vector<plan::AssumedCost>& nodes, bool with_costs) const;

  const graph::App& app_;
  std::map<std::string, double> relaxed_;   // as told: by which factor each bound is missed
  std::vector<plan::AssumedCost> assumed_;  // as told
  std::vector<std::size_t> above_promise_;  // as told: chains of the plan
  bool lower_guess_told_ = false;
};

}  // namespace ctn::driver
