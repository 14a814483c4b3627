// Decisions one after the other, as a planning loop asks for them.
#include "policy/search_policy.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <utility>
#include <vector>

#include "config/testing/apps.h"
#include "plan/validate.h"
#include "planner/testing/random_apps.h"

namespace ctn::policy {
namespace {

constexpr double kSlack = 0.06;

constexpr const char* kTwoChains = R"(
catan: 1
app: three
nodes: { a: {}, b: {}, c: {}, base: { external: true } }
edges: [ a -> b -> base, a -> c -> b ]
objective:
  - { response_time: [a, b, base], weight: 1 }
  - { response_time: [a, c, b, base], weight: 0.05 }
scheduler: { slack: 6% }
)";

// What a planning loop would have, of an app on its first cores.
struct Asked {
  Asked(graph::App of, int count)
      : app(std::move(of)),
        costs(app.graph, Millis{1}),
        runs(app.graph.nodes().size(), std::vector<std::vector<model::RunTime>>(app.kinds())),
        memory(policy.make_memory()) {
    std::vector<int> numbers;
    for (int cpu = 0; cpu < count; ++cpu) numbers.push_back(cpu);
    cpus = os::CpuSet(numbers);
    in_force = policy.decide({.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = kSlack}).value();
  }

  // All runs of the node take so long.
  void cost(NodeId node, Millis cpu) {
    costs.set(node, model::CostProfile::constant(cpu));
    for (std::vector<model::RunTime>& kind : runs[node.index()]) kind = {{to_nanos(cpu), to_nanos(costs.wait(node))}};
  }
  // ... and wait so long.
  void wait(NodeId node, Millis time) {
    costs.set_wait(node, time);
    cost(node, costs[node].single_thread());
  }

  // Whether what is in force was replaced.
  bool decide(PlanReason why) {
    Result<std::optional<Decision>> decision = policy.decide_again({.app = app,
                                                                    .cpus = cpus,
                                                                    .costs = costs,
                                                                    .typical = typical ? *typical : costs,
                                                                    .slack = kSlack,
                                                                    .why = why,
                                                                    .runs = &runs,
                                                                    .min_runs = kRuns,
                                                                    .step_factor = step_factor,
                                                                    .memory = memory.get()},
                                                                   in_force);
    if (!decision || !*decision) return false;
    in_force = std::move(**decision);
    return true;
  }

  // The first plan of costs as they are, and some steps of the loop that make it better.
  void search(int steps = 20) {
    decide(PlanReason::kMeasured);
    for (; steps > 0 && goes_on(); --steps) decide(PlanReason::kPeriodic);
  }
  // ... until nothing more is found.
  void settle() { search(1000); }

  bool goes_on() const { return memory->more_to_do(kRuns); }

  static constexpr std::size_t kRuns = 1000;
  SearchPolicy policy;
  graph::App app;
  model::CostTable costs;
  trial::MeasuredRuns runs;
  std::optional<model::CostTable> typical;  // none: as the percentile
  double step_factor = 1.0;
  std::unique_ptr<Memory> memory;
  os::CpuSet cpus;
  Decision in_force;
};

struct Three : Asked {
  Three() : Asked(parse(kTwoChains), 1) {
    cost(NodeId(0), Millis{1});
    cost(NodeId(1), Millis{2});
    cost(NodeId(2), Millis{40});
  }
};

TEST(SearchPolicy, TheFirstPlanOfMeasuredCostsReplacesAnyOther) {
  Three asked;
  EXPECT_EQ(asked.in_force.plan->cores[0].form, plan::Form::kFrames);
  ASSERT_TRUE(asked.decide(PlanReason::kMeasured));
  EXPECT_EQ(asked.in_force.plan->planner, "auto");
  EXPECT_EQ(asked.in_force.plan->cores[0].form, plan::Form::kPriorities);
  EXPECT_TRUE(asked.in_force.plan->expected);
}

constexpr const char* kApart = R"(
catan: 1
app: apart
nodes:
  fast: { trigger: arrival }
  middle: { trigger: time }
  slow: { trigger: time }
  camera: { unscheduled: true, period: 40ms }
  base: { external: true }
edges: [ camera -> fast -> base, middle -> base, slow -> base ]
objective:
  - { response_time: [camera, fast, base], weight: 1 }
  - { response_time: [middle, base], weight: 0.2 }
  - { response_time: [slow, base], weight: 0.02 }
scheduler: { slack: 6% }
)";

