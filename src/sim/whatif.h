// What if: the same app on other hardware, with a node that costs more or less, or with other weights. Each hypothesis
// is planned (what is promised) and simulated (what comes of it), so that neither has to be believed alone.
//
//   auto answers = answer(app, work, {{.cores = 2, .speed = 0.5}, {.cores = 1}}, {.policy = policy});
//   const Answer* least = cheapest(answers);
//
// A core of speed 2 takes half as long for everything. Bounds are those of the app file: `max` of response times and
// `min_rate`. They are met as promised if the plan relaxes none; as simulated, if no more than one response in a
// hundred is longer than its bound, and no node is slower than it must be.
//
// Units: as the names say. Thread safety: pure functions; answer() uses several threads inside, and what it gives does
// not depend on how many.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "model/workload.h"
#include "policy/policy.h"
#include "sim/outcome.h"
#include "sim/reservation.h"

namespace ctn::sim {

struct Hypothesis {
  int cores = 1;
  double speed = 1.0;                 // of all cores, > 0
  std::optional<NodeId> node{};       // whose runs cost
  double factor = 1.0;                //   so many times as much, > 0
  std::optional<std::size_t> term{};  // of the objective, that weighs
  double weight = 0.0;                //   so much, >= 0
};

struct WhatIfOptions {
  std::shared_ptr<const policy::Policy> policy;
  Reserve reserve{};      // as in simulation.h
  double seconds = 20.0;  // that are measured, of each
  std::uint64_t seed = 1;
  std::size_t threads = 0;  // 0: one a CPU
  // Called with how many are answered, from any thread, one call at a time, as Progress tells it (batch.h).
  std::function<void(std::size_t)> on_progress;
};

// What the planner promises: at percentiles, at worst.
struct Promise {
  double objective = 0.0;
  double relax_factor = 1.0;         // 1: all bounds hold
  std::vector<double> responses_ms;  // by response-time term, in the order of the objective
};

struct Answer {
  Hypothesis asked;
  std::optional<Promise> promised;   // none: there is no plan, or the policy follows none
  std::optional<Outcome> simulated;  // none: the policy could not decide
  std::string why_not;               // where either is missing for a reason

  bool promise_holds() const { return promised && promised->relax_factor <= 1.0; }
  bool simulation_holds() const;
  // By what it can be told: both where there are both.
  bool holds() const;
};

// The app under a hypothesis, and its work.
graph::App app_under(const graph::App& app, const Hypothesis& asked);
model::Workload work_under(const graph::App& app, const model::Workload& work, const Hypothesis& asked);

// In the order asked. Errors (kCaller): an app that lists its cores, asked for others.
Result<std::vector<Answer>> answer(const graph::App& app, const model::Workload& work,
                                   const std::vector<Hypothesis>& asked, const WhatIfOptions& options);

// That meets all bounds with the least of cores times speed, of these with the fewest cores; null: none does.
const Answer* cheapest(const std::vector<Answer>& answers);

// Where the app breaks, as promised: the least speed of `cores` cores (between 1/64 and 64) at which formulas
// (planner/formulas.h) find a plan that meets all bounds; none if there is none. To some percent: near the limit they
// find such a plan, or they do not.
std::optional<double> min_speed(const graph::App& app, const model::Workload& work, int cores);
// The most that a node's runs may cost, as a factor (same range and accuracy), on hardware as `asked` says.
std::optional<double> max_factor(const graph::App& app, const model::Workload& work, Hypothesis asked, NodeId node);

}  // namespace ctn::sim
