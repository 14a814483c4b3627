// What is small can be enumerated on a fine grid. The search comes close to the best of it: schedules of fixed
// priorities on one core, judged as the search judges them.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "planner/expected.h"
#include "planner/scoring.h"
#include "planner/testing/random_apps.h"
#include "trial/trial.h"

namespace ctn::planner {
namespace {

using std::chrono::seconds;

constexpr double kStep = 1.12;  // from one period, or pause, of the grid to the next

struct Small {
  std::string name;
  double cost_a = 1.0;
  double cost_b = 1.0;
  std::vector<std::pair<std::string, double>> terms;  // path and weight
};

// For messages of the test framework.
void PrintTo(const Small& small, std::ostream* out) { *out << small.name; }

// Two subchains; a feeds b. Half of the runs of each cost 0.7 of what is planned, or less.
struct Built {
  explicit Built(const Small& small) {
    graph::AppSpec spec = graph::spec_of({"a", "b"}, {"a b"});
    for (const auto& [path, weight] : small.terms) spec.objective.push_back(graph::response(path, weight));
    app = graph::build_app(spec).value();
    model::Workload work(app.graph);
    for (const auto& [node, cost] : {std::pair{NodeId(0), small.cost_a}, {NodeId(1), small.cost_b}}) {
      model::NodeWork law = model::NodeWork::constant(Millis{cost});
      law.typical = {Millis{0.7 * cost}};
      work.set(node, law);
    }
    costs = work.costs(app.graph);
    samples = trial::Samples(app, work, Nanos{0}, 1);
  }

  graph::App app;
  model::CostTable costs{app.graph, Millis{0}};
  trial::Samples samples{app, trial::MeasuredRuns{}, costs};
};

class Judge {
 public:
  explicit Judge(const Built& built) : app_(built.app), trial_(built.app, built.samples) {}

  double operator()(const trial::Schedule& schedule, Nanos horizon) const {
    const trial::Figures figures = trial_.run(schedule, {.horizon = horizon, .p95 = true});
    if (!figures.enough || figures.busy[0] > 1.0 - graph::kDefaultSlack + 2.0 * kLoadTolerance) return kInfinity;
    const std::vector<double> tails = tail_weights(app_);
    double sum = figures.objective;
    for (std::size_t term = 0; term < figures.terms.size(); ++term) {
      sum += tails[term] * app_.objective[term].weight * figures.terms[term].p95_ms;
    }
    return sum;
  }

 private:
  const graph::App& app_;
  trial::Trial trial_;
};

// By time at any of some phases, a pause after its own end, or, of b, each so-many-th output of a.
std::vector<trial::Place> places(double cost, double other_cost, bool follows) {
  std::vector<trial::Place> all;
  for (double period = 1.02 * cost; period < 20.0 * (cost + other_cost); period *= kStep) {
    for (const double phase : {0.0, std::min(1.1 * other_cost, 0.9 * period)}) {
      all.push_back({.period = to_nanos(Millis{period}), .phase = to_nanos(Millis{phase})});
    }
  }
  for (double pause = 0.1; pause < 10.0 * (cost + other_cost); pause *= kStep * kStep) {
    all.push_back({.period = to_nanos(Millis{cost}), .pause = to_nanos(Millis{pause})});
  }
  for (int every = 1; follows && every <= 8; ++every) all.push_back({.after = plan::After{SubchainId(0), every}});
  return all;
}

double best_of_grid(const Small& small, const Judge& judge) {
  constexpr std::size_t kFinal = 20;
  std::vector<std::pair<double, trial::Schedule>> best;
  for (const trial::Place& a : places(small.cost_a, small.cost_b, false)) {
    for (const trial::Place& b : places(small.cost_b, small.cost_a, true)) {
      for (const int first : {0, 1}) {
        trial::Schedule schedule{.cores = 1, .subchains = {a, b}, .frames = {}, .pipelines = {}};
        schedule.subchains[static_cast<std::size_t>(first)].priority = 2;
        const double score = judge(schedule, seconds{1});
        if (best.size() == kFinal && score >= best.back().first) continue;
        best.emplace_back(score, std::move(schedule));
        std::sort(best.begin(), best.end(), [](const auto& one, const auto& other) { return one.first < other.first; });
        if (best.size() > kFinal) best.pop_back();
      }
    }
  }
  double min = kInfinity;
  for (const auto& each : best) min = std::min(min, judge(each.second, seconds{60}));
  return min;
}

class Enumeration : public testing::TestWithParam<Small> {};

TEST_P(Enumeration, HasNothingMuchBetterThanTheSearch) {
  const Built built(GetParam());
  const Judge judge(built);
  const plan::Plan plan = make_expected_plan(built.app, built.samples, built.costs,
                                             {.cores = 1, .slack = graph::kDefaultSlack, .effort = 0.2})
                              .value();
  const double found = judge(trial::schedule_of(built.app, plan), seconds{60});
  const double best = best_of_grid(GetParam(), judge);
  RecordProperty("ratio", std::to_string(found / best));
  EXPECT_LE(found, 1.02 * best);
}

INSTANTIATE_TEST_SUITE_P(Cases, Enumeration,
                         testing::Values(Small{"chain", 3.0, 5.0, {{"a b", 1.0}}},
                                         Small{"quick_first", 1.0, 20.0, {{"a", 1.0}, {"a b", 0.1}}},
                                         Small{"quick_last", 20.0, 2.0, {{"b", 1.0}, {"a b", 0.3}}},
                                         Small{"apart", 4.0, 12.0, {{"a", 0.5}, {"b", 0.5}}}),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace ctn::planner
