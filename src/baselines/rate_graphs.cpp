#include "baselines/rate_graphs.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ctn::baselines {
namespace {

double period_at(const RateCandidate& at, double base, int task) {
  return std::ldexp(base, at.doublings[static_cast<std::size_t>(task)]);
}

}  // namespace

RateGraphs::RateGraphs(const graph::App& app, const model::CostTable& costs, const RateRequest& request)
    : app_(app),
      stretched_(stretched_costs(app, costs, request.slack)),
      cores_(request.cores),
      count_(app.graph.subchains().size()) {
  for (std::size_t i = 0; i < count_; ++i) limits_.push_back(plan::period_limits(app.graph, SubchainId(i)));
  rank_.assign(count_, 0);
  int rank = 0;
  for (const NodeId node : app.graph.topological_order()) {
    const auto& subchain = app.graph.node(node).subchain;
    if (subchain && app.graph.subchain(*subchain).head() == node) rank_[subchain->index()] = rank++;
  }
  make_terms(costs);
  max_period_.assign(count_, kInfinity);
  for (const plan::SoftBound& bound : plan::soft_bounds(app)) {
    if (!bound.node) continue;
    double& max = max_period_[app.graph.node(*bound.node).subchain->index()];
    max = std::min(max, bound.asked.count());
  }
}

void RateGraphs::make_terms(const model::CostTable& costs) {
  const graph::Graph& graph = app_.graph;
  weight_.assign(count_, 0.0);
  for (const graph::Term& term : app_.objective) {
    TermParts parts;
    parts.response = term.metric == graph::Metric::kResponseTime;
    parts.weight = term.weight;
    if (term.max) parts.bound = to_millis(*term.max).count();
    if (parts.response) {
      add_elements(parts, term, costs);
    } else if (const auto& subchain = graph.node(term.path.front()).subchain) {
      parts.elements.push_back({static_cast<int>(subchain->index()), 0.0, -1});
    } else {
      parts.constant = to_millis(graph.node(term.path.front()).period.value_or(Nanos{0})).count();
    }
    for (const TermParts::Element& element : parts.elements) {
      weight_[static_cast<std::size_t>(element.task)] += term.weight;
    }
    terms_.push_back(std::move(parts));
  }
}

void RateGraphs::add_elements(TermParts& parts, const graph::Term& term, const model::CostTable& costs) {
  int before = -1;
  bool first = true;
  for (const graph::ChainElement& element : app_.graph.chain_elements(term.path)) {
    const double emits = output_period(app_.graph, element).count();
    if (element.subchain) {
      const auto task = static_cast<int>(element.subchain->index());
      parts.elements.push_back({task, emits, before < 0 ? -1 : edge_between(before, task)});
      before = task;
    } else {
      const NodeId node = element.nodes.front();
      const double period = std::max(to_millis(app_.graph.node(node).period.value_or(Nanos{0})).count(), emits);
      parts.constant += period + costs[node].single_thread().count();
      if (first) {
        parts.first_wait = period;
        parts.begins_with_task = false;
      }
      before = -1;
    }
    first = false;
  }
}

int RateGraphs::edge_between(int from, int to) {
  const auto same = std::find(pairs_.begin(), pairs_.end(), std::pair(from, to));
  if (same != pairs_.end()) return static_cast<int>(same - pairs_.begin());
  pairs_.emplace_back(from, to);
  return static_cast<int>(pairs_.size()) - 1;
}

double RateGraphs::base_of(const RateCandidate& at) const {
  double base = 0.0;
  double exact = 0.0;
  std::vector<double> load(static_cast<std::size_t>(cores_), 0.0);
  for (std::size_t i = 0; i < count_; ++i) {
    const double by = std::ldexp(1.0, at.doublings[i]);
    load[static_cast<std::size_t>(at.core[i])] += cost(i, at.core[i]) / by;
    if (limits_[i].exact) {
      const double given = limits_[i].exact->count() / by;
      if (exact > 0.0 && std::abs(given - exact) > 1e-9 * exact) return kInfinity;
      exact = given;
    } else {
      base = std::max(base, limits_[i].min.count() / by);
    }
  }
  base = std::max(base, *std::max_element(load.begin(), load.end()));
  if (exact == 0.0) return base;
  return base <= exact * (1.0 + 1e-12) ? exact : kInfinity;
}

RateValue RateGraphs::min_value(const RateCandidate& at, double base) const {
  if (base == kInfinity) return {};
  RateValue lowest{1.0, 0.0};
  for (std::size_t i = 0; i < count_; ++i) {
    lowest.factor = std::max(lowest.factor, period_at(at, base, static_cast<int>(i)) / max_period_[i]);
  }
  for (const TermParts& term : terms_) {
    double value = term.constant;
    double slowest = 0.0;
    for (const TermParts::Element& element : term.elements) {
      const double p = period_at(at, base, element.task);
      const auto task = static_cast<std::size_t>(element.task);
      if (element.edge < 0) {
        value += slowest;
        slowest = 0.0;
      }
      slowest = std::max(slowest, p);
      if (term.response) value += std::max(0.0, element.emits - p) + cost(task, at.core[task]);
    }
    value += slowest;
    lowest.objective += term.weight * value;
    lowest.factor = std::max(lowest.factor, value / term.bound);
  }
  return lowest;
}

