// An app as the paper's two stages see it: what each subchain costs, and the metrics of table 1 ("approximation") as
// functions of the periods p and the execution times L of subchains. On a shared core L = p, as in the paper's table.
//
//   response time of a chain   L_1 + sum_{x >= 2} (p_x + L_x) + max_x p_x
//   period of a node           p of its subchain
//
// The paper knows of periods of outputs that do not change with those of runs (`output_period`). Those that do
// (model/cost.h, runs_per_output) are a multiple of p.
//
// The paper's runs do not wait. What they do wait (model/cost.h) is added to the metrics as a constant; here p and L
// are as if they did not. A plan promises longer periods where they do (model/formulas.h), so that this is a bound from
// below.
//
// Units: milliseconds. Thread safety: plain values, pure functions.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "graph/app.h"
#include "model/cost.h"

namespace ctn::paper {

struct Timing {
  double period = 0.0;     // p
  double execution = 0.0;  // L
};

// A response time or a period: a term of the objective, or a bound.
struct Metric {
  struct Part {
    int subchain = 0;
    double periods = 0.0;     // how often its p adds
    double executions = 0.0;  // how often its L does
  };
  struct Slowest {
    int subchain = 0;
    double runs = 1.0;  // of it, that come to one output
  };
  double weight = 0.0;    // of a term
  double asked = 0.0;     // of a bound
  double constant = 0.0;  // what unscheduled nodes add, and waits
  std::vector<Part> latency;
  std::vector<Slowest> slowest;  // the longest time between outputs of these subchains is added, once ...
  double slowest_fixed = 0.0;    // ... or this one, if longer: of unscheduled nodes, and of output periods
};

double value_of(const Metric& metric, std::span<const Timing> timings);
double objective_of(std::span<const Metric> terms, std::span<const Timing> timings);
// The least factor, of at least 1, by which the limits have to be scaled to hold.
double factor_of(std::span<const Metric> bounds, std::span<const Timing> timings);

// A subchain on cores of its own: the number of threads a node with the shortest response time, equation (1)
// (eq:single-chain-theory-period), stretched to what a rate cap asks for.
struct Owned {
  Timing timing;
  int threads = 1;
  double promised = 0.0;  // the period with what runs wait
};

// A subchain on cores of one kind. (The paper's cores are all alike.)
struct OnKind {
  double cost = 0.0;         // c(S): of one run
  double max_every = 1.0;    // 1/f at most: a slice is at least min_slice, or a whole run
  std::vector<Owned> owned;  // [k - 1]: with k cores, as many as are of use
};

struct Subchain {
  bool queue = false;         // takes batches: f is free, and may exceed 1
  double min_period = 0.0;    // a rate cap
  double exact_period = 0.0;  // an exact rate; 0: none
  double wait = 0.0;          // of a run
  std::vector<OnKind> on;     // by kind
};

struct Problem {
  std::vector<Subchain> subchains;  // by SubchainId
  std::vector<Metric> terms;        // of the objective
  std::vector<Metric> bounds;       // soft: where they cannot all hold, all are relaxed by one factor
  std::vector<Metric> exact;        // exact rates, as bounds on periods, for stage I
  std::vector<int> cores;           // how many there are, by kind
  double usable = 1.0;              // of a core: 1 - slack

  const OnKind& on(std::size_t subchain, int kind) const {
    return subchains[subchain].on[static_cast<std::size_t>(kind)];
  }
};

Problem make_problem(const graph::App& app, const model::CostTable& costs, int cores, double slack);

// Stage I's answer, the matrix a_ij of the paper: each subchain has cores of its own, or shares one.
struct Place {
  int kind = 0;
  int owned = 0;   // how many cores are its own; 0: it shares one
  int shared = 0;  // which one it shares, if it does; these count from 0

  friend bool operator==(const Place&, const Place&) = default;
};
using Allocation = std::vector<Place>;  // by SubchainId

}  // namespace ctn::paper
