#include "model/formulas.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>
#include <vector>

#include "graph/build.h"
#include "graph/testing/spec_text.h"

namespace ctn::model {
namespace {

constexpr SubchainId kOnly{0};

graph::App row_of(std::size_t nodes, int max_threads = 1) {
  std::vector<std::string> names;
  std::string path;
  for (std::size_t i = 0; i < nodes; ++i) {
    names.push_back("n" + std::to_string(i));
    path += names.back() + " ";
  }
  graph::AppSpec spec = graph::spec_of(names, nodes > 1 ? std::vector{path} : std::vector<std::string>{});
  for (graph::NodeSpec& node : spec.nodes) node.max_threads = graph::At<int>{max_threads, {}};
  spec.subchains.push_back(graph::subchain("s", path));
  spec.objective.push_back(graph::response(path, 1.0));
  return graph::build_app(spec).value();
}

CostTable costs_of(const graph::App& app, const std::vector<double>& millis) {
  CostTable costs(app.graph, Millis{0});
  for (std::size_t i = 0; i < millis.size(); ++i) costs.set(NodeId{i}, CostProfile::constant(Millis{millis[i]}));
  return costs;
}

double response(const OwnedCores& owned) { return (owned.period + owned.execution).count(); }

TEST(OwnedCores, OnOneCoreThePeriodIsTheSum) {
  const graph::App app = row_of(3);
  const OwnedCores owned = owned_cores(app.graph, kOnly, costs_of(app, {25, 58, 1}), 1, 0.0);
  EXPECT_EQ(owned.threads, 1);
  EXPECT_DOUBLE_EQ(owned.period.count(), 84.0);
  EXPECT_DOUBLE_EQ(owned.execution.count(), 84.0);
}

TEST(OwnedCores, OnTwoCoresTheLongestNodeBinds) {
  const graph::App app = row_of(3);
  const OwnedCores owned = owned_cores(app.graph, kOnly, costs_of(app, {25, 58, 1}), 2, 0.06);
  EXPECT_DOUBLE_EQ(owned.period.count(), 58.0 / 0.94);
  EXPECT_DOUBLE_EQ(owned.execution.count(), 84.0);
}

TEST(OwnedCores, AWaitOccupiesItsNodeAndNoCore) {
  const graph::App app = row_of(3);
  CostTable costs = costs_of(app, {25, 58, 1});
  costs.set_wait(NodeId{0}, Millis{40});
  const OwnedCores one = owned_cores(app.graph, kOnly, costs, 1, 0.06);
  EXPECT_DOUBLE_EQ(one.period.count(), 84.0 / 0.94 + 40.0);
  EXPECT_DOUBLE_EQ(one.execution.count(), 124.0);
  const OwnedCores two = owned_cores(app.graph, kOnly, costs, 2, 0.06);
  EXPECT_DOUBLE_EQ(two.period.count(), 25.0 / 0.94 + 40.0) << "longer than 58 / 0.94";
  EXPECT_DOUBLE_EQ(two.execution.count(), 124.0);
}

// Of two nodes on two threads each, on three cores: one run at a time.
TEST(OwnedCores, RunsThatWaitOverlapNoMoreThanThereAreCoresForTheirThreads) {
  const graph::App app = row_of(2, 2);
  CostTable costs = costs_of(app, {2, 4});
  costs.set_wait(NodeId{0}, Millis{6});
  EXPECT_EQ(owned_cores_with(app.graph, kOnly, costs, 3, 2, 0.0).period, Millis{1 + 6 + 2});
  EXPECT_EQ(owned_cores_with(app.graph, kOnly, costs, 4, 2, 0.0).period, Millis{1 + 6}) << "as the first node is busy";
  EXPECT_EQ(owned_cores_with(app.graph, kOnly, costs, 3, 1, 0.0).period, Millis{2 + 6});
}

// Four runs of 2 ms one after the other in each frame; 2 and 3 of them in turns.
TEST(SharedCore, SeveralRunsInAFrameComeInBursts) {
  EXPECT_EQ(shared_core({Millis{20}, 4.0, Millis{8}}, false).period, Millis{5});
  EXPECT_EQ(shared_core({Millis{20}, 4.0, Millis{8}}, false).execution, Millis{20 + 2 - 8});
  EXPECT_EQ(longest_gap(Millis{20}, 4.0), Millis{20});
  EXPECT_EQ(shared_core({Millis{20}, 2.5, Millis{5}}, false).execution, Millis{20 + 2 - 5});
}

// Two slots and a half, if it begins with one; begun in the middle of one it ends in the third after that.
TEST(SharedCore, ARunMayBeginWithinASlot) {
  EXPECT_EQ(shared_core({Millis{20}, 0.4, Millis{2}}, false).period, Millis{50});
  EXPECT_EQ(shared_core({Millis{20}, 0.4, Millis{2}}, false).execution, Millis{60 + 5 - 6});
  EXPECT_EQ(longest_gap(Millis{20}, 0.4), Millis{60});
  EXPECT_EQ(longest_gap(Millis{20}, 0.25), Millis{80});
}

TEST(SharedCore, SpreadsARunOverItsPeriod) {
  const SharedTiming timing = shared_core({Millis{20}, 0.25, Millis{5}}, false);
  EXPECT_EQ(timing.period, Millis{80});
  EXPECT_EQ(timing.execution, Millis{80});
}

TEST(SharedCore, ARunThatWaitsMayMissASlot) {
  const SharedTiming timing = shared_core({Millis{20}, 0.25, Millis{5}, Millis{7}}, false);
  EXPECT_EQ(timing.period, Millis{80 + 7 + 20 + 5});
  EXPECT_EQ(timing.execution, timing.period);
  const SharedTiming briefly = shared_core({Millis{20}, 0.25, Millis{5}, kShortWait}, false);
  EXPECT_EQ(briefly.period, Millis{80});
  EXPECT_EQ(briefly.execution, Millis{80.2});
  const SharedTiming exact = shared_core({Millis{20}, 0.25, Millis{5}, Millis{7}}, true);
  EXPECT_EQ(exact.period, Millis{80});
  EXPECT_EQ(exact.execution, Millis{87});
}

TEST(OwnedCores, CountsWholeGroupsOfThreads) {
  const graph::App app = row_of(4, 8);
  const CostTable costs = costs_of(app, {8, 8, 8, 8});
  // floor(5 / 2) = 2 groups, so that the fifth core adds nothing.
  EXPECT_DOUBLE_EQ(owned_cores_with(app.graph, kOnly, costs, 4, 2, 0.0).period.count(), 8.0);
  EXPECT_DOUBLE_EQ(owned_cores_with(app.graph, kOnly, costs, 5, 2, 0.0).period.count(), 8.0);
  EXPECT_DOUBLE_EQ(owned_cores_with(app.graph, kOnly, costs, 6, 2, 0.0).period.count(), 16.0 / 3.0);
}

TEST(OwnedCores, TakesMoreThreadsOnlyWhereTheyPay) {
  const graph::App app = row_of(2);
  CostTable costs(app.graph, Millis{0});
  const auto both = [&](double two) {
    const CostProfile profile = CostProfile::of_threads({{1, Millis{10}}, {2, Millis{two}}});
    costs.set(NodeId{0}, profile);
    costs.set(NodeId{1}, profile);
  };
  both(8);  // q = 1: 10 + 20; q = 2: 16 + 16
  EXPECT_EQ(owned_cores(app.graph, kOnly, costs, 2, 0.0).threads, 1);
  both(7);  // q = 2: 14 + 14
  EXPECT_EQ(owned_cores(app.graph, kOnly, costs, 2, 0.0).threads, 2);
  both(7.5);  // equal: the smaller
  EXPECT_EQ(owned_cores(app.graph, kOnly, costs, 2, 0.0).threads, 1);
}

TEST(ChainTiming, OfEqualPeriodsAndExecutionsIsThePapersTable) {
  const std::vector<ElementTiming> row{
      {Millis{3}, Millis{3}, {}}, {Millis{7}, Millis{7}, {}}, {Millis{5}, Millis{5}, {}}};
  const ChainTiming timing = chain_timing(row);
  EXPECT_EQ(timing.latency, Millis{3 + 14 + 10});
  EXPECT_EQ(timing.period, Millis{7});
  EXPECT_EQ(timing.response, Millis{34});
}

// Guards: of two elements with an output period the longer one alone was waited for, and of that no run.
TEST(ChainTiming, WaitsForOutputsThatAreRarerThanTheRunsOfEachElement) {
  const std::vector<ElementTiming> row{{.period = Millis{10}, .execution = Millis{4}, .left_out = Millis{667 + 4}},
                                       {.period = Millis{20}, .execution = Millis{5}, .left_out = Millis{30 + 5}}};
  const ChainTiming timing = chain_timing(row);
  EXPECT_EQ(timing.latency, Millis{4 + 20 + 5});
  EXPECT_EQ(timing.period, Millis{20 + 667 + 4 + 30 + 5});
}

// Of c, which has none itself, each other run gives an output: so much longer are the periods of a and b, too.
TEST(OutputPeriods, AreAllBetweenTwoOutputsOfNodesBehind) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "c"}, {"a b c"});
  node(spec, "a").output_period = graph::At<Nanos>{std::chrono::milliseconds{30}, {}};
  node(spec, "b").output_period = graph::At<Nanos>{std::chrono::milliseconds{100}, {}};
  spec.subchains = {graph::subchain("s", "a b c")};
  spec.objective = {graph::response("a b c", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  CostTable costs(app.graph, Millis{1});
  costs.set_runs_per_output(NodeId(2), 2.0);
  const graph::Subchain& subchain = app.graph.subchain(SubchainId(0));
  const auto most = [&](std::size_t node) {
    return left_out(app.graph, costs, subchain, NodeId(node)).most(Millis{5});
  };
  EXPECT_EQ(most(0), Millis{30 + 5});
  EXPECT_EQ(most(1), Millis{30 + 100 + 2 * 5});
  EXPECT_EQ(most(2), Millis{2 * (30 + 100 + 2 * 5)});
  costs.set_runs_per_output(NodeId(2), 1.0);
  EXPECT_EQ(outputs_late(app.graph, costs, subchain, Millis{10}, Millis{5}), Millis{10 + 30 + 100 + 2 * 5 - 100});
}

struct Case {
  std::vector<double> costs;
  int max_threads;
  int cores;
  double slack;
};

Case any_case() {
  Case made;
  const int nodes = *rc::gen::inRange(1, 6);
  for (int i = 0; i < nodes; ++i) made.costs.push_back(*rc::gen::inRange(0, 100'000) * 1e-3);
  made.max_threads = *rc::gen::inRange(1, 5);
  made.cores = *rc::gen::inRange(1, 9);
  made.slack = *rc::gen::inRange(0, 50) * 0.01;
  return made;
}

RC_GTEST_PROP(OwnedCores, ACoreMoreIsNeverWorse, ()) {
  const Case any = any_case();
  const graph::App app = row_of(any.costs.size(), any.max_threads);
  const CostTable costs = costs_of(app, any.costs);
  RC_ASSERT(response(owned_cores(app.graph, kOnly, costs, any.cores + 1, any.slack)) <=
            response(owned_cores(app.graph, kOnly, costs, any.cores, any.slack)));
}

RC_GTEST_PROP(OwnedCores, AMoreExpensiveNodeIsNeverBetter, ()) {
  const Case any = any_case();
  const graph::App app = row_of(any.costs.size(), any.max_threads);
  std::vector<double> costlier = any.costs;
  costlier[*rc::gen::inRange<std::size_t>(0, costlier.size())] += *rc::gen::inRange(0, 1000) * 0.1;
  const int threads = *rc::gen::inRange(1, any.cores + 1);
  const OwnedCores before = owned_cores_with(app.graph, kOnly, costs_of(app, any.costs), any.cores, threads, any.slack);
  const OwnedCores after = owned_cores_with(app.graph, kOnly, costs_of(app, costlier), any.cores, threads, any.slack);
  RC_ASSERT(after.period >= before.period);
  RC_ASSERT(after.execution >= before.execution);
}

RC_GTEST_PROP(OwnedCores, TimesTenGivesTimesTen, ()) {
  const Case any = any_case();
  const graph::App app = row_of(any.costs.size(), any.max_threads);
  std::vector<double> tenfold = any.costs;
  for (double& cost : tenfold) cost *= 10.0;
  const int threads = *rc::gen::inRange(1, any.cores + 1);
  const OwnedCores one = owned_cores_with(app.graph, kOnly, costs_of(app, any.costs), any.cores, threads, any.slack);
  const OwnedCores ten = owned_cores_with(app.graph, kOnly, costs_of(app, tenfold), any.cores, threads, any.slack);
  RC_ASSERT(std::abs(ten.period.count() - 10.0 * one.period.count()) <= 1e-9 * ten.period.count());
  RC_ASSERT(std::abs(ten.execution.count() - 10.0 * one.execution.count()) <= 1e-9 * ten.execution.count());
}

RC_GTEST_PROP(OwnedCores, TheBestIsNoWorseThanAnyNumberOfThreads, ()) {
  const Case any = any_case();
  const graph::App app = row_of(any.costs.size(), any.max_threads);
  const CostTable costs = costs_of(app, any.costs);
  const double best = response(owned_cores(app.graph, kOnly, costs, any.cores, any.slack));
  for (int threads = 1; threads <= any.cores; ++threads) {
    RC_ASSERT(best <= response(owned_cores_with(app.graph, kOnly, costs, any.cores, threads, any.slack)));
  }
}

}  // namespace
}  // namespace ctn::model
