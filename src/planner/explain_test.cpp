#include "planner/explain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "plan/validate.h"

namespace ctn::planner {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

graph::At<Rate> at_hertz(double rate) { return {Rate{rate}, {}}; }
graph::At<Nanos> at_most(double milliseconds) { return {to_nanos(Millis{milliseconds}), {}}; }

// Two chains of one node each: "fast" costs 4 ms and counts most, "slow" costs 40 ms.
graph::AppSpec fast_and_slow() {
  graph::AppSpec spec = graph::spec_of({"fast", "slow", "base"}, {"fast base", "slow base"});
  node(spec, "base").external = true;
  spec.objective = {graph::response("fast base", 1.0), graph::response("slow base", 0.05)};
  return spec;
}

struct Explained {
  graph::App app;
  plan::Plan plan;
  Explanation why;
  std::vector<double> told;  // of progress
};

Explained explained(const graph::AppSpec& spec, int cores, double effort = 0.03) {
  Explained of{.app = graph::build_app(spec).value(), .plan = {}, .why = {}, .told = {}};
  model::Workload work(of.app.graph);
  for (const auto& [name, cost] : {std::pair{"fast", 4.0}, {"slow", 40.0}}) {
    work.set(*of.app.graph.find_node(name), model::NodeWork::constant(Millis{cost}));
  }
  const model::CostTable costs = work.costs(of.app.graph);
  const trial::Samples samples(of.app, work, Nanos{0}, 1);
  ExpectedRequest request{.cores = cores, .slack = 0.06, .effort = effort};
  of.plan = make_expected_plan(of.app, samples, costs, request).value();
  request.on_progress = [&](double part) { of.told.push_back(part); };
  of.why = explain(of.app, samples, costs, request, of.plan);
  for (const Variation& more : of.why.one_more) {
    EXPECT_TRUE(plan::validate(*more.plan, of.app, costs, cores + 1).ok());
  }
  return of;
}

// fast is subchain 0, slow subchain 1.
const Reason& fast(const Explained& of) { return of.why.reasons[0]; }
const Reason& slow(const Explained& of) { return of.why.reasons[1]; }

TEST(Explain, WhoHasItsCoreToItselfIsBoundByItsCost) {
  const Explained of = explained(fast_and_slow(), 2);
  EXPECT_EQ(fast(of).binding, Binding::kCost);
  EXPECT_NEAR(fast(of).cost.count(), 4.0, 1e-6);
  EXPECT_THAT(fast(of).others, testing::IsEmpty());
  EXPECT_EQ(slow(of).binding, Binding::kCost);
}

TEST(Explain, WhoSharesAFullCoreIsBoundByIt) {
  graph::AppSpec spec = fast_and_slow();
  // Else slow follows every so-many-th output of fast.
  for (const char* name : {"fast", "slow"}) {
    graph::node(spec, name).trigger = graph::At<graph::TriggerBy>{graph::TriggerBy::kTime, {}};
  }
  const Explained of = explained(spec, 1);
  EXPECT_EQ(slow(of).binding, Binding::kCore);
  EXPECT_THAT(slow(of).others, ElementsAre(SubchainId(0)));
  EXPECT_GT(slow(of).core_used, 0.95);
  EXPECT_NEAR(slow(of).core_part + fast(of).core_part, slow(of).core_used, 1e-9);
}

TEST(Explain, NamesTheCapThatBindsAndTheRateThatIsGiven) {
  graph::AppSpec spec = fast_and_slow();
  node(spec, "fast").max_rate = at_hertz(20.0);
  EXPECT_EQ(fast(explained(spec, 2)).binding, Binding::kRateCap);
  node(spec, "fast").min_rate = at_hertz(20.0);
  const Explained of = explained(spec, 2);
  EXPECT_EQ(fast(of).binding, Binding::kExactRate);
  EXPECT_EQ(fast(of).node, of.app.graph.find_node("fast"));
}

// On a core of its own fast could run five times as often as the camera gives something.
TEST(Explain, NamesTheInputThatComesNoMoreOften) {
  graph::AppSpec spec = graph::spec_of({"camera", "fast", "slow", "base"}, {"camera fast base", "slow base"});
  for (const char* name : {"camera", "base"}) node(spec, name).external = true;
  node(spec, "camera").period = at_most(20.0);
  spec.objective = {graph::response("fast base", 1.0), graph::response("slow base", 0.05)};
  EXPECT_EQ(fast(explained(spec, 2)).binding, Binding::kCost);
  node(spec, "fast").needs_input = true;
  const Explained of = explained(spec, 2);
  EXPECT_EQ(fast(of).binding, Binding::kInput);
  EXPECT_EQ(fast(of).node, of.app.graph.find_node("camera"));
  EXPECT_NEAR(fast(of).period.count(), 20.0, 0.4);
  EXPECT_GE(of.plan.subchains[0].period, Millis{19.9});
}

TEST(Explain, NamesWhoTriggersWhom) {
  graph::AppSpec spec = graph::spec_of({"fast", "slow", "base"}, {"fast slow base"});
  node(spec, "base").external = true;
  node(spec, "fast").max_rate = at_hertz(10.0);
  spec.objective = {graph::response("fast slow base", 1.0)};
  const Explained of = explained(spec, 2);
  // Its writer's cap is its own rate: the reader begins when there is something new.
  EXPECT_EQ(fast(of).binding, Binding::kRateCap);
  ASSERT_EQ(slow(of).binding, Binding::kLeader);
  EXPECT_EQ(*slow(of).leader->subchain(), SubchainId(0));
}

TEST(Explain, ABoundCostsWhatDroppingItSaves) {
  graph::AppSpec spec = fast_and_slow();
  spec.objective[1].weight.value = 1e-3;
  node(spec, "slow").min_rate = at_hertz(20.0);
  const Explained of = explained(spec, 1, 0.1);
  ASSERT_EQ(of.why.bounds.size(), 1U);
  const BoundCost& bound = of.why.bounds[0];
  EXPECT_EQ(bound.key, "nodes.slow.min_rate");
  EXPECT_EQ(bound.asked, Millis{50.0});
  EXPECT_TRUE(bound.binds);
  ASSERT_TRUE(bound.without.plan);
  EXPECT_NEAR(bound.cost, of.why.again.expected->objective - bound.without.plan->expected->objective, 1e-9);
  EXPECT_GT(bound.cost, of.why.noise * of.why.again.expected->objective);
  EXPECT_EQ(slow(of).binding, Binding::kBound);
  EXPECT_THAT(slow(of).bounds, ElementsAre("nodes.slow.min_rate"));
}

TEST(Explain, ABoundWithRoomCostsNothing) {
  graph::AppSpec spec = fast_and_slow();
  spec.objective[0].max = at_most(1000.0);
  const Explained of = explained(spec, 2);
  ASSERT_EQ(of.why.bounds.size(), 1U);
  EXPECT_FALSE(of.why.bounds[0].binds);
  EXPECT_LT(of.why.bounds[0].cost, of.why.noise * of.why.again.expected->objective);
}

TEST(Explain, SaysWhatACoreMoreOrFewerWouldDo) {
  const Explained of = explained(fast_and_slow(), 2);
  ASSERT_EQ(of.why.one_more.size(), 1U);
  ASSERT_TRUE(of.why.one_more[0].plan && of.why.one_fewer[0]->plan);
  const double now = of.why.again.expected->objective;
  EXPECT_LE(of.why.one_more[0].plan->expected->objective, now * (1.0 + of.why.noise));
  EXPECT_GT(of.why.one_fewer[0]->plan->expected->objective, now * (1.0 + of.why.noise));
}

TEST(Explain, SaysWhyThereIsNoPlanOnFewerCores) {
  graph::AppSpec spec = fast_and_slow();
  node(spec, "slow").min_rate = at_hertz(22.0);
  node(spec, "slow").max_rate = at_hertz(22.0);
  node(spec, "fast").min_rate = at_hertz(100.0);
  node(spec, "fast").max_rate = at_hertz(100.0);
  const Explained of = explained(spec, 2);
  ASSERT_TRUE(of.why.one_fewer[0]);
  EXPECT_FALSE(of.why.one_fewer[0]->plan);
  EXPECT_THAT(of.why.one_fewer[0]->refusal, HasSubstr("exact rates of fast, slow cannot be met on 1 core"));
}

TEST(Explain, ADoubledWeightMakesItsTermNoWorse) {
  const Explained of = explained(fast_and_slow(), 1);
  ASSERT_EQ(of.why.doubled.size(), 2U);
  for (std::size_t term = 0; term < 2; ++term) {
    const DoubledWeight& doubled = of.why.doubled[term];
    ASSERT_TRUE(doubled.with.plan);
    EXPECT_LE(doubled.terms[term].count(), of.why.terms[term].count() + 1e-6) << term;
    const double weight = of.app.objective[term].weight;
    const auto with_double = [&](double objective, Millis value) { return objective + weight * value.count(); };
    EXPECT_LE(with_double(doubled.objective, doubled.terms[term]),
              with_double(of.why.again.expected->objective, of.why.terms[term]) + 1e-6)
        << term;
    EXPECT_GE(doubled.objective, of.why.again.expected->objective - 1e-6) << term;
  }
}

TEST(Explain, TellsHowFarItIs) {
  const Explained of = explained(fast_and_slow(), 2);
  ASSERT_FALSE(of.told.empty());
  for (std::size_t i = 1; i < of.told.size(); ++i) EXPECT_GE(of.told[i], of.told[i - 1]);
  EXPECT_NEAR(of.told.back(), 1.0, 0.01);
}

}  // namespace
}  // namespace ctn::planner