// Some runs of `fast` take 60 ms in place of 2: they decide by their number alone what its 95th percentile is. It is
// triggered by every n-th picture, 40 ms apart, and by nothing else: a promise for long runs costs whole pictures.
struct Spikes : Asked {
  Spikes() : Asked(parse(kApart), 1) {
    cost(NodeId(1), Millis{20});
    cost(NodeId(2), Millis{100});
    see(1, Millis{2});
  }

  // So many of 20.
  void see(std::size_t spikes, Millis percentile) {
    cost(NodeId(0), Millis{2});
    typical = costs;
    cost(NodeId(0), percentile);
    for (std::vector<model::RunTime>& kind : runs[0]) {
      kind.assign(20 - spikes, {to_nanos(Millis{2}), Nanos{0}});
      kind.resize(20, {to_nanos(Millis{60}), Nanos{0}});
    }
  }

  double period_of_fast() const { return in_force.plan->subchains[0].period.count(); }
};

TEST(SearchPolicy, PromisesForTypicalCostsWhereNoMoreIsAskedFor) {
  Spikes unbounded;
  unbounded.settle();
  EXPECT_FALSE(unbounded.in_force.plan->for_typical);
  const double before = unbounded.period_of_fast();
  unbounded.see(2, Millis{60});
  ASSERT_TRUE(unbounded.decide(PlanReason::kPeriodic));
  const plan::Plan& plan = *unbounded.in_force.plan;
  EXPECT_TRUE(plan.for_typical);
  EXPECT_LT(unbounded.period_of_fast(), 1.5 * before) << "it goes on";
  EXPECT_TRUE(plan::validate(plan, unbounded.app, *unbounded.typical, 1).ok());
  EXPECT_FALSE(plan::validate(plan, unbounded.app, unbounded.costs, 1).ok());

  Spikes bounded;
  bounded.app.objective[1].max = std::chrono::seconds{100};
  bounded.settle();
  bounded.see(2, Millis{60});
  ASSERT_TRUE(bounded.decide(PlanReason::kPeriodic));
  EXPECT_FALSE(bounded.in_force.plan->for_typical);
  EXPECT_TRUE(plan::validate(*bounded.in_force.plan, bounded.app, bounded.costs, 1).ok());
  EXPECT_GT(bounded.period_of_fast(), 1.9 * before) << "60 ms do not fit between two pictures";
  EXPECT_LT(plan.expected->objective, 0.95 * bounded.in_force.plan->expected->objective);
}

TEST(SearchPolicy, GetsBetterAndComesToRest) {
  Three asked;
  asked.decide(PlanReason::kMeasured);
  const double first = asked.in_force.plan->expected->objective;
  int steps = 0;
  int swaps = 0;
  for (; asked.goes_on(); ++steps) {
    ASSERT_LT(steps, 1000);
    swaps += asked.decide(PlanReason::kPeriodic) ? 1 : 0;
  }
  EXPECT_LE(asked.in_force.plan->expected->objective, first);
  EXPECT_LE(swaps, steps / 5);
  EXPECT_FALSE(asked.decide(PlanReason::kPeriodic)) << "nothing has changed";
}

