#include "baselines/davare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "baselines/period_program.h"
#include "baselines/response_times.h"
#include "plan/limits.h"

namespace ctn::baselines {
namespace {

struct Assignment {
  std::vector<int> core;   // by subchain
  std::vector<int> order;  // subchains, highest priority first
};

struct Outcome {
  double factor = kInfinity;
  double objective = kInfinity;
  std::vector<double> periods;
  std::vector<double> responses;

  bool better_than(const Outcome& other) const {
    constexpr double kClearly = 1.0 - 1e-7;
    if (factor < other.factor * kClearly) return true;
    return factor * kClearly <= other.factor && objective < other.objective * kClearly;
  }
};

class Davare {
 public:
  Davare(const graph::App& app, const model::CostTable& costs, const RateRequest& request)
      : app_(app), stretched_(stretched_costs(app, costs, request.slack)), cores_(request.cores) {
    const std::size_t n = app.graph.subchains().size();
    effort_ = request.effort > 0 ? request.effort : std::max<std::size_t>(60, 6000 / n);
    weight_.assign(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      PeriodTask task;
      const plan::PeriodLimits limits = plan::period_limits(app.graph, SubchainId(i));
      task.min_period = limits.min.count();
      if (limits.exact) task.exact_period = limits.exact->count();
      task.cost = stretched_[0][i];
      program_.tasks.push_back(task);
    }
    double max_cost = 0.0;
    for (const auto& of_kind : stretched_) {
      max_cost = std::max(max_cost, std::accumulate(of_kind.begin(), of_kind.end(), 0.0));
    }
    for (PeriodTask& task : program_.tasks) task.max_period = 100.0 * std::max(max_cost, task.min_period);
    make_sums(costs);
  }

  std::optional<Outcome> run() {
    best_at_ = first();
    best_ = solve(best_at_, kRoughRounds);
    for (bool better = true; better && solved_ < effort_;) better = improve();
    if (best_.factor == kInfinity) return std::nullopt;
    const Outcome fine = solve(best_at_, kFineRounds);
    return fine.better_than(best_) ? fine : best_;
  }

  const Assignment& assignment() const { return best_at_; }

  // By exact response times.
  std::vector<ChainBound> chains(const Outcome& of) const {
    std::vector<ChainBound> bounds;
    for (const Chain& chain : chains_) {
      const double response = value(chain.whole, of);
      bounds.push_back({Millis{response}, Millis{response - value(chain.wait, of)}});
    }
    return bounds;
  }

 private:
  // A response-time term of the objective.
  struct Chain {
    LatencySum whole;
    LatencySum wait;  // until the first run begins
  };
  static constexpr int kRoughRounds = 3;
  static constexpr int kFineRounds = 12;

  // By exact response times.
  static double value(const LatencySum& sum, const Outcome& of) {
    double value = sum.constant;
    for (const LatencySum::Part& part : sum.parts) {
      const auto i = static_cast<std::size_t>(part.task);
      value += part.period * std::max(of.periods[i], part.emits) + part.response * of.responses[i];
    }
    return value;
  }

  double cost(std::size_t i, int core) const { return stretched_[app_.kind_of(core)][i]; }

  // The chains, the bounds and the objective as sums of periods and response times.
  void make_sums(const model::CostTable& costs) {
    const graph::Graph& graph = app_.graph;
    LatencySum& objective = program_.objective;
    std::vector<LatencySum> of_term;
    for (const graph::Term& term : app_.objective) {
      LatencySum sum;
      if (term.metric == graph::Metric::kPeriod) {
        const graph::Node& node = graph.node(term.path.front());
        if (node.subchain) {
          sum.add({static_cast<int>(node.subchain->index()), 1.0, 0.0, 0.0});
        } else {
          sum.constant = to_millis(node.period.value_or(Nanos{0})).count();
        }
      } else {
        std::optional<LatencySum> first;
        for (const graph::ChainElement& element : graph.chain_elements(term.path)) {
          add_element(sum, element, costs);
          if (!first) first = sum;
        }
        chains_.push_back({sum, first_wait(*first)});
      }
      objective.constant += term.weight * sum.constant;
      for (LatencySum::Part part : sum.parts) {
        weight_[static_cast<std::size_t>(part.task)] += term.weight * part.period;
        part.period *= term.weight;
        part.response *= term.weight;
        objective.add(part);
      }
      of_term.push_back(std::move(sum));
    }
    for (const plan::SoftBound& soft : plan::soft_bounds(app_)) {
      LatencySum bound;
      if (soft.term) {
        bound = of_term[*soft.term];
      } else {
        bound.add({static_cast<int>(graph.node(*soft.node).subchain->index()), 1.0, 0.0, 0.0});
      }
      if (bound.parts.empty()) continue;  // nothing can be done about it
      bound.asked = soft.asked.count();
      program_.bounds.push_back(std::move(bound));
    }
  }

