#include "policy/policy.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "config/testing/apps.h"
#include "plan/limits.h"
#include "plan/validate.h"
#include "policy/planned.h"
#include "policy/replan.h"

namespace ctn::policy {
namespace {

using std::chrono::milliseconds;

Result<Decision> decided(const char* policy, const graph::App& app) {
  const model::CostTable costs(app.graph, Millis{5});
  const os::CpuSet cpus{2, 3};
  return (*make_policy(policy))->decide({.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06});
}

double rate(const Decision& decision) { return Rate::every(decision.assignment.places.front().pacing.period).hertz(); }

TEST(Policy, KnowsItsNames) {
  EXPECT_TRUE((*make_policy("catan"))->adapts());
  EXPECT_TRUE((*make_policy("catan"))->follows_plan());
  EXPECT_TRUE((*make_policy("fifo"))->raises());
  EXPECT_FALSE((*make_policy("fifo"))->follows_plan());
  EXPECT_FALSE((*make_policy("default"))->raises());
  for (const char* name : {"catan", "auto", "paper", "default", "fifo", "rate:12.5Hz"}) {
    EXPECT_EQ((*make_policy(name))->name(), name);
  }
}

TEST(Policy, SaysWhatWouldBeRight) {
  for (const char* text : {"", "catn", "static:", "fifo:", "rate:", "rate:-3", "rate:fast", "rate:0"}) {
    const auto policy = make_policy(text);
    ASSERT_FALSE(policy.ok()) << text;
    EXPECT_NE(policy.error().message().find("rate:12.5"), std::string::npos);
  }
}

graph::App exact(const char* a, const char* b) {
  const auto node = [](const std::string& rate) { return "{ min_rate: " + rate + ", max_rate: " + rate + " }"; };
  return parse("catan: 1\napp: exact\nnodes: { a: " + node(a) + ", b: " + node(b) +
               " }\nobjective: [ { period: a, weight: 1 }, { period: b, weight: 1 } ]\n");
}

TEST(FormulaPolicy, LowersAssumedCostsUntilExactRatesCanBeMet) {
  const graph::App app = exact("240Hz", "120Hz");
  const model::CostTable costs(app.graph, Millis{5});
  const os::CpuSet cpus{0};
  const std::vector<NodeId> assumed{NodeId(0), NodeId(1)};
  Situation situation{.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06};
  situation.assumed = assumed;
  const auto decision = FormulaPolicy().decide(situation);
  ASSERT_TRUE(decision.ok()) << decision.error().message();
  const plan::Plan& plan = *decision->plan;
  // Each frame of 4.17 ms has room for a and half of b: 3.75 ms, and 6 % of slack.
  EXPECT_EQ(plan.assumed, (std::vector<plan::AssumedCost>{{NodeId(0), Millis{2.5}}, {NodeId(1), Millis{2.5}}}));
  EXPECT_DOUBLE_EQ(plan.subchains[0].period.count(), 1000.0 / 240);
  EXPECT_DOUBLE_EQ(plan.subchains[1].period.count(), 1000.0 / 120);
  EXPECT_EQ(plan.relax_factor, 1.0);
}

// What cannot be met in frames whatever nodes cost, and what cannot be met at costs that are known.
TEST(FormulaPolicy, RelaxesExactRatesThatCannotBeMet) {
  for (const auto& [app, are_assumed] :
       {std::pair{in_frames(exact("120Hz", "50.1Hz")), true}, {exact("200Hz", "100Hz"), false}}) {
    const model::CostTable costs(app.graph, Millis{5});
    const os::CpuSet cpus{0};
    const std::vector<NodeId> assumed{NodeId(0), NodeId(1)};
    Situation situation{.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06};
    if (are_assumed) situation.assumed = assumed;
    const auto decision = FormulaPolicy().decide(situation);
    ASSERT_TRUE(decision.ok()) << decision.error().message();
    const plan::Plan& plan = *decision->plan;
    EXPECT_TRUE(plan::relaxes_exact_rates(plan, app));
    EXPECT_GT(plan.relax_factor, 1.0);
    const Status valid = plan::validate(plan, app, costs, 1);
    EXPECT_TRUE(valid.ok()) << valid.error().message();
    for (const plan::SubchainPlan& subchain : plan.subchains) {
      const NodeId node(static_cast<std::size_t>(&subchain - plan.subchains.data()));
      EXPECT_GE(subchain.period, app.graph.node(node).max_rate->period()) << "a cap is a cap";
      EXPECT_LE(subchain.period, app.graph.node(node).min_rate->period() * plan.relax_factor * (1.0 + 1e-9));
    }
  }
}

TEST(FormulaPolicy, FixedPrioritiesMeetExactRatesThatFramesCannot) {
  const graph::App app = exact("120Hz", "50.1Hz");
  const model::CostTable costs(app.graph, Millis{5});
  const os::CpuSet cpus{0};
  const auto decision =
      FormulaPolicy().decide({.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06});
  ASSERT_TRUE(decision.ok()) << decision.error().message();
  EXPECT_EQ(decision->plan->cores[0].form, plan::Form::kPriorities);
  EXPECT_EQ(decision->plan->relax_factor, 1.0);
  EXPECT_TRUE(decision->plan->assumed.empty());
  EXPECT_TRUE(plan::validate(*decision->plan, app, costs, 1).ok());
}

TEST(FormulaPolicy, IsReplacedOnlyByAPlanThatIsBetter) {
  const graph::App app = parse(R"(
catan: 1
app: two
nodes: { a: {}, b: {}, c: {} }
edges: [ a -> b -> c ]
objective: [ { response_time: [a, b, c], weight: 1 } ]
)");
  const model::CostTable costs(app.graph, Millis{5});
  const os::CpuSet cpus{0, 1};
  const FormulaPolicy policy;
  Situation situation{.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06};
  situation.why = PlanReason::kPeriodic;
  const auto first = policy.decide(situation);
  ASSERT_TRUE(first.ok());
  const auto none = replacement(policy, situation, *first);
  ASSERT_TRUE(none.ok());
  EXPECT_FALSE(*none);
  situation.why = PlanReason::kMeasured;
  const auto replanned = replacement(policy, situation, *first);
  ASSERT_TRUE(replanned.ok());
  ASSERT_TRUE(*replanned);
  EXPECT_EQ((*replanned)->plan->objective, first->plan->objective);
  EXPECT_TRUE((*replanned)->plan->expected);
}

TEST(FormulaPolicy, SharesCoresAsTheAppSays) {
  graph::App app = robot_app();
  const model::CostTable costs(app.graph, Millis{5});
  const os::CpuSet cpus{0};
  const auto core = [&](graph::ScheduleKind schedule) {
    app.scheduler.schedule = schedule;
    const Situation situation{.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06};
    return FormulaPolicy().decide(situation)->plan->cores[0];
  };
  EXPECT_EQ(core(graph::ScheduleKind::kAuto).form, plan::Form::kFrames) << "they keep the slack whatever runs cost";
  EXPECT_EQ(core(graph::ScheduleKind::kFrames).frames, graph::FrameMode::kElastic);
  EXPECT_EQ(core(graph::ScheduleKind::kPriorities).form, plan::Form::kPriorities);
}

TEST(HandSetRates, TakeTheFallbackOrTheGivenRate) {
  const graph::App app = tracker_app();
  EXPECT_NEAR(rate(*decided("default", app)), 30.0, 1e-6);
  EXPECT_NEAR(rate(*decided("rate:8", app)), 8.0, 1e-6);
  EXPECT_FALSE(decided("default", app)->plan);
}

TEST(HandSetRates, NameEveryHeadThatHasNone) {
  const graph::App app = parse(R"(
catan: 1
app: two
nodes: { a: {}, b: {} }
edges: [ a -> b ]
objective: [ { response_time: [a, b], weight: 1 } ]
)");
  const auto all = decided("default", app);
  ASSERT_FALSE(all.ok());
  EXPECT_EQ(all.error().problems().size(), 2U);
  EXPECT_EQ(all.error().problems()[1].key, "nodes.b.fallback_rate");
  EXPECT_EQ(decided("rate:8", app).error().problems().size(), 1U) << "a is a source";
}

TEST(HandSetRates, AreThoseOfNodesWithinSubchainsToo) {
  const graph::App app = own_rates_app();
  for (const char* const name : {"default", "fifo"}) {
    const auto policy = *make_policy(name);
    const graph::App cut = as_run_by(*policy, app);
    const Decision decision = *decided(name, cut);
    ASSERT_EQ(decision.assignment.places.size(), 3U) << "scan; LP and push; LM";
    const auto period = [&](const char* subchain) {
      return decision.assignment.places[cut.graph.find_subchain(subchain)->index()].pacing.period;
    };
    EXPECT_EQ(period("local"), milliseconds{50});
    EXPECT_EQ(period("LM"), milliseconds{200});
    EXPECT_EQ(period("LP"), milliseconds{100});
  }
  const Decision fifo = *decided("fifo", as_run_by(**make_policy("fifo"), app));
  EXPECT_EQ(fifo.assignment.places[0].level, os::fixed_level(2)) << "scan above LM above LP";
  EXPECT_EQ(fifo.assignment.places[1].level, os::fixed_level(0));
  EXPECT_EQ(fifo.assignment.places[2].level, os::fixed_level(1));
}

TEST(HandSetRates, LeaveSubchainsWholeUnderOtherPolicies) {
  const graph::App app = own_rates_app();
  for (const char* const name : {"catan", "paper", "rate:8"}) {
    EXPECT_EQ(as_run_by(**make_policy(name), app).graph.subchains().size(), 1U) << name;
  }
  EXPECT_NEAR(rate(*decided("rate:8", app)), 8.0, 1e-6);
}

TEST(FixedPriorities, FollowTheOrderOfStealing) {
  const graph::App app = parse(R"(
catan: 1
app: two
nodes: { a: { fallback_rate: 10Hz }, b: { fallback_rate: 20Hz } }
edges: [ a -> b ]
objective: [ { response_time: [a, b], weight: 1 } ]
steal: { priority: [b, a], off: [] }
)");
  const Decision decision = *decided("fifo", app);
  const std::vector<SubchainPlace>& places = decision.assignment.places;
  EXPECT_EQ(places[app.graph.find_subchain("a")->index()].level, os::fixed_level(0));
  EXPECT_EQ(places[app.graph.find_subchain("b")->index()].level, os::fixed_level(1));
  EXPECT_EQ(places[0].cpus, (os::CpuSet{2, 3}));
  EXPECT_EQ(decision.unscheduled_level, os::fixed_level(2));
  EXPECT_EQ(decision.dispatcher_level, os::fixed_level(3));
}

TEST(Catan, PlansForTheCpusThatThereAre) {
  const Decision decision = *decided("catan", tracker_app());
  ASSERT_TRUE(decision.plan);
  EXPECT_TRUE(decision.plan->expected);
  EXPECT_EQ(decision.plan->cores.size(), 2U);
  EXPECT_EQ(decision.assignment.places.front().level, os::Level::kActive);
  EXPECT_EQ(decision.dispatcher_level, os::Level::kDispatcher);
}

TEST(AGivenPlan, IsFollowedWhateverItWouldBeNow) {
  const graph::App app = tracker_app();
  const Decision planned = *decided("catan", app);
  const StaticPolicy policy("static:plan.json", *planned.plan);
  EXPECT_EQ(policy.name(), "static:plan.json");
  EXPECT_TRUE(policy.follows_plan());
  EXPECT_FALSE(policy.adapts());
  const model::CostTable costs(app.graph, Millis{50});
  for (const os::CpuSet& cpus : {os::CpuSet{2, 3}, os::CpuSet{2}}) {
    const auto decision = policy.decide({.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06});
    EXPECT_EQ(decision.ok(), cpus.size() == 2) << "made for two cores";
    if (decision) {
      EXPECT_EQ(decision->plan, planned.plan);
    }
  }
}

}  // namespace
}  // namespace ctn::policy