TEST(SearchPolicy, SavesItsTimeForWhenCostsAreBetterKnown) {
  Three asked;
  asked.decide(PlanReason::kMeasured);
  Nanos before{0};
  for (const std::size_t runs : {1U, 2U, 4U, 8U, 16U, 32U, 64U}) {
    for (int step = 0; asked.memory->more_to_do(runs); ++step) {
      ASSERT_LT(step, 100) << "it rests at some time";
      asked.decide(PlanReason::kPeriodic);
    }
    EXPECT_LT(asked.memory->work() - before, std::chrono::milliseconds{80}) << runs;
    before = asked.memory->work();
  }
  EXPECT_TRUE(asked.memory->more_to_do(1000));
}

TEST(SearchPolicy, CountsItsWork) {
  Three asked;
  Nanos before{0};
  for (int step = 0; step < 20; ++step) {
    asked.decide(step == 0 ? PlanReason::kMeasured : PlanReason::kPeriodic);
    const Nanos work = asked.memory->work() - before;
    EXPECT_GT(work, Nanos{0});
    EXPECT_LT(work, std::chrono::milliseconds{60});
    before += work;
  }
}

TEST(SearchPolicy, WhatGoesOnHasBudgetsThatFitNewCosts) {
  Three asked;
  asked.search();
  asked.cost(NodeId(2), Millis{48});
  EXPECT_TRUE(asked.decide(PlanReason::kPeriodic));
  const plan::Member* member = plan::member_of(*asked.in_force.plan, SubchainId(2));
  ASSERT_NE(member, nullptr);
  EXPECT_GE(member->budget, Millis{48});
}

TEST(SearchPolicy, WhatRunsWaitIsPlannedWithOnceItHasChanged) {
  Three asked;
  asked.search();
  const double before = asked.in_force.plan->expected->objective;
  asked.wait(NodeId(1), Millis{5});
  EXPECT_TRUE(asked.decide(PlanReason::kPeriodic));
  const plan::Plan& plan = *asked.in_force.plan;
  EXPECT_EQ(plan.subchains[1].wait, Millis{5});
  EXPECT_GT(plan.expected->objective, before + 4.5) << "it is in both chains, one of weight 1";
  const Status valid = plan::validate(plan, asked.app, asked.costs, 1);
  EXPECT_TRUE(valid.ok()) << valid.error().message();
}

TEST(SearchPolicy, OutputsOfOnlySomeRunsArePlannedWithAndTold) {
  Three asked;
  asked.search();
  const plan::Plan before = *asked.in_force.plan;
  EXPECT_TRUE(before.outputs.empty());
  asked.costs.set_runs_per_output(NodeId(0), 4.0);
  EXPECT_TRUE(asked.decide(PlanReason::kPeriodic));
  const std::vector<plan::RunsPerOutput> outputs{{NodeId(0), 4.0}};
  EXPECT_EQ(asked.in_force.plan->outputs, outputs) << "at once";
  asked.search();
  const plan::Plan& plan = *asked.in_force.plan;
  EXPECT_EQ(plan.outputs, outputs);
  EXPECT_GT(plan.expected->chains[0].period, 1.5 * before.expected->chains[0].period)
      << "of outputs, though it runs more often";
  EXPECT_GT(plan.expected->objective, before.expected->objective);
  const Status valid = plan::validate(plan, asked.app, asked.costs, 1);
  EXPECT_TRUE(valid.ok()) << valid.error().message();
  EXPECT_FALSE(asked.decide(PlanReason::kPeriodic) && !asked.goes_on()) << "nothing has changed since";
}