  void add_element(LatencySum& sum, const graph::ChainElement& element, const model::CostTable& costs) const {
    const double emits = output_period(app_.graph, element).count();
    if (element.subchain) {
      sum.add({static_cast<int>(element.subchain->index()), 1.0, 1.0, emits});
      return;
    }
    const NodeId node = element.nodes.front();
    const double period = to_millis(app_.graph.node(node).period.value_or(Nanos{0})).count();
    sum.constant += std::max(period, emits) + costs[node].single_thread().count();
  }

  // Of a chain's first element, the time that a change waits for its next run.
  static LatencySum first_wait(LatencySum first) {
    for (LatencySum::Part& part : first.parts) part.response = 0.0;
    return first;
  }

  // What a run would cost on a core of the first kind, and its part of a core if all shared one.
  double load(std::size_t i) const { return std::sqrt(std::max(weight_[i], 1e-6) * stretched_[0][i]); }

  // The period that it would have if all shared one core, as far as its limits allow.
  double likely_period(std::size_t i) const {
    const PeriodTask& task = program_.tasks[i];
    if (task.exact_period > 0.0) return task.exact_period;
    return std::max(task.min_period, std::sqrt(stretched_[0][i] / std::max(weight_[i], 1e-6)));
  }

  Assignment first() const {
    const std::size_t n = program_.tasks.size();
    Assignment made;
    made.core.assign(n, 0);
    made.order.resize(n);
    std::iota(made.order.begin(), made.order.end(), 0);
    std::stable_sort(made.order.begin(), made.order.end(), [&](int a, int b) {
      return load(static_cast<std::size_t>(a)) > load(static_cast<std::size_t>(b));
    });
    std::vector<double> loads(static_cast<std::size_t>(cores_), 0.0);
    for (const int i : made.order) {
      const auto lightest = std::min_element(loads.begin(), loads.end());
      made.core[static_cast<std::size_t>(i)] = static_cast<int>(lightest - loads.begin());
      *lightest += load(static_cast<std::size_t>(i));
    }
    std::stable_sort(made.order.begin(), made.order.end(), [&](int a, int b) {
      return likely_period(static_cast<std::size_t>(a)) < likely_period(static_cast<std::size_t>(b));
    });
    return made;
  }

  // One move; whether it was for the better.
  bool improve() {
    const std::size_t n = best_at_.core.size();
    bool better = false;
    const auto try_move = [&](const Assignment& other) {
      if (solved_ >= effort_) return;
      const Outcome found = solve(other, kRoughRounds);
      if (!found.better_than(best_)) return;
      best_ = found;
      best_at_ = other;
      better = true;
    };
    for (std::size_t i = 0; i < n; ++i) {
      for (const int core : cores_worth_trying(i)) {
        Assignment other = best_at_;
        other.core[i] = core;
        try_move(other);
      }
      for (std::size_t j = i + 1; j < n; ++j) {
        if (best_at_.core[i] == best_at_.core[j]) continue;
        Assignment other = best_at_;
        std::swap(other.core[i], other.core[j]);
        try_move(other);
      }
    }
    for (std::size_t at = 0; at + 1 < n; ++at) try_lower(at, try_move);
    return better;
  }

  // Past the next in the order that shares its core.
  template <class Try>
  void try_lower(std::size_t at, const Try& try_move) {
    Assignment other = best_at_;
    const auto core_at = [&](std::size_t place) { return other.core[static_cast<std::size_t>(other.order[place])]; };
    for (std::size_t below = at + 1; below < other.order.size(); ++below) {
      if (core_at(below) != core_at(at)) continue;
      const auto begin = other.order.begin();
      std::rotate(begin + static_cast<std::ptrdiff_t>(at), begin + static_cast<std::ptrdiff_t>(at) + 1,
                  begin + static_cast<std::ptrdiff_t>(below) + 1);
      try_move(other);
      return;
    }
  }

  // Other cores that are in use, and of the unused ones the first of each kind.
  std::vector<int> cores_worth_trying(std::size_t i) const {
    std::vector<bool> used(static_cast<std::size_t>(cores_), false);
    for (const int core : best_at_.core) used[static_cast<std::size_t>(core)] = true;
    std::vector<bool> seen(app_.kinds(), false);
    std::vector<int> worth;
    for (int core = 0; core < cores_; ++core) {
      if (core == best_at_.core[i]) continue;
      if (!used[static_cast<std::size_t>(core)]) {
        if (seen[app_.kind_of(core)]) continue;
        seen[app_.kind_of(core)] = true;
      }
      worth.push_back(core);
    }
    return worth;
  }

