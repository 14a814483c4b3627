#include "planner/instance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/formulas.h"
#include "plan/limits.h"
#include "plan/predict.h"

namespace ctn::planner {
namespace {

// Two ways to compute the same number of runs differ by no more than this part.
constexpr double kRounding = 1e-12;
// Of a run. Far more than anybody has a use for; planning takes time in proportion to them, and compute times may be
// what a faulty program reported.
constexpr double kMostSlices = 10'000;

void add(Form& form, int subchain, double period, double execution) {
  for (Coefficient& known : form.coefficients) {
    if (known.subchain != subchain) continue;
    known.period += period;
    known.execution += execution;
    return;
  }
  form.coefficients.push_back({subchain, period, execution});
}

// A chain's response time: its latency, and one form for each element whose period could be the longest.
Group response_time(const graph::App& app, const model::CostTable& costs, const graph::Term& term) {
  Form latency;
  double fixed_period = 0.0;  // the longest that no plan changes
  std::vector<int> passed;
  bool first = true;
  for (const graph::ChainElement& element : app.graph.chain_elements(term.path)) {
    for (const NodeId node : element.nodes) {
      const std::optional<Nanos>& output = app.graph.node(node).output_period;
      if (output) fixed_period = std::max(fixed_period, to_millis(*output).count());
    }
    if (element.subchain) {
      const int index = static_cast<int>(element.subchain->index());
      add(latency, index, first ? 0.0 : 1.0, 1.0);
      latency.constant += costs.subchain_wait(app.graph, *element.subchain).count();
      if (std::find(passed.begin(), passed.end(), index) == passed.end()) passed.push_back(index);
    } else {
      const graph::Node& node = app.graph.node(element.nodes.front());
      const double period = to_millis(node.period.value_or(Nanos{0})).count();
      latency.constant += costs[element.nodes.front()].single_thread().count();
      if (!first && !element.follows) latency.constant += period;
      latency.constant += costs.wait(element.nodes.front()).count();
      fixed_period = std::max(fixed_period, period);
    }
    first = false;
  }
  Group group;
  for (const int index : passed) {
    group.forms.push_back(latency);
    add(group.forms.back(), index, 1.0, 0.0);
  }
  if (fixed_period > 0.0 || passed.empty()) {
    group.forms.push_back(latency);
    group.forms.back().constant += fixed_period;
  }
  return group;
}

Group period_of(const graph::App& app, NodeId node) {
  Form form;
  if (const auto& subchain = app.graph.node(node).subchain) {
    add(form, static_cast<int>(subchain->index()), 1.0, 0.0);
  } else {
    form.constant = to_millis(app.graph.node(node).period.value_or(Nanos{0})).count();
  }
  return {0.0, 0.0, {std::move(form)}};
}

Group group_of(const graph::App& app, const model::CostTable& costs, const graph::Term& term) {
  return term.metric == graph::Metric::kPeriod ? period_of(app, term.path.front()) : response_time(app, costs, term);
}

// On one kind of cores.
struct Costs {
  const model::CostTable& all;
  const model::CostTable busy;  // without waits
};

// With k cores, the q with the least L + p among those that meet an exact rate; period infinite where none does.
Owned best_with(const graph::App& app, const Costs& costs, SubchainId id, int cores, double slack, const Member& member,
                int threads_of_use) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Owned best{kInfinity, kInfinity, 1, kInfinity};
  for (int threads = 1; threads <= std::min(cores, threads_of_use); ++threads) {
    const model::OwnedCores busy = model::owned_cores_with(app.graph, id, costs.busy, cores, threads, slack);
    const model::OwnedCores found =
        member.wait > 0.0 ? model::owned_cores_with(app.graph, id, costs.all, cores, threads, slack) : busy;
    double period = std::max(busy.period.count(), member.min_period);
    double promised = std::max(found.period.count(), member.min_period);
    if (member.exact_period > 0.0) {
      if (promised > member.exact_period * (1.0 + plan::kTolerance)) continue;
      period = promised = member.exact_period;
    }
    const double execution = busy.execution.count();
    if (execution + period < (best.execution + best.period) * (1.0 - kRounding)) {
      best = {period, execution, threads, promised};
    }
  }
  return best;
}

OnKind on_kind(const graph::App& app, const Costs& costs, SubchainId id, int cores, double slack,
               const Member& member) {
  OnKind on;
  on.cost = costs.busy.subchain_total(app.graph, id).count();
  const double min_slice = to_millis(app.scheduler.min_slice).count();
  if (on.cost >= min_slice) {
    const double slices = min_slice > 0.0 ? std::min(on.cost / min_slice, kMostSlices) : kMostSlices;
    on.most_every = member.queue ? slices : std::floor(slices * (1.0 + kRounding));
  }
  const int threads = useful_threads(app, costs.busy, id);
  const int most = useful_cores(app, costs.busy, id, cores);
  for (int k = 1; k <= most; ++k) on.owned.push_back(best_with(app, costs, id, k, slack, member, threads));
  return on;
}

Member member_of(const graph::App& app, const model::CostTable& costs, SubchainId id) {
  Member member;
  member.wait = costs.subchain_wait(app.graph, id).count();
  member.queue = plan::takes_batches(app.graph, id);
  const plan::PeriodLimits limits = plan::period_limits(app.graph, id);
  member.min_period = limits.min.count();
  if (limits.exact) member.exact_period = limits.exact->count();
  return member;
}

}  // namespace