TEST(SearchPolicy, IdleRunsArePlannedWithOnceTheyAreKnown) {
  Asked asked(parse(R"(
catan: 1
app: polling
nodes: { camera: { external: true, period: 50ms }, grab: {}, track: {} }
edges: [ camera -> grab -> track ]
objective: [ { response_time: [camera, grab, track], weight: 1 }, { response_time: [track], weight: 1 } ]
scheduler: { slack: 6%, schedule: priorities }
)"),
              1);
  asked.cost(NodeId(1), Millis{2});
  asked.cost(NodeId(2), Millis{2});
  asked.settle();
  ASSERT_FALSE(asked.goes_on());
  asked.costs.set_idle(NodeId(1), {1.0, Millis{0.1}});
  ASSERT_TRUE(asked.decide(PlanReason::kPeriodic));
  EXPECT_TRUE(asked.goes_on());
  asked.settle();
  asked.costs.set_idle(NodeId(1), {1.0, Millis{0.2}});
  EXPECT_FALSE(asked.decide(PlanReason::kPeriodic)) << "no more than noise, beside what its other runs cost";
}

TEST(SearchPolicy, WhatItemsAddIsPlannedWithOnceItIsKnown) {
  Asked asked(parse(R"(
catan: 1
app: batches
nodes: { a: {}, b: { input: queue } }
edges: [ a -> b ]
objective: [ { response_time: [a], weight: 1 }, { response_time: [a, b], weight: 0.1 } ]
scheduler: { slack: 6%, schedule: priorities }
)"),
              1);
  asked.cost(NodeId(0), Millis{1});
  asked.cost(NodeId(1), Millis{4});
  asked.search();
  EXPECT_TRUE(asked.in_force.plan->batches.empty());
  asked.cost(NodeId(1), Millis{2});
  asked.costs.set(NodeId(1), asked.costs[NodeId(1)].with_per_item(Millis{0.5}));
  EXPECT_TRUE(asked.decide(PlanReason::kPeriodic));
  const plan::Plan& plan = *asked.in_force.plan;
  ASSERT_EQ(plan.batches.size(), 1U);
  EXPECT_DOUBLE_EQ(plan.subchains[1].slice.count(), 2.0 + 0.5 * plan.batches[0].items);
  const plan::Member* const member = plan::member_of(plan, SubchainId(1));
  ASSERT_NE(member, nullptr);
  EXPECT_GE(member->budget, plan.subchains[1].slice) << "what a batch may cost at worst";
  const Status valid = plan::validate(plan, asked.app, asked.costs, 1);
  EXPECT_TRUE(valid.ok()) << valid.error().message();
}

TEST(SearchPolicy, WhatRunsTakeOnSeveralThreadsIsPlannedWithOnceItIsMeasured) {
  Asked asked(parse(R"(
catan: 1
app: lone
nodes: { lone: { max_threads: 2 } }
objective: [ { response_time: [lone], weight: 1 } ]
scheduler: { slack: 0% }
)"),
              2);
  asked.cost(NodeId(0), Millis{10});
  ASSERT_TRUE(asked.decide(PlanReason::kMeasured));
  EXPECT_EQ(asked.in_force.plan->subchains[0].threads, 2) << "taken to scale";
  asked.costs.set(NodeId(0), model::CostProfile::constant(Millis{10}).with_measured({{2, Millis{11}}}));
  for (int step = 0; step < 5; ++step) asked.decide(PlanReason::kPeriodic);
  EXPECT_EQ(asked.in_force.plan->subchains[0].threads, 1);
  const Status valid = plan::validate(*asked.in_force.plan, asked.app, asked.costs, 2);
  EXPECT_TRUE(valid.ok()) << valid.error().message();
}

// Runs of a millisecond, for which a controller takes a quarter of that.
TEST(SearchPolicy, WhatSchedulingTakesIsPlannedWith) {
  const auto expected = [](double factor) {
    Three asked;
    asked.step_factor = factor;
    asked.settle();  // a first guess is good or bad by luck
    return asked.in_force.plan->expected->objective;
  };
  EXPECT_GT(expected(20.0), 1.03 * expected(1.0));
}

TEST(SearchPolicy, NoiseInCostsIsNoReason) {
  Three asked;
  asked.settle();
  asked.cost(NodeId(2), Millis{41});
  const plan::Plan before = *asked.in_force.plan;
  EXPECT_FALSE(asked.decide(PlanReason::kPeriodic));
  EXPECT_EQ(*asked.in_force.plan, before);
}