  Outcome solve(const Assignment& at, int rounds) {
    const std::size_t n = at.core.size();
    for (std::size_t i = 0; i < n; ++i) program_.tasks[i].cost = cost(i, at.core[i]);
    for (std::size_t place = 0; place < n; ++place) {
      const auto i = static_cast<std::size_t>(at.order[place]);
      program_.tasks[i].higher.clear();
      for (std::size_t above = 0; above < place; ++above) {
        const int j = at.order[above];
        if (at.core[static_cast<std::size_t>(j)] == at.core[i]) program_.tasks[i].higher.push_back(j);
      }
    }
    std::vector<double> rounding(n, 1.0);
    Outcome best;
    for (int round = 0; round < rounds; ++round) {
      set_bursts(rounding);
      ++solved_;
      const std::optional<PeriodSolution> found = solve_periods(program_);
      if (!found) break;
      const Outcome exact = exactly(found->periods);
      if (exact.better_than(best)) best = exact;
      if (!correct(rounding, found->periods)) break;
    }
    return best;
  }

  void set_bursts(const std::vector<double>& rounding) {
    for (std::size_t i = 0; i < program_.tasks.size(); ++i) {
      PeriodTask& task = program_.tasks[i];
      task.burst = task.cost;
      for (const int j : task.higher) task.burst += rounding[i] * program_.tasks[static_cast<std::size_t>(j)].cost;
    }
  }

  std::optional<double> exact_response(std::size_t i, const std::vector<double>& periods) const {
    std::vector<PeriodicTask> higher;
    for (const int j : program_.tasks[i].higher) {
      higher.push_back({program_.tasks[static_cast<std::size_t>(j)].cost, periods[static_cast<std::size_t>(j)]});
    }
    return response_time(program_.tasks[i].cost, higher, periods[i]);
  }

  // With no factor where a run may outlast its period.
  Outcome exactly(const std::vector<double>& periods) const {
    Outcome outcome;
    outcome.periods = periods;
    for (std::size_t i = 0; i < periods.size(); ++i) {
      const std::optional<double> response = exact_response(i, periods);
      if (!response) return {};
      outcome.responses.push_back(*response);
    }
    outcome.factor = 1.0;
    for (const LatencySum& bound : program_.bounds) {
      outcome.factor = std::max(outcome.factor, value(bound, outcome) / bound.asked);
    }
    outcome.objective = value(program_.objective, outcome);
    return outcome;
  }

  // Of each task by the relative error of its response time; whether one was far off.
  bool correct(std::vector<double>& rounding, const std::vector<double>& periods) const {
    constexpr double kClose = 1e-3;
    bool far = false;
    for (std::size_t i = 0; i < periods.size(); ++i) {
      const PeriodTask& task = program_.tasks[i];
      if (task.higher.empty()) continue;
      double left = 1.0;
      for (const int j : task.higher) {
        left -= program_.tasks[static_cast<std::size_t>(j)].cost / periods[static_cast<std::size_t>(j)];
      }
      const double taken = task.burst / left;
      const std::optional<double> exact = exact_response(i, periods);
      // A run that may outlast its period was thought too short by what is not known: back to the safe side.
      const double error = exact ? (taken - *exact) / *exact : -0.5;
      const double corrected = std::clamp(rounding[i] - error, 0.0, 1.0);
      far = far || std::abs(corrected - rounding[i]) > kClose;
      rounding[i] = corrected;
    }
    return far;
  }

  const graph::App& app_;
  const std::vector<std::vector<double>> stretched_;  // [kind][subchain]
  const int cores_;
  std::size_t effort_ = 0;
  std::size_t solved_ = 0;
  std::vector<double> weight_;  // by subchain: of its period and response time in the objective
  PeriodProgram program_;
  std::vector<Chain> chains_;  // in the order of the objective
  Assignment best_at_;
  Outcome best_;
};

}  // namespace

Result<RatePlan> plan_by_davare(const graph::App& app, const model::CostTable& costs, const RateRequest& request) {
  if (const Status fine = check_request(app, request); !fine) return fine.error();
  Davare search(app, costs, request);
  const std::optional<Outcome> found = search.run();
  if (!found) {
    return Error(
        ErrorKind::kCaller,
        {Problem{{},
                 "nodes",
                 fmt::format("no periods found under which all runs on {} cores end within their periods, with "
                             "the rates that are exact",
                             request.cores),
                 "give it more cores, or lower the exact rates"}});
  }
  RatePlan plan;
  plan.planner = "davare";
  plan.exhaustive = false;
  plan.slack = request.slack;
  const std::size_t n = app.graph.subchains().size();
  plan.subchains.resize(n);
  for (std::size_t place = 0; place < n; ++place) {
    const auto i = static_cast<std::size_t>(search.assignment().order[place]);
    plan.subchains[i] = {search.assignment().core[i], Millis{found->periods[i]}, Millis{found->responses[i]},
                         static_cast<int>(n - place)};
  }
  fill_figures(plan, app, costs, request.cores, search.chains(*found));
  return plan;
}

}  // namespace ctn::baselines
