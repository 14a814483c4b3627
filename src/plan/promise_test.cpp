#include "plan/promise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "plan/above_promise.h"
#include "plan/json.h"
#include "plan/testing/sample_plan.h"
#include "plan/validate.h"

namespace ctn::plan {
namespace {

class PromiseTest : public ::testing::Test {
 protected:
  graph::App app = sample_app();
  model::CostTable costs = sample_costs(app);
  Plan plan = sample_priorities(app, costs);

  Member& member(SubchainId id) {
    for (Member& each : plan.cores[0].members) {
      if (each.subchain == id) return each;
    }
    throw std::logic_error("no such member");
  }
  Promise promised(SubchainId id) { return promise(plan, app, costs).value()[id.index()]; }
  std::string problems() {
    const Status valid = validate(plan, app, costs, kSampleCores);
    return valid ? "" : valid.error().message();
  }
};

TEST_F(PromiseTest, TheHighestPriorityTakesItsOwnTime) {
  EXPECT_EQ(promised(kFast).execution, Millis{6});
  EXPECT_EQ(promised(kFast).period, Millis{20});
}

TEST_F(PromiseTest, AFollowerTakesWhatInterruptsItAndComesWithItsLeader) {
  // fast interrupts 20 ms of slow twice: 32 ms, in which it comes twice.
  EXPECT_EQ(promised(kSlow).execution, Millis{32});
  EXPECT_EQ(promised(kSlow).period, Millis{40});
}

TEST_F(PromiseTest, WhoIsTriggeredByOutputsMayComeEarly) {
  // Below slow, which comes every 40 ms, but up to 32 ms + 6 ms closer: 4 + 2 x 20 + 6 k, k = ceil(R / 20).
  EXPECT_EQ(promised(kBatch).execution, Millis{4 + 2 * 20 + 4 * 6});
  EXPECT_EQ(promised(kBatch).period, promised(kBatch).execution + Millis{10});
}

// Held apart by 50 ms, less the 10 ms by which it may catch up.
TEST_F(PromiseTest, WhoIsTriggeredByOutputsIsHeldApartByMostOfAPeriod) {
  member(kSlow).period = Millis{50};
  const NodeId node = app.graph.subchain(kBatch).nodes.front();
  const auto with_cost = [&](Millis cost) {
    costs.set(node, model::CostProfile::constant(cost));
    return promised(kBatch).execution;
  };
  EXPECT_EQ(with_cost(Millis{8}), Millis{8 + 20 + 2 * 6});
  EXPECT_EQ(with_cost(Millis{8.5}), Millis{8.5 + 2 * 20 + 4 * 6});
}

// Outputs come each 20 ms, the first of them after a while: slow comes at 0, 24, 48 and 78 ms, once too soon.
TEST_F(PromiseTest, WhoIsHeldBackByItsPeriodComesSoonerOnce) {
  member(kSlow).after->every = 1;
  member(kSlow).period = Millis{30};
  costs.set(*app.graph.find_node("map"), model::CostProfile::constant(Millis{1}));
  costs.set(app.graph.subchain(kBatch).nodes.front(), model::CostProfile::constant(Millis{30}));
  // fast comes 6 ms each 20.
  EXPECT_EQ(promised(kBatch).execution, Millis{30 + 3 * 6 + 3 * 1});
}

// fast waits for 4 ms after each run; each second of its outputs triggers slow, above it, which is in one of the two
// runs of fast that come before the next: 6 + 4 and 20 + 6 + 4.
TEST_F(PromiseTest, WhoIsAboveItsLeaderWithAPauseMeetsOneOfItsRuns) {
  member(kFast).pause = Millis{60};
  member(kFast).period = Millis{1};
  member(kSlow).period = Millis{1};
  std::swap(member(kFast).priority, member(kSlow).priority);
  std::sort(plan.cores[0].members.begin(), plan.cores[0].members.end(),
            [](const Member& a, const Member& b) { return a.priority > b.priority; });
  EXPECT_EQ(promised(kFast).period, Millis{86});
  EXPECT_EQ(promised(kSlow).period, Millis{86 + 66});
  EXPECT_EQ(promised(kSlow).execution, Millis{20});
  costs.set_runs_per_output(*app.graph.find_node("scan"), 3.0);
  EXPECT_EQ(promised(kSlow).period, Millis{86 + 5 * 66}) << "one of six runs";
  costs.set_wait(*app.graph.find_node("map"), Millis{5});
  EXPECT_EQ(promised(kSlow).period, 6.0 * promised(kFast).period) << "fast may run while it waits";
}

// fast gives an output in every third run, each second of which triggers slow: it comes every 120 ms on average, but
// those below it are promised what holds when it comes every 40 ms.
TEST_F(PromiseTest, WhoIsTriggeredByOutputsComesAsSeldomAsTheyDo) {
  const Promise before = promised(kBatch);
  costs.set_runs_per_output(*app.graph.find_node("scan"), 3.0);
  EXPECT_EQ(promised(kSlow).period, Millis{120});
  EXPECT_EQ(promised(kSlow).execution, Millis{32});
  EXPECT_EQ(promised(kBatch).execution, before.execution);
}

TEST_F(PromiseTest, SlackMakesRunsLonger) {
  plan.slack = 0.04;
  EXPECT_EQ(promised(kFast).execution, Millis{6.25});
}

TEST_F(PromiseTest, AWaitMakesARunLongerAndBringsTheNextOneCloser) {
  costs.set_wait(*app.graph.find_node("scan"), Millis{9});
  EXPECT_EQ(promised(kFast).execution, Millis{6 + 9});
  EXPECT_EQ(promised(kFast).period, Millis{20});
  // What a run of fast has left after its wait and the next run may come 9 ms closer than 20: three in 38 ms.
  EXPECT_EQ(promised(kSlow).execution, Millis{20 + 3 * 6});
  costs.set_wait(*app.graph.find_node("map"), Millis{5});
  EXPECT_EQ(promised(kSlow).execution, Millis{20 + 5 + 3 * 6}) << "its own wait is added once";
}

TEST_F(PromiseTest, AShortWaitCountsAsWorkWhereThatIsLess) {
  costs.set_wait(*app.graph.find_node("map"), Millis{1});
  // slow takes 33 ms with what interrupts it, so that its runs may come 13 ms closer: three of them. As work, it is two
  // of 21 ms.
  EXPECT_EQ(promised(kBatch).execution, Millis{4 + 2 * 21 + 4 * 6});
}

TEST_F(PromiseTest, ARunOfAnUnboundedWaitIsNotPromised) {
  member(kFast).period = Millis{6};
  EXPECT_FALSE(promise(plan, app, costs));
}

TEST_F(PromiseTest, WhoRunsLongerThanItsPeriodIsPromisedWhatItTakes) {
  member(kBatch).pause.reset();
  EXPECT_EQ(promised(kBatch).period, promised(kBatch).execution);
}

TEST_F(PromiseTest, ManyShortInterruptionsAreBoundedByALine) {
  costs.set(*app.graph.find_node("scan"), model::CostProfile::constant(Millis{0.1}));
  costs.set(*app.graph.find_node("steer"), model::CostProfile::constant(Millis{0.1}));
  costs.set(*app.graph.find_node("map"), model::CostProfile::constant(Millis{500}));
  member(kFast).period = Millis{0.25};
  member(kSlow).after->every = 40'000;
  const double exact = 500 / (1 - 0.2 / 0.25);  // to one run of fast
  EXPECT_GE(promised(kSlow).execution.count(), exact - 1e-6);
  EXPECT_LE(promised(kSlow).execution.count(), exact + 0.2 / (1 - 0.2 / 0.25) + 1e-6);
}

// While a run of fast is pending, which gives none of the outputs meanwhile that trigger slow, that interrupts it once.
TEST_F(PromiseTest, WhoRunsBelowItsFollowerIsInterruptedByItOnce) {
  std::swap(member(kFast).priority, member(kSlow).priority);
  std::swap(plan.cores[0].members[0], plan.cores[0].members[1]);
  EXPECT_EQ(promised(kSlow).execution, Millis{20});
  EXPECT_EQ(promised(kFast).execution, Millis{6 + 20});
}

// Others run while fast waits, and it may give an output before slow has run. Their runs then make one another longer
// and less even, where slow is not held apart by a period.
TEST_F(PromiseTest, WhoWaitsBelowItsFollowerIsPromisedWhatTheFollowersPeriodAllows) {
  std::swap(member(kFast).priority, member(kSlow).priority);
  std::swap(plan.cores[0].members[0], plan.cores[0].members[1]);
  costs.set_wait(*app.graph.find_node("scan"), Millis{1});
  EXPECT_FALSE(promise(plan, app, costs));
  member(kSlow).period = Millis{40};
  EXPECT_EQ(promised(kFast).execution, Millis{6 + 1 + 20});
  plan.cores[0].members.pop_back();
  costs.set(*app.graph.find_node("scan"), model::CostProfile::constant(Millis{200 - 4}));
  EXPECT_EQ(promised(kFast).execution, Millis{200 + 1 + 13 * 20}) << "once each 40 ms, and once more";
}

// Beyond that it would be triggered without outputs.
TEST_F(PromiseTest, WhoRunsBelowItsFollowerForLongIsInterruptedAsOftenAsItsPeriodAllows) {
  std::swap(member(kFast).priority, member(kSlow).priority);
  std::swap(plan.cores[0].members[0], plan.cores[0].members[1]);
  plan.cores[0].members.pop_back();
  member(kSlow).period = Millis{40};
  member(kSlow).after->every = 1;
  member(kFast).pause = Millis{1};
  const auto with_cost = [&](Millis cost) {
    costs.set(*app.graph.find_node("scan"), model::CostProfile::constant(cost - Millis{4}));
    return promised(kFast).execution;
  };
  EXPECT_EQ(with_cost(Millis{970}), Millis{970 + 20});
  EXPECT_EQ(with_cost(Millis{990}), Millis{990 + 3 * 20});
}

TEST_F(PromiseTest, AFollowedElementAddsItsExecutionAlone) {
  member(kSlow).after->every = 1;
  Prediction prediction = predict(app, costs, plan.subchains, plan.cores);
  const std::vector<NodeId> path{*app.graph.find_node("scan"), *app.graph.find_node("map")};
  graph::App other = app;
  other.objective = {{graph::Metric::kResponseTime, path, 1.0, {}}};
  prediction = predict(other, costs, plan.subchains, plan.cores);
  const Millis run = plan.subchains[kFast.index()].execution + plan.subchains[kSlow.index()].execution;
  EXPECT_EQ(prediction.chains[0].latency, run);
  EXPECT_EQ(predict(other, costs, plan.subchains, {}).chains[0].latency, run + plan.subchains[kSlow.index()].period);
}

// An output of its leader may be as late as the leader's run may end, and the next one as early as that costs nothing.
TEST_F(PromiseTest, AnElementThatFollowsAnotherThanTheOneBeforeWaitsForALateOutput) {
  graph::App other = app;
  other.objective = {{graph::Metric::kResponseTime, {*app.graph.find_node("map")}, 1.0, {}}};
  const auto response = [&] { return predict(other, costs, plan.subchains, plan.cores).chains[0].response; };
  const SubchainPlan& slow = plan.subchains[kSlow.index()];
  const Millis run = plan.subchains[kFast.index()].execution;
  EXPECT_EQ(response(), slow.execution + slow.period + run);
  // Paced by its own runs, the leader waits for their ends.
  member(kFast).pause = member(kFast).period + Millis{1};
  EXPECT_EQ(response(), slow.execution + slow.period);
  member(kFast).pause = member(kFast).period - Millis{1};
  EXPECT_EQ(response(), slow.execution + slow.period + std::min(2 * Millis{1}, run));
}

TEST_F(PromiseTest, WhoMayBeHeldBackByItsPeriodDoesNotFollow) {
  graph::App other = app;
  other.objective = {
      {graph::Metric::kResponseTime, {*app.graph.find_node("scan"), *app.graph.find_node("map")}, 1.0, {}}};
  const auto latency = [&] { return predict(other, costs, plan.subchains, plan.cores).chains[0].latency; };
  const SubchainPlan& slow = plan.subchains[kSlow.index()];
  const Millis run = plan.subchains[kFast.index()].execution;
  EXPECT_EQ(latency(), run + slow.execution);
  member(kSlow).period = 2 * member(kFast).period + Millis{1};
  EXPECT_EQ(latency(), run + slow.execution + slow.period + run);
}

TEST_F(PromiseTest, APlanWithFixedPrioritiesIsValidAndReadBackAsItWas) {
  EXPECT_EQ(problems(), "");
  const Result<Plan> read = from_json(to_json(plan, app), app, "plan.json");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(*read, plan);
}

TEST_F(PromiseTest, WhatIsWrongWithMembersIsNamed) {
  const Plan good = plan;
  const auto problem_of = [&](auto change) {
    plan = good;
    change();
    return problems();
  };
  const auto expect = [](const std::string& problems, const std::string& part) {
    EXPECT_NE(problems.find(part), std::string::npos) << problems;
  };
  expect(problem_of([&] { plan.cores[0].members.pop_back(); }), "the members of this core must be: fast, slow, log");
  expect(problem_of([&] { member(kFast).priority = 7; }), "cores[0].members[0].priority");
  expect(problem_of([&] { member(kFast).budget = Millis{5}; }), "less than the compute time");
  expect(problem_of([&] { member(kFast).phase = Millis{20}; }), "cores[0].members[0].phase_ms");
  expect(problem_of([&] { member(kFast).period = Millis{0}; }), "needs a period");
  expect(problem_of([&] { member(kFast).period = Millis{6}; }), "leave those below them no time");
  expect(problem_of([&] {
           member(kFast).period = Millis{9};
           plan.subchains[kFast.index()].period = Millis{9};
         }),
         "max_rate");
  expect(problem_of([&] { member(kSlow).pause = Millis{1}; }), "cores[0].members[1].after");
  expect(problem_of([&] {
           member(kFast).after = After{kSlow, 1};
           member(kFast).phase = Millis{0};
         }),
         "its own outputs trigger");
  expect(problem_of([&] { plan.subchains[kFast.index()].period = Millis{21}; }), "response-time analysis");
  expect(problem_of([&] { plan.cores[1].members = plan.cores[0].members; }), "has slots, not members");
  expect(problem_of([&] { plan.cores[0].slots.push_back({kFast, Millis{0}, Millis{6}, 1, 0}); }), "has no slots");
}

// What an unscheduled node sends is as late as its own run and those of the nodes that it follows.
TEST(PromiseOfArrivals, AReaderComesWithTheSensorAndAddsItsOwnRunAlone) {
  graph::AppSpec spec = graph::spec_of({"imu", "fuse", "read", "slow"}, {"imu fuse read", "read slow"});
  for (const char* name : {"imu", "fuse"}) graph::node(spec, name).unscheduled = true;
  graph::node(spec, "imu").period = graph::At<Nanos>{std::chrono::milliseconds{5}, {}};
  spec.objective = {graph::response("imu fuse read", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  model::CostTable costs(app.graph, Millis{1});
  costs.set(*app.graph.find_node("imu"), model::CostProfile::constant(Millis{0.25}));
  costs.set(*app.graph.find_node("fuse"), model::CostProfile::constant(Millis{0.5}));
  Plan plan;
  plan.planner = "by hand";
  plan.cores.resize(1);
  plan.cores[0].form = Form::kPriorities;
  const NodeId fuse = *app.graph.find_node("fuse");
  Member read;
  read.subchain = SubchainId(std::size_t{0});
  read.priority = 2;
  read.period = Millis{4};
  read.after = After{fuse, 1};
  read.budget = Millis{2};
  Member slow;
  slow.subchain = SubchainId(std::size_t{1});
  slow.period = Millis{20};
  slow.budget = Millis{2};
  plan.cores[0].members = {read, slow};
  plan.subchains.assign(2, SubchainPlan{.cores = {0}, .every = 1, .slice = Millis{1}});
  const auto fill = [&] {
    const std::vector<Promise> promises = promise(plan, app, costs).value();
    for (std::size_t i = 0; i < 2; ++i) {
      plan.subchains[i].period = promises[i].period;
      plan.subchains[i].execution = promises[i].execution;
    }
    fill_predictions(plan, app, costs);
    return promises;
  };
  EXPECT_EQ(fill()[0].period, Millis{5});
  EXPECT_EQ(plan.chains[0].latency, Millis{0.25 + 0.5 + 1}) << "fuse begins when imu ends";
  EXPECT_EQ(plan.chains[0].period, Millis{5});
  const Status valid = validate(plan, app, costs, 1);
  EXPECT_TRUE(valid.ok()) << valid.error().message();
  const Result<Plan> back = from_json(to_json(plan, app), app, "plan.json");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(*back, plan);

  // In 14 ms three outputs come 5 ms apart, each with a run of imu and of fuse.
  costs.set(*app.graph.find_node("slow"), model::CostProfile::constant(Millis{8}));
  plan.cores[0].members[0].period = Millis{0};
  EXPECT_EQ(fill()[1].execution, Millis{8 + 3 * (0.25 + 0.5 + 1)});
  plan.cores[0].members[0].after->every = 3;
  EXPECT_EQ(fill()[1].execution, Millis{8 + 1 + 3 * (0.25 + 0.5)});
  EXPECT_EQ(fill()[0].period, Millis{15});
  EXPECT_EQ(plan.chains[0].latency, Millis{0.25 + 0.5 + 1}) << "it takes the output that triggers it";
  EXPECT_EQ(plan.chains[0].period, Millis{15});

  plan.cores[0].members[0].after->leader = *app.graph.find_node("slow");
  const Status wrong = validate(plan, app, costs, 1);
  EXPECT_NE(wrong.error().message().find("cores[0].members[0].after.node"), std::string::npos);
}

TEST(WhyAbovePromise, NamesWhatThePlanHasAlone) {
  graph::AppSpec spec = graph::spec_of({"imu", "read", "slow"}, {"imu read"});
  graph::node(spec, "imu").unscheduled = true;
  graph::node(spec, "imu").period = graph::At<Nanos>{std::chrono::milliseconds{5}, {}};
  graph::node(spec, "slow").max_rate = graph::At<Rate>{Rate{1.0}, {}};
  spec.objective = {graph::response("imu read", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  Plan plan;
  plan.cores.resize(1);
  plan.subchains.assign(2, SubchainPlan{.cores = {0}, .every = 1, .slice = Millis{1}});
  plan.subchains[1].share = 0.1;
  const std::string scheduling = "no promise has in it what scheduling itself takes";
  for (std::size_t i = 0; i < 2; ++i) {
    Member& member = plan.cores[0].members.emplace_back();
    member.subchain = SubchainId(i);
  }
  EXPECT_EQ(why_above_promise(plan, app), scheduling) << "not unscheduled nodes";
  plan.cores[0].members.clear();
  plan.cores[0].slots = {{SubchainId(0), Millis{0}, Millis{1}, {}, 0}, {SubchainId(1), Millis{1}, Millis{1}, {}, 0}};
  const std::string load = ", nor what load unscheduled nodes are for subchains in frames or with cores of their own";
  EXPECT_EQ(why_above_promise(plan, app),
            scheduling + load + ", nor for how long elastic frames defer a run whose rate is capped");
  plan.cores[0].frames = graph::FrameMode::kFixed;
  EXPECT_EQ(why_above_promise(plan, app), scheduling + load);
}

}  // namespace
}  // namespace ctn::plan