std::vector<DagTask> RateGraphs::tasks_of(const RateCandidate& at, double base) const {
  std::vector<std::size_t> order(count_);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(at.doublings[a], rank_[a]) < std::pair(at.doublings[b], rank_[b]);
  });
  const int lowest = at.doublings[order.front()];
  std::vector<DagTask> tasks(count_);
  for (std::size_t place = 0; place < count_; ++place) {
    const std::size_t i = order[place];
    const double unit = std::ldexp(base, lowest);
    tasks[i] = {cost(i, at.core[i]) / unit, 1 << (at.doublings[i] - lowest), at.core[i],
                static_cast<int>(count_ - place)};
  }
  return tasks;
}

std::optional<RateGraph> RateGraphs::best(const RateCandidate& at, double base) {
  const double unit = std::ldexp(base, *std::min_element(at.doublings.begin(), at.doublings.end()));
  const std::vector<DagTask> tasks = tasks_of(at, base);
  const std::vector<std::vector<int>> delays = delays_of(tasks);
  std::vector<DagEdge> edges;
  for (std::size_t e = 0; e < pairs_.size(); ++e) edges.push_back({pairs_[e].first, pairs_[e].second, delays[e][0]});
  std::optional<RateGraph> best = build(tasks, edges, unit);
  if (!best) return std::nullopt;
  for (std::size_t e = 0; e < pairs_.size(); ++e) {
    for (std::size_t way = 1; way < delays[e].size(); ++way) {
      std::vector<DagEdge> other = best->edges;
      other[e].delay = delays[e][way];
      std::optional<RateGraph> graph = build(tasks, other, unit);
      if (graph && graph->value.better_than(best->value)) best = std::move(graph);
    }
  }
  return best;
}

// By edge, the ways to connect: first the one that always works.
std::vector<std::vector<int>> RateGraphs::delays_of(const std::vector<DagTask>& tasks) {
  spent_ += runs_of(tasks);
  const std::optional<DagSchedule> alone = schedule_dag(tasks, {});
  std::vector<std::vector<int>> delays;
  for (const auto& [from, to] : pairs_) {
    const DagTask& producer = tasks[static_cast<std::size_t>(from)];
    const int step = std::min(producer.every, tasks[static_cast<std::size_t>(to)].every);
    std::vector<int> ways{producer.every};
    if (alone) {
      double latest = 0.0;  // end of a run after its trigger
      const auto& runs = alone->runs[static_cast<std::size_t>(from)];
      for (std::size_t k = 0; k < runs.size(); ++k) {
        latest = std::max(latest, runs[k].end - static_cast<double>(k) * producer.every);
      }
      const int by_then = static_cast<int>(std::ceil(latest / step - 1e-9)) * step;
      if (by_then < producer.every) ways.push_back(by_then);
    }
    ways.push_back(0);
    delays.push_back(std::move(ways));
  }
  return delays;
}

std::optional<RateGraph> RateGraphs::build(const std::vector<DagTask>& tasks, const std::vector<DagEdge>& edges,
                                           double unit) {
  spent_ += runs_of(tasks);
  std::optional<DagSchedule> schedule = schedule_dag(tasks, edges);
  if (!schedule) return std::nullopt;
  RateGraph found;
  found.base = unit;
  found.tasks = tasks;
  found.edges = edges;
  found.schedule = *std::move(schedule);
  found.value = {1.0, 0.0};
  const auto period_of = [&](int task) { return unit * tasks[static_cast<std::size_t>(task)].every; };
  for (std::size_t i = 0; i < count_; ++i) {
    found.value.factor = std::max(found.value.factor, period_of(static_cast<int>(i)) / max_period_[i]);
  }
  for (const TermParts& term : terms_) {
    double value = term.constant;
    if (term.response) {
      found.chains.push_back(chain_bound(term, found));
      value = found.chains.back().response.count();
    } else if (!term.elements.empty()) {
      value = period_of(term.elements.front().task);
    }
    found.value.objective += term.weight * value;
    found.value.factor = std::max(found.value.factor, value / term.bound);
  }
  return found;
}

ChainBound RateGraphs::chain_bound(const TermParts& term, const RateGraph& found) {
  double response = term.constant;
  double wait = term.first_wait;
  for (std::size_t i = 0; i < term.elements.size();) {
    const bool first = i == 0 && term.begins_with_task;
    std::vector<DagEdge> row;
    const int begin = term.elements[i].task;
    double emits = 0.0;
    do {
      const auto task = static_cast<std::size_t>(term.elements[i].task);
      emits += std::max(0.0, term.elements[i].emits - found.base * found.tasks[task].every);
      ++i;
      if (i == term.elements.size() || term.elements[i].edge < 0) break;
      row.push_back(found.edges[static_cast<std::size_t>(term.elements[i].edge)]);
    } while (true);
    const DagLatency latency = chain_latency(found.tasks, found.schedule, begin, row);
    response += found.base * latency.reaction + emits;
    if (first) wait = found.base * (latency.reaction - latency.age);
  }
  return {Millis{response}, Millis{response - wait}};
}

}  // namespace ctn::baselines
