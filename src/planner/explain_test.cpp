#include "planner/explain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "graph/build.h"
#include "graph/spec_text.h"
#include "plan/predict.h"
#include "plan/validate.h"
#include "planner/allocation.h"
#include "planner/random_apps.h"

namespace ctn::planner {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

graph::At<Rate> at_hertz(double rate) { return {Rate{rate}, {}}; }
graph::At<Nanos> at_most(double milliseconds) { return {to_nanos(Millis{milliseconds}), {}}; }

struct Case {
  graph::App app;
  model::CostTable costs;
};

// Two chains of one node each: "fast" costs 4 ms and counts most, "slow" costs 40 ms.
graph::AppSpec fast_and_slow() {
  graph::AppSpec spec = graph::spec_of({"fast", "slow", "base"}, {"fast base", "slow base"});
  node(spec, "base").external = true;
  spec.objective = {graph::response("fast base", 1.0), graph::response("slow base", 0.05)};
  return spec;
}

Case built(const graph::AppSpec& spec, double fast = 4.0, double slow = 40.0) {
  auto app = graph::build_app(spec);
  EXPECT_TRUE(app.ok()) << (app.ok() ? "" : app.error().message());
  model::CostTable costs(app->graph, Millis{0});
  costs.set(*app->graph.find_node("fast"), model::CostProfile::constant(Millis{fast}));
  costs.set(*app->graph.find_node("slow"), model::CostProfile::constant(Millis{slow}));
  return {*std::move(app), std::move(costs)};
}

struct Explained {
  plan::Plan plan;
  Explanation why;
};

Explained explained(const Case& any, const Request& request) {
  plan::Plan plan = make_plan(any.app, any.costs, request).value();
  Explanation why = explain(any.app, any.costs, request, plan);
  return {std::move(plan), std::move(why)};
}

// fast is subchain 0, slow subchain 1.
const Reason& fast(const Explained& of) { return of.why.reasons[0]; }
const Reason& slow(const Explained& of) { return of.why.reasons[1]; }

TEST(Explain, OwnersAreBoundByTheirLongestNodeOrTheirCost) {
  const Case apart = built(fast_and_slow());
  const Explained two = explained(apart, {2, 0.06});
  EXPECT_EQ(fast(two).binding, Binding::kLongestNode);
  EXPECT_EQ(fast(two).node, apart.app.graph.find_node("fast"));
  EXPECT_NEAR(fast(two).core_part, 1.0, 1e-9);

  graph::AppSpec spec = graph::spec_of({"fast", "slow"}, {"fast slow"});
  spec.subchains = {graph::subchain("both", "fast slow")};
  spec.objective = {graph::response("fast slow", 1.0)};
  EXPECT_EQ(fast(explained(built(spec), {1, 0.06})).binding, Binding::kCost);
  EXPECT_EQ(fast(explained(built(spec), {2, 0.06})).binding, Binding::kLongestNode);
}

TEST(Explain, SharersAreBoundByTheirCore) {
  const Explained one = explained(built(fast_and_slow()), {1, 0.06});
  EXPECT_EQ(fast(one).binding, Binding::kCore);
  EXPECT_EQ(slow(one).binding, Binding::kCore);
  EXPECT_THAT(slow(one).others, ElementsAre(SubchainId(0)));
  EXPECT_NEAR(fast(one).core_part + slow(one).core_part, 1.0, 1e-9);
}

TEST(Explain, NamesTheCapThatBinds) {
  graph::AppSpec spec = fast_and_slow();
  node(spec, "fast").max_rate = at_hertz(10.0);
  const Case capped = built(spec);
  const Explained one = explained(capped, {1, 0.06});
  EXPECT_EQ(fast(one).binding, Binding::kRateCap);
  EXPECT_EQ(fast(one).node, capped.app.graph.find_node("fast"));
  EXPECT_EQ(fast(explained(capped, {2, 0.06})).binding, Binding::kRateCap);
}

TEST(Explain, NamesTheRateThatAFrameWaitsFor) {
  graph::AppSpec spec = fast_and_slow();
  node(spec, "fast").min_rate = node(spec, "fast").max_rate = at_hertz(10.0);
  const Explained one = explained(built(spec), {1, 0.06});
  EXPECT_EQ(fast(one).binding, Binding::kExactRate);
  ASSERT_GT(one.plan.cores[0].idle.count(), 0.0);
  EXPECT_EQ(slow(one).binding, Binding::kOtherRate);
  EXPECT_EQ(slow(one).through, SubchainId(0));
}

// All rates are capped but that of "third", which would have short frames; slices may be no shorter than 1 ms.
TEST(Explain, AFrameWaitsForTheOneThatCannotBeCutFiner) {
  graph::AppSpec spec = graph::spec_of({"fast", "slow", "third", "base"}, {"fast base", "slow base", "third base"});
  node(spec, "base").external = true;
  node(spec, "fast").input = graph::InputKind::kQueue;
  node(spec, "fast").max_rate = node(spec, "slow").max_rate = at_hertz(10.0);
  spec.objective = {graph::response("fast base", 1.0), graph::response("slow base", 1.0),
                    graph::response("third base", 1.0)};
  const auto waits_for = [&](double fast_cost, double slow_cost) {
    Case any = built(spec, fast_cost, slow_cost);
    any.costs.set(*any.app.graph.find_node("third"), model::CostProfile::constant(Millis{2.0}));
    const Explained one = explained(any, {1, 0.06});
    EXPECT_EQ(one.why.reasons[0].binding, Binding::kRateCap);
    EXPECT_EQ(one.why.reasons[2].binding, Binding::kOtherRate);
    return one.why.reasons[2].through;
  };
  EXPECT_EQ(waits_for(4.0, 8.0), SubchainId(0));
  EXPECT_EQ(waits_for(40.0, 8.0), SubchainId(1));
}

TEST(Explain, NamesMinSliceOnlyWhereAShorterSliceWouldBeBetter) {
  graph::AppSpec spec = fast_and_slow();
  spec.scheduler.min_slice = std::chrono::milliseconds{20};
  EXPECT_EQ(slow(explained(built(spec), {1, 0.06})).binding, Binding::kMinSlice);
  EXPECT_EQ(fast(explained(built(spec), {1, 0.06})).binding, Binding::kCore) << "it runs whole as it should";
}

TEST(Explain, ABoundCostsWhatDroppingItSaves) {
  graph::AppSpec spec = fast_and_slow();
  const Explained before = explained(built(spec), {1, 0.06});
  spec.objective[1].max = at_most(before.plan.chains[1].response.count() * 0.6);
  const Explained bound = explained(built(spec), {1, 0.06});
  ASSERT_EQ(bound.plan.relax_factor, 1.0);
  ASSERT_EQ(bound.why.bounds.size(), 1U);
  EXPECT_EQ(bound.why.bounds[0].key, "objective[1].max");
  EXPECT_TRUE(bound.why.bounds[0].binds);
  EXPECT_GT(bound.why.bounds[0].cost, 0.0);
  EXPECT_NEAR(bound.why.bounds[0].cost, bound.plan.objective - before.plan.objective, 1e-9);

  EXPECT_EQ(slow(bound).binding, Binding::kBound);
  EXPECT_THAT(slow(bound).bounds, ElementsAre("objective[1].max"));
  EXPECT_EQ(fast(bound).binding, Binding::kOtherBound);
  EXPECT_EQ(fast(bound).through, SubchainId(1));
}

TEST(Explain, ARateCanBeABoundThatCosts) {
  graph::AppSpec spec = fast_and_slow();
  const Explained before = explained(built(spec), {1, 0.06});
  node(spec, "slow").min_rate = at_hertz(1000.0 / (before.plan.subchains[1].period.count() * 0.6));
  const Explained bound = explained(built(spec), {1, 0.06});
  ASSERT_EQ(bound.why.bounds.size(), 1U);
  EXPECT_EQ(bound.why.bounds[0].key, "nodes.slow.min_rate");
  EXPECT_NEAR(bound.why.bounds[0].cost, bound.plan.objective - before.plan.objective, 1e-9);
  EXPECT_EQ(slow(bound).binding, Binding::kBound);
}

TEST(Explain, ABoundWithRoomCostsNothing) {
  graph::AppSpec spec = fast_and_slow();
  spec.objective[0].max = at_most(10'000.0);
  const Explained one = explained(built(spec), {1, 0.06});
  EXPECT_FALSE(one.why.bounds[0].binds);
  EXPECT_NEAR(one.why.bounds[0].cost, 0.0, 1e-9);
  EXPECT_EQ(fast(one).binding, Binding::kCore);
}

TEST(Explain, SaysWhyThereIsNoPlanOnFewerCores) {
  graph::AppSpec spec = fast_and_slow();
  node(spec, "slow").min_rate = node(spec, "slow").max_rate = at_hertz(23.0);
  node(spec, "fast").min_rate = node(spec, "fast").max_rate = at_hertz(100.0);
  const Explained two = explained(built(spec), {2, 0.06});
  ASSERT_TRUE(two.why.one_fewer.front());
  EXPECT_FALSE(two.why.one_fewer.front()->plan);
  EXPECT_THAT(two.why.one_fewer.front()->refusal, HasSubstr("cannot be met on 1 core"));
}

TEST(Explain, OneSubchainHasOtherNumbersOfCores) {
  graph::AppSpec spec = graph::spec_of({"fast", "slow"}, {"fast slow"});
  spec.subchains = {graph::subchain("both", "fast slow")};
  spec.objective = {graph::response("fast slow", 1.0)};
  const Explained two = explained(built(spec), {2, 0.0});
  ASSERT_TRUE(two.why.runner_up.plan);
  EXPECT_TRUE(two.why.runner_up.proven);
  EXPECT_NEAR(two.why.runner_up.plan->objective, 88.0, 1e-9) << "on one core";
  EXPECT_FALSE(explained(built(spec), {1, 0.0}).why.runner_up.plan);
}

TEST(Explain, ADoubledWeightMakesItsTermNoWorse) {
  const Explained one = explained(built(fast_and_slow()), {1, 0.06});
  ASSERT_EQ(one.why.doubled.size(), 2U);
  EXPECT_LT(one.why.doubled[1].terms[1], one.why.terms[1]);
  EXPECT_GT(one.why.doubled[1].terms[0], one.why.terms[0]);
  EXPECT_GE(one.why.doubled[1].objective, one.plan.objective) << "under the weights as they were";
  EXPECT_FALSE(one.why.doubled[1].allocation_changes);
}

class ExplainRandom : public testing::TestWithParam<std::uint64_t> {
 protected:
  static RandomCase any_case(int subchains) {
    RandomLimits limits;
    limits.subchains = subchains;
    limits.caps = GetParam() % 2 == 0;
    limits.bounds = GetParam() % 3 == 0;
    limits.pairs = true;
    return random_case(GetParam(), limits, 2);
  }
};

// Whether `a` is no better plan than `b`.
bool no_better(const plan::Plan& a, const plan::Plan& b) {
  if (a.relax_factor > b.relax_factor * (1.0 + 1e-9)) return true;
  return a.objective >= b.objective * (1.0 - 1e-9) && a.relax_factor >= b.relax_factor * (1.0 - 1e-9);
}

TEST_P(ExplainRandom, ItsPlansStandInTheRightOrder) {
  for (const int subchains : {3, 5}) {
    const RandomCase any = any_case(subchains);
    const Request request{any.cores, any.slack};
    const plan::Plan plan = make_plan(any.app, any.costs, request).value();
    const Explanation why = explain(any.app, any.costs, request, plan);
    ASSERT_TRUE(why.one_more.front().plan);
    EXPECT_TRUE(no_better(plan, *why.one_more.front().plan));
    EXPECT_TRUE(no_better(*why.one_fewer.front()->plan, plan));
    ASSERT_TRUE(why.runner_up.plan);
    EXPECT_TRUE(why.runner_up.proven);
    EXPECT_TRUE(no_better(*why.runner_up.plan, plan));
    EXPECT_NE(allocation_groups(*why.runner_up.plan, any.app), allocation_groups(plan, any.app));
    EXPECT_TRUE(plan::validate(*why.runner_up.plan, any.app, any.costs, any.cores).ok());
    for (const DoubledWeight& doubled : why.doubled) EXPECT_GE(doubled.objective, plan.objective * (1.0 - 1e-9));
  }
}

// Of three subchains on two cores one is alone, and the other two share.
TEST_P(ExplainRandom, TheRunnerUpIsTheBestOfTheRest) {
  RandomLimits limits;
  limits.subchains = 3;
  const RandomCase any = random_case(GetParam(), limits, 2);
  const Instance instance = make_instance(any.app, any.costs, any.cores, any.slack);
  std::vector<double> values;
  for (std::size_t alone = 0; alone < 3; ++alone) {
    Allocation allocation{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 1};
    allocation.core_of[alone] = -1;
    allocation.owned[alone] = 1;
    Effort effort;
    values.push_back(plan_shares(instance, objective_target(instance, 1.0), allocation, effort).shares.value);
  }
  std::sort(values.begin(), values.end());
  const Request request{any.cores, any.slack};
  const plan::Plan plan = make_plan(any.app, any.costs, request).value();
  const RunnerUp runner_up = explain(any.app, any.costs, request, plan).runner_up;
  EXPECT_EQ(runner_up.allocations, 2U);
  EXPECT_NEAR(plan.objective, values[0], 1e-9 * values[0]);
  EXPECT_NEAR(runner_up.plan->objective, values[1], 1e-9 * values[1]);
}

TEST_P(ExplainRandom, ManySubchainsAreComparedWithNeighbours) {
  const RandomCase any = any_case(8);
  const Request request{any.cores, any.slack};
  const plan::Plan plan = make_plan(any.app, any.costs, request).value();
  const RunnerUp runner_up = explain(any.app, any.costs, request, plan).runner_up;
  EXPECT_FALSE(runner_up.proven);
  ASSERT_TRUE(runner_up.plan);
  EXPECT_TRUE(no_better(*runner_up.plan, plan));
  EXPECT_TRUE(plan::validate(*runner_up.plan, any.app, any.costs, any.cores).ok());
}

INSTANTIATE_TEST_SUITE_P(Seeds, ExplainRandom, testing::Range<std::uint64_t>(1, 13));

}  // namespace
}  // namespace ctn::planner
