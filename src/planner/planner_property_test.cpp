// Random apps of one subchain: what must hold of every plan, whatever the app.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "graph/build.h"
#include "graph/spec_text.h"
#include "plan/json.h"
#include "plan/validate.h"
#include "planner/planner.h"

namespace ctn::planner {
namespace {

// Everything in milliseconds, so that a case can be scaled.
struct Case {
  struct Node {
    double cost = 0.0;
    std::vector<double> with_threads;  // beyond one; empty: not measured
    int max_threads = 1;
    double min_period = 0.0;  // 0: none
    double max_period = 0.0;
  };
  std::vector<Node> nodes;
  double sensor_period = 0.0;  // of an unscheduled node before the first; 0: there is none
  double bound = 0.0;          // on the response time; 0: none
  double period_weight = 0.0;
  int cores = 1;
  double slack = 0.0;
};

double sometimes(double value) { return *rc::gen::inRange(0, 3) == 0 ? value : 0.0; }
double up_to(double most) { return *rc::gen::inRange(1, 10'001) * most / 10'000.0; }

Case any_case() {
  Case made;
  const int nodes = *rc::gen::inRange(1, 6);
  const double pivot = up_to(200.0);  // no min_rate above a max_rate: an app has none
  for (int i = 0; i < nodes; ++i) {
    Case::Node node;
    node.cost = *rc::gen::inRange(0, 10) == 0 ? 0.0 : up_to(100.0);
    node.max_threads = *rc::gen::inRange(1, 5);
    if (sometimes(1.0) > 0.0) {
      const int measured = *rc::gen::inRange(1, 4);
      for (int q = 0; q < measured; ++q) node.with_threads.push_back(up_to(node.cost + 1.0));
    }
    node.min_period = sometimes(up_to(pivot));
    node.max_period = sometimes(pivot + up_to(200.0));
    made.nodes.push_back(node);
  }
  made.sensor_period = sometimes(5.0);
  made.bound = sometimes(up_to(300.0));
  made.period_weight = sometimes(up_to(2.0));
  made.cores = *rc::gen::inRange(1, 9);
  made.slack = *rc::gen::inRange(0, 30) * 0.01;
  return made;
}

graph::App app_of(const Case& any) {
  std::vector<std::string> names;
  std::string row;
  for (std::size_t i = 0; i < any.nodes.size(); ++i) {
    names.push_back("n" + std::to_string(i));
    row += names.back() + " ";
  }
  names.emplace_back("sensor");
  names.emplace_back("base");
  graph::AppSpec spec = graph::spec_of(names, {row + "base", "sensor n0"});
  const auto nanos = [](double ms) { return graph::At<Nanos>{to_nanos(Millis{ms}), {}}; };
  node(spec, "base").external = true;
  node(spec, "sensor").unscheduled = true;
  node(spec, "sensor").period = nanos(any.sensor_period > 0.0 ? any.sensor_period : 1.0);
  for (std::size_t i = 0; i < any.nodes.size(); ++i) {
    graph::NodeSpec& node = spec.nodes[i];
    node.max_threads = graph::At<int>{any.nodes[i].max_threads, {}};
    if (any.nodes[i].min_period > 0.0)
      node.max_rate = graph::At<Rate>{Rate::every(Millis{any.nodes[i].min_period}), {}};
    if (any.nodes[i].max_period > 0.0)
      node.min_rate = graph::At<Rate>{Rate::every(Millis{any.nodes[i].max_period}), {}};
  }
  spec.subchains = {graph::subchain("s", row)};
  spec.objective = {graph::response((any.sensor_period > 0.0 ? "sensor " : "") + row + "base", 1.0),
                    graph::period("n0", any.period_weight)};
  if (any.bound > 0.0) spec.objective[0].max = nanos(any.bound);
  auto app = graph::build_app(spec);
  if (!app) RC_FAIL(app.error().message());
  return *std::move(app);
}

model::CostTable costs_of(const Case& any, const graph::App& app) {
  model::CostTable costs(app.graph, Millis{0});
  for (std::size_t i = 0; i < any.nodes.size(); ++i) {
    std::map<int, Millis> elapsed{{1, Millis{any.nodes[i].cost}}};
    int threads = 2;
    for (const double cost : any.nodes[i].with_threads) elapsed[threads++] = Millis{cost};
    costs.set(NodeId{i}, any.nodes[i].with_threads.empty() ? model::CostProfile::constant(Millis{any.nodes[i].cost})
                                                           : model::CostProfile::of_threads(elapsed));
  }
  return costs;
}

plan::Plan plan_of(const Case& any) {
  const graph::App app = app_of(any);
  auto plan = make_plan(app, costs_of(any, app), {any.cores, any.slack});
  if (!plan) RC_FAIL(plan.error().message());
  return *std::move(plan);
}

// What plans compete by: first the factor, then the objective.
bool no_worse(const plan::Plan& a, const plan::Plan& b) {
  constexpr double kRounding = 1e-9;
  if (a.relax_factor < b.relax_factor * (1.0 - kRounding)) return true;
  return a.relax_factor <= b.relax_factor * (1.0 + kRounding) && a.objective <= b.objective * (1.0 + kRounding);
}

RC_GTEST_PROP(PlannerProperty, EveryPlanIsValid, ()) {
  const Case any = any_case();
  const graph::App app = app_of(any);
  const model::CostTable costs = costs_of(any, app);
  const auto plan = make_plan(app, costs, {any.cores, any.slack});
  RC_ASSERT(plan.ok());
  const Status valid = plan::validate(*plan, app, costs, any.cores);
  if (!valid) RC_FAIL(valid.error().message());
}

RC_GTEST_PROP(PlannerProperty, TheSameInputGivesTheSamePlan, ()) {
  const Case any = any_case();
  RC_ASSERT(plan_of(any) == plan_of(any));
}

RC_GTEST_PROP(PlannerProperty, EveryPlanSurvivesJson, ()) {
  const Case any = any_case();
  const graph::App app = app_of(any);
  const plan::Plan plan = plan_of(any);
  const auto read = plan::from_json(plan::to_json(plan, app), app, "plan.json");
  RC_ASSERT(read.ok());
  RC_ASSERT(*read == plan);
}

RC_GTEST_PROP(PlannerProperty, ACoreMoreIsNeverWorse, ()) {
  const Case any = any_case();
  Case more = any;
  ++more.cores;
  RC_ASSERT(no_worse(plan_of(more), plan_of(any)));
}

// Threads are chosen by L + p. An objective that weighs the period once more (a period term, an unscheduled source)
// need not agree with that choice, so that only for one that is L + p itself the best is known without following the
// rule.
Case with_objective_of_the_rule(Case any) {
  any.period_weight = 0.0;
  any.sensor_period = 0.0;
  return any;
}

RC_GTEST_PROP(PlannerProperty, ACheaperNodeIsNeverWorse, ()) {
  const Case any = with_objective_of_the_rule(any_case());
  Case cheaper = any;
  const double factor = *rc::gen::inRange(0, 100) * 0.01;
  Case::Node& node = cheaper.nodes[*rc::gen::inRange<std::size_t>(0, cheaper.nodes.size())];
  node.cost *= factor;
  for (double& cost : node.with_threads) cost *= factor;
  RC_ASSERT(no_worse(plan_of(cheaper), plan_of(any)));
}

RC_GTEST_PROP(PlannerProperty, TimesTenGivesTimesTen, ()) {
  const Case any = any_case();
  Case ten = any;
  for (Case::Node& node : ten.nodes) {
    node.cost *= 10.0;
    for (double& cost : node.with_threads) cost *= 10.0;
    node.min_period *= 10.0;
    node.max_period *= 10.0;
  }
  ten.sensor_period *= 10.0;
  ten.bound *= 10.0;
  const plan::Plan one = plan_of(any);
  const plan::Plan scaled = plan_of(ten);
  RC_ASSERT(std::abs(scaled.objective - 10.0 * one.objective) <= 1e-6 * scaled.objective);
  RC_ASSERT(std::abs(scaled.relax_factor - one.relax_factor) <= 1e-6 * one.relax_factor);
}

// All ways to own cores, by the formulas alone.
RC_GTEST_PROP(PlannerProperty, NoNumberOfCoresAndThreadsIsBetter, ()) {
  Case any = with_objective_of_the_rule(any_case());
  any.bound = 0.0;
  for (Case::Node& node : any.nodes) node.max_period = 0.0;
  double min_period = 0.0;
  for (const Case::Node& node : any.nodes) min_period = std::max(min_period, node.min_period);

  double best = std::numeric_limits<double>::infinity();
  for (int k = 1; k <= any.cores; ++k) {
    for (int q = 1; q <= k; ++q) {
      double sum = 0.0;
      double longest = 0.0;
      for (const Case::Node& node : any.nodes) {
        double cost = node.cost / std::min(q, node.max_threads);
        if (!node.with_threads.empty()) {
          const int measured = std::min(q, 1 + static_cast<int>(node.with_threads.size()));
          cost = measured == 1 ? node.cost : node.with_threads[static_cast<std::size_t>(measured - 2)];
        }
        sum += cost;
        longest = std::max(longest, cost);
      }
      const double period = std::max(std::max(longest, sum / std::floor(k / q)) / (1.0 - any.slack), min_period);
      best = std::min(best, sum + period);
    }
  }
  RC_ASSERT(std::abs(plan_of(any).objective - best) <= 1e-9 * best);
}

}  // namespace
}  // namespace ctn::planner
