// What a combination of rates and cores is worth by the method of verucchi.h: the graphs of runs that it allows, and
// the best that can be scheduled.
//
// Units: see rate_plan.h. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "baselines/job_dag.h"
#include "baselines/rate_plan.h"
#include "plan/limits.h"

namespace ctn::baselines {

struct RateCandidate {
  std::vector<int> doublings;  // by subchain: its period is the base times two to the power of this
  std::vector<int> core;
};

struct RateValue {
  double factor = kInfinity;  // by which bounds are exceeded
  double objective = kInfinity;

  bool better_than(const RateValue& other) const {
    constexpr double kClearly = 1.0 - 1e-9;
    if (factor < other.factor * kClearly) return true;
    return factor * kClearly <= other.factor && objective < other.objective * kClearly;
  }
};

struct RateGraph {
  RateValue value;
  double base = 0.0;
  std::vector<DagTask> tasks;
  std::vector<DagEdge> edges;
  DagSchedule schedule;
  std::vector<ChainBound> chains;
};

class RateGraphs {
 public:
  // `app` outlives it.
  RateGraphs(const graph::App& app, const model::CostTable& costs, const RateRequest& request);

  // Of a subchain.
  double cost(std::size_t i, int core) const { return stretched_[app_.kind_of(core)][i]; }
  const plan::PeriodLimits& limits(std::size_t i) const { return limits_[i]; }
  double weight(std::size_t i) const { return weight_[i]; }  // of the terms that it is part of

  // The shortest base period; infinite where there is none.
  double base_of(const RateCandidate& at) const;
  // No graph of runs is better than this: a chain waits for its slowest task, and each of its tasks runs.
  RateValue min_value(const RateCandidate& at, double base) const;
  // The best graph; none where none can be scheduled.
  std::optional<RateGraph> best(const RateCandidate& at, double base);
  // Runs put into graphs so far.
  std::size_t spent() const { return spent_; }

 private:
  // A chain, or a period, as far as it concerns tasks.
  struct TermParts {
    struct Element {
      int task = 0;
      double emits = 0.0;
      int edge = -1;  // from the element before, of the same stretch; -1: it begins a stretch
    };
    bool response = true;
    double weight = 0.0;
    double constant = 0.0;    // of elements that are no tasks
    double first_wait = 0.0;  // of the first element, where it is no task
    bool begins_with_task = true;
    double bound = kInfinity;
    std::vector<Element> elements;
  };

  void make_terms(const model::CostTable& costs);
  void add_elements(TermParts& parts, const graph::Term& term, const model::CostTable& costs);
  int edge_between(int from, int to);
  std::vector<DagTask> tasks_of(const RateCandidate& at, double base) const;
  std::vector<std::vector<int>> delays_of(const std::vector<DagTask>& tasks);
  std::optional<RateGraph> build(const std::vector<DagTask>& tasks, const std::vector<DagEdge>& edges, double unit);
  static ChainBound chain_bound(const TermParts& term, const RateGraph& graph);

  const graph::App& app_;
  const std::vector<std::vector<double>> stretched_;  // [kind][subchain]
  const int cores_;
  const std::size_t count_;
  std::size_t spent_ = 0;
  std::vector<plan::PeriodLimits> limits_;
  std::vector<double> max_period_;  // by min_rate
  std::vector<int> rank_;           // of heads in the order of the data
  std::vector<double> weight_;
  std::vector<TermParts> terms_;
  std::vector<std::pair<int, int>> pairs_;  // tasks that follow each other in a chain
};

}  // namespace ctn::baselines