int useful_threads(const graph::App& app, const model::CostTable& costs, SubchainId id) {
  int useful = 1;
  for (const NodeId node : app.graph.subchain(id).nodes) {
    const auto& measured = costs[node].by_threads();
    useful = std::max(useful, measured.empty() ? app.graph.node(node).max_threads : measured.rbegin()->first);
  }
  return useful;
}

int useful_cores(const graph::App& app, const model::CostTable& costs, SubchainId id, int cores) {
  const auto nodes = static_cast<long long>(app.graph.subchain(id).nodes.size());
  return static_cast<int>(std::min<long long>(cores, nodes * useful_threads(app, costs, id)));
}

Instance make_instance(const graph::App& app, const model::CostTable& costs, int cores, double slack) {
  Instance instance;
  instance.usable = 1.0 - slack;
  for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
    instance.members.push_back(member_of(app, costs, SubchainId(i)));
  }
  const std::vector<model::CostTable> tables = model::costs_by_kind(app, costs);
  const std::vector<int> counts = app.cores_by_kind(cores);
  int first = 0;
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    const Costs on_these{tables[kind], tables[kind].without_waits()};
    int of_use = 0;
    for (std::size_t i = 0; i < instance.members.size(); ++i) {
      Member& member = instance.members[i];
      member.on.push_back(on_kind(app, on_these, SubchainId(i), counts[kind], slack, member));
      of_use += static_cast<int>(member.on.back().owned.size());
    }
    instance.kinds.push_back({first, counts[kind], std::min(counts[kind], of_use)});
    first += counts[kind];
  }
  for (const graph::Term& term : app.objective) {
    instance.objective.push_back(group_of(app, costs, term));
    instance.objective.back().weight = term.weight;
  }
  for (const plan::SoftBound& bound : plan::soft_bounds(app)) {
    instance.bounds.push_back(bound.term ? group_of(app, costs, app.objective[*bound.term])
                                         : period_of(app, *bound.node));
    instance.bounds.back().limit = bound.asked.count();
  }
  return instance;
}

int Instance::cores() const {
  int sum = 0;
  for (const CoreKind& kind : kinds) sum += kind.count;
  return sum;
}

int Instance::kind_of_core(int core) const {
  int kind = 0;
  while (kind + 1 < kind_count() && core >= this->kind(kind + 1).first) ++kind;
  return kind;
}

double value_of(const Form& form, const std::vector<Timing>& timings) {
  double value = form.constant;
  for (const Coefficient& c : form.coefficients) {
    const Timing& timing = timings[static_cast<std::size_t>(c.subchain)];
    value += c.period * timing.period + c.execution * timing.execution;
  }
  return value;
}

double value_of(const Group& group, const std::vector<Timing>& timings) {
  double largest = 0.0;
  for (const Form& form : group.forms) largest = std::max(largest, value_of(form, timings));
  return largest;
}

double weighted_sum(const std::vector<Group>& groups, const std::vector<Timing>& timings) {
  double sum = 0.0;
  for (const Group& group : groups) sum += group.weight * value_of(group, timings);
  return sum;
}

double objective_of(const Instance& instance, const std::vector<Timing>& timings) {
  return weighted_sum(instance.objective, timings);
}

double factor_of(const Instance& instance, const std::vector<Timing>& timings) {
  double factor = 1.0;
  for (const Group& bound : instance.bounds) factor = std::max(factor, value_of(bound, timings) / bound.limit);
  return factor;
}

}  // namespace ctn::planner
