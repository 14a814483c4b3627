// What is to be planned, reduced to numbers: what the solvers work on, without names, graphs or units.
//
// Every subchain gets a period p and an execution time L. The objective and the bounds are sums of *maxima of linear
// forms* in these: a chain's response time is linear but for its last term, the longest period of its elements, and
// max(a + x, a + y) is a maximum of two forms.
//
//   minimise   sum_g  weight_g * max_{f in g} f(p, L)      over the groups of the objective
//   such that  max_{f in g} f(p, L) <= limit_g * factor    for the groups that are bounds
//
// A linear term of the objective is a group of one form.
//
// What runs wait (model/cost.h) is in the constants of forms, as part of L; here p and L are as if they did not. A plan
// promises longer periods where they do (model/formulas.h): what is proven here is a bound from below, and the plan's
// gap says by how much.
//
// Units: milliseconds. Thread safety: plain values, pure functions.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"

namespace ctn::planner {

struct Coefficient {
  int subchain = 0;
  double period = 0.0;     // of p
  double execution = 0.0;  // of L
};

struct Form {
  double constant = 0.0;
  std::vector<Coefficient> coefficients;  // a subchain at most once
};

struct Group {
  double weight = 0.0;  // of the objective; 0 in a bound
  double limit = 0.0;   // of a bound
  std::vector<Form> forms;
};

// What a subchain makes of cores of its own.
struct Owned {
  double period = 0.0;
  double execution = 0.0;
  int threads = 1;
  double promised = 0.0;  // the period with what runs wait
};

// A subchain on cores of one kind.
struct OnKind {
  double cost = 0.0;         // C: of one run, single-threaded
  double most_every = 1.0;   // n at most: a slice is at least min_slice, or a whole run; whole unless a queue's
  std::vector<Owned> owned;  // [k - 1]: with k cores; only as many as are of use; period infinite where out of reach
};

struct Member {
  bool queue = false;         // its share is free
  double min_period = 0.0;    // rate cap
  double exact_period = 0.0;  // exact rate; 0: none
  double wait = 0.0;          // of a run
  std::vector<OnKind> on;     // by kind of cores

  const OnKind& on_kind(int kind) const { return on[static_cast<std::size_t>(kind)]; }
};

// Cores that are alike.
struct CoreKind {
  int first = 0;  // the number of the first of them
  int given = 1;  // how many there are
  int count = 1;  // no more than can be of use
};

struct Instance {
  std::vector<Member> members;  // by SubchainId
  std::vector<Group> objective;
  std::vector<Group> bounds;
  std::vector<CoreKind> kinds;  // at least one
  double usable = 1.0;          // of a core: 1 - slack

  int kind_count() const { return static_cast<int>(kinds.size()); }
  const CoreKind& kind(int number) const { return kinds[static_cast<std::size_t>(number)]; }
  int cores() const;                 // of all kinds, no more than can be of use
  int kind_of_core(int core) const;  // of a core as it is numbered in plans; core >= 0
};

// Threads beyond these change no node's cost, and cores beyond these (of at most `cores`) no figure of its subchain:
// every node already has all the cores that it can use to itself.
int useful_threads(const graph::App& app, const model::CostTable& costs, SubchainId id);
int useful_cores(const graph::App& app, const model::CostTable& costs, SubchainId id, int cores);

Instance make_instance(const graph::App& app, const model::CostTable& costs, int cores, double slack);

// A subchain's timing, as the forms take it.
struct Timing {
  double period = 0.0;
  double execution = 0.0;
};

double value_of(const Form& form, const std::vector<Timing>& timings);
double value_of(const Group& group, const std::vector<Timing>& timings);  // its largest form
// Of the groups' values, each with its weight.
double weighted_sum(const std::vector<Group>& groups, const std::vector<Timing>& timings);
double objective_of(const Instance& instance, const std::vector<Timing>& timings);
// The least factor by which all bounds have to be scaled to hold; at least 1.
double factor_of(const Instance& instance, const std::vector<Timing>& timings);

}  // namespace ctn::planner