TEST(SearchPolicy, FormulasDecideWhereAnExactRateCannotBeMet) {
  constexpr const char* kExact = R"(
catan: 1
app: exact
nodes: { a: { min_rate: 100Hz, max_rate: 100Hz }, b: {} }
edges: [ a -> b ]
subchains: { ab: [a, b] }
objective: [ { response_time: [a, b], weight: 1 } ]
scheduler: { slack: 6% }
)";
  Asked asked(parse(kExact), 1);
  asked.cost(NodeId(0), Millis{15});
  asked.cost(NodeId(1), Millis{1});
  ASSERT_TRUE(asked.decide(PlanReason::kMeasured));
  EXPECT_GT(asked.in_force.plan->relax_factor, 1.0);
  EXPECT_EQ(asked.in_force.plan->cores[0].form, plan::Form::kFrames);
  EXPECT_FALSE(asked.decide(PlanReason::kPeriodic)) << "nothing has changed";
  asked.cost(NodeId(0), Millis{5});
  ASSERT_TRUE(asked.decide(PlanReason::kChange));
  EXPECT_EQ(asked.in_force.plan->relax_factor, 1.0) << "now it can";
}

TEST(SearchPolicy, FormulasDecideForWhoRemembersNothing) {
  Three asked;
  asked.memory.reset();
  ASSERT_TRUE(asked.decide(PlanReason::kMeasured));
  EXPECT_EQ(asked.in_force.plan->cores[0].form, plan::Form::kFrames);
}

TEST(SearchPolicy, SharesCoresAsTheAppSays) {
  for (const auto schedule : {graph::ScheduleKind::kFrames, graph::ScheduleKind::kPriorities}) {
    graph::App app = parse(kTwoChains);
    app.scheduler.schedule = schedule;
    Asked asked(std::move(app), 1);
    const plan::Form form = schedule == graph::ScheduleKind::kFrames ? plan::Form::kFrames : plan::Form::kPriorities;
    EXPECT_EQ(asked.in_force.plan->cores[0].form, form) << "of assumed costs";
    asked.cost(NodeId(0), Millis{1});
    asked.cost(NodeId(1), Millis{2});
    asked.cost(NodeId(2), Millis{40});
    ASSERT_TRUE(asked.decide(PlanReason::kMeasured));
    EXPECT_EQ(asked.in_force.plan->cores[0].form, form);
    for (int step = 0; step < 20; ++step) {
      asked.decide(PlanReason::kPeriodic);
      EXPECT_EQ(asked.in_force.plan->cores[0].form, form);
    }
  }
}

RC_GTEST_PROP(SearchPolicyProperty, WhateverIsDecidedIsValid, (std::uint64_t seed)) {
  const int cores = 1 + static_cast<int>(seed % 3);
  const planner::RandomCase random = planner::random_case_of_all_sorts(seed, cores);
  Asked asked(random.app, cores);
  const auto cost_all = [&](double factor) {
    for (std::size_t i = 0; i < random.app.graph.nodes().size(); ++i) {
      const model::CostProfile& cost = random.costs[NodeId(i)];
      asked.cost(NodeId(i), cost.single_thread() * factor);
      asked.costs.set(NodeId(i), asked.costs[NodeId(i)].with_per_item(cost.per_item() * factor));
    }
  };
  for (const double factor : {1.0, 1.0, 1.3, 0.5}) {
    cost_all(factor);
    if (!asked.decide(factor == 1.0 ? PlanReason::kMeasured : PlanReason::kChange)) continue;
    const plan::Plan& plan = *asked.in_force.plan;
    const Status valid = plan::validate(plan, asked.app, asked.costs, cores);
    if (!valid) RC_FAIL(valid.error().message());
  }
}

}  // namespace
}  // namespace ctn::policy
