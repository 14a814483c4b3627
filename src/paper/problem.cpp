// The app in numbers: sections 5.1 and 5.2 of the paper up to what is optimised.
#include "paper/problem.h"

#include <algorithm>
#include <cmath>

#include "model/formulas.h"
#include "plan/limits.h"
#include "plan/predict.h"

namespace ctn::paper {
namespace {

// Where slices may be as short as one likes, a run is spread over no more frames than this.
constexpr double kMaxEvery = 1000.0;
constexpr double kTimingRounding = 1e-12;

double ms(const std::optional<Nanos>& time) { return to_millis(time.value_or(Nanos{0})).count(); }

void add_slowest(Metric& metric, int subchain, double runs) {
  const auto same = [&](const Metric::Slowest& slowest) { return slowest.subchain == subchain; };
  const auto known = std::find_if(metric.slowest.begin(), metric.slowest.end(), same);
  if (known == metric.slowest.end()) return metric.slowest.push_back({subchain, runs});
  known->runs = std::max(known->runs, runs);
}

void add(Metric& metric, int subchain, double periods) {
  const auto same = [&](const Metric::Part& part) { return part.subchain == subchain; };
  auto part = std::find_if(metric.latency.begin(), metric.latency.end(), same);
  if (part == metric.latency.end()) part = metric.latency.insert(part, Metric::Part{subchain, 0.0, 0.0});
  part->periods += periods;
  part->executions += 1.0;
}

// Table 1.
Metric response_time(const graph::App& app, const model::CostTable& costs, const graph::Term& term) {
  Metric metric;
  bool first = true;
  for (const graph::ChainElement& element : app.graph.chain_elements(term.path)) {
    metric.slowest_fixed = std::max(metric.slowest_fixed, ms(app.graph.output_period_up_to(element.nodes.back())));
    if (element.subchain) {
      const int subchain = static_cast<int>(element.subchain->index());
      add(metric, subchain, first ? 0.0 : 1.0);
      metric.constant += costs.subchain_wait(app.graph, *element.subchain).count();
      add_slowest(metric, subchain, costs.runs_per_output(app.graph.subchain(*element.subchain), element.nodes.back()));
    } else {
      const double period = ms(app.graph.node(element.nodes.front()).period);
      metric.constant += costs[element.nodes.front()].single_thread().count();
      if (!first && !element.follows) metric.constant += period;
      metric.constant += costs.wait(element.nodes.front()).count();
      metric.slowest_fixed = std::max(metric.slowest_fixed, period * costs.runs_per_output(element.nodes.front()));
    }
    first = false;
  }
  return metric;
}

Metric period_of(const graph::App& app, NodeId node) {
  Metric metric;
  if (const auto& subchain = app.graph.node(node).subchain) {
    add_slowest(metric, static_cast<int>(subchain->index()), 1.0);
    metric.slowest_fixed = ms(app.graph.output_period_before(node));
  } else {
    metric.slowest_fixed = ms(app.graph.node(node).period);
  }
  return metric;
}

Metric metric_of(const graph::App& app, const model::CostTable& costs, const graph::Term& term) {
  return term.metric == graph::Metric::kPeriod ? period_of(app, term.path.front()) : response_time(app, costs, term);
}

// On one kind of cores.
struct Costs {
  const model::CostTable& all;
  const model::CostTable busy;  // without waits
};

// Equation (1) for each q, and the q with the shortest response time of those that keep an exact rate, if any does.
Owned best_owned(const graph::App& app, const Costs& costs, SubchainId id, int cores, int threads,
                 const Subchain& subchain, double slack) {
  Owned best;
  bool best_keeps = false;
  for (int q = 1; q <= std::min(cores, threads); ++q) {
    const model::OwnedCores busy = model::owned_cores_with(app.graph, id, costs.busy, cores, q, slack);
    const model::OwnedCores found =
        subchain.wait > 0.0 ? model::owned_cores_with(app.graph, id, costs.all, cores, q, slack) : busy;
    const bool keeps =
        subchain.exact_period <= 0.0 || found.period.count() <= subchain.exact_period * (1.0 + plan::kTolerance);
    const auto period = [&](const model::OwnedCores& of) {
      return keeps && subchain.exact_period > 0.0 ? subchain.exact_period
                                                  : std::max(of.period.count(), subchain.min_period);
    };
    // What misses an exact rate by its waits alone has to be seen to miss it.
    const Timing timing{period(keeps ? busy : found), busy.execution.count()};
    const bool shorter =
        timing.period + timing.execution < (best.timing.period + best.timing.execution) * (1.0 - kTimingRounding);
    if (q == 1 || (keeps && !best_keeps) || (keeps == best_keeps && shorter)) {
      best = {timing, q, period(found)};
      best_keeps = keeps;
    }
  }
  return best;
}

OnKind on_kind(const graph::App& app, const Costs& costs, SubchainId id, int cores, double slack,
               const Subchain& subchain) {
  OnKind on;
  on.cost = costs.busy.subchain_total(app.graph, id).count();
  const double min_slice = to_millis(app.scheduler.min_slice).count();
  if (on.cost >= min_slice && on.cost > 0.0) {
    const double slices = min_slice > 0.0 ? on.cost / min_slice : kMaxEvery;
    on.max_every = std::min(kMaxEvery, subchain.queue ? slices : std::floor(slices * (1.0 + kTimingRounding)));
  }
  const int threads = costs.busy.max_useful_threads(app.graph, id);
  const auto nodes = static_cast<long long>(app.graph.subchain(id).nodes.size());
  for (int k = 1; k <= cores && k <= nodes * threads; ++k) {
    on.owned.push_back(best_owned(app, costs, id, k, threads, subchain, slack));
  }
  return on;
}

}  // namespace

double value_of(const Metric& metric, std::span<const Timing> timings) {
  double value = metric.constant;
  for (const Metric::Part& part : metric.latency) {
    const Timing& timing = timings[static_cast<std::size_t>(part.subchain)];
    value += part.periods * timing.period + part.executions * timing.execution;
  }
  double slowest = metric.slowest_fixed;
  for (const Metric::Slowest& each : metric.slowest) {
    slowest = std::max(slowest, each.runs * timings[static_cast<std::size_t>(each.subchain)].period);
  }
  return value + slowest;
}

double objective_of(std::span<const Metric> terms, std::span<const Timing> timings) {
  double sum = 0.0;
  for (const Metric& term : terms) sum += term.weight * value_of(term, timings);
  return sum;
}

double factor_of(std::span<const Metric> bounds, std::span<const Timing> timings) {
  double factor = 1.0;
  for (const Metric& bound : bounds) factor = std::max(factor, value_of(bound, timings) / bound.asked);
  return factor;
}

Problem make_problem(const graph::App& app, const model::CostTable& costs, int cores, double slack) {
  Problem problem;
  problem.usable = 1.0 - slack;
  problem.cores = app.cores_by_kind(cores);
  const std::vector<model::CostTable> by_kind = model::costs_by_kind(app, costs);
  for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
    const SubchainId id(i);
    Subchain& subchain = problem.subchains.emplace_back();
    const plan::PeriodLimits limits = plan::period_limits(app.graph, id);
    subchain.queue = plan::takes_batches(app.graph, id);
    subchain.wait = costs.subchain_wait(app.graph, id).count();
    subchain.min_period = limits.min.count();
    if (limits.exact) {
      subchain.exact_period = limits.exact->count();
      problem.exact.push_back(period_of(app, *limits.exact_of));
      problem.exact.back().asked = subchain.exact_period;
    }
    for (std::size_t kind = 0; kind < problem.cores.size(); ++kind) {
      const Costs costs_there{by_kind[kind], by_kind[kind].without_waits()};
      subchain.on.push_back(on_kind(app, costs_there, id, problem.cores[kind], slack, subchain));
    }
  }
  for (const graph::Term& term : app.objective) {
    problem.terms.push_back(metric_of(app, costs, term));
    problem.terms.back().weight = term.weight;
  }
  for (const plan::SoftBound& bound : plan::soft_bounds(app)) {
    problem.bounds.push_back(bound.term ? metric_of(app, costs, app.objective[*bound.term])
                                        : period_of(app, *bound.node));
    problem.bounds.back().asked = bound.asked.count();
  }
  return problem;
}

}  // namespace ctn::paper
