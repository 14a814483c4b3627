#include "policy/policy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "policy/test_app.h"

namespace ctn::policy {
namespace {

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
  EXPECT_TRUE((*make_policy("static:plans/one.json"))->follows_plan());
  EXPECT_FALSE((*make_policy("static:plans/one.json"))->adapts());
  EXPECT_FALSE((*make_policy("default"))->raises());
  for (const char* name : {"catan", "default", "fifo", "static:plans/one.json", "rate:12.5Hz"}) {
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

TEST(CatanPolicy, DecidesAnewOnlyForAPlanThatIsBetter) {
  const graph::App app = parse(R"(
catan: 1
app: two
nodes: { a: {}, b: {}, c: {} }
edges: [ a -> b -> c ]
objective: [ { response_time: [a, b, c], weight: 1 } ]
)");
  const model::CostTable costs(app.graph, Millis{5});
  const os::CpuSet cpus{0, 1};
  const auto policy = *make_policy("catan");
  const Situation situation{.app = app, .cpus = cpus, .costs = costs, .typical = costs, .slack = 0.06};
  const auto first = policy->decide(situation);
  ASSERT_TRUE(first.ok());
  const double objective = first->plan->objective;
  const auto none = policy->decide_anew(situation, *first, objective);
  ASSERT_TRUE(none.ok());
  EXPECT_FALSE(*none);
  for (const double to_beat : {1.001 * objective, std::numeric_limits<double>::infinity()}) {
    const auto anew = policy->decide_anew(situation, *first, to_beat);
    ASSERT_TRUE(anew.ok());
    ASSERT_TRUE(*anew);
    EXPECT_EQ((*anew)->plan->objective, objective);
    EXPECT_TRUE((*anew)->plan->expected);
  }
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

TEST(AGivenPlan, MustBeThere) { EXPECT_FALSE(decided("static:/nowhere/plan.json", tracker_app()).ok()); }

// Two chains of two subchains each, the second of more weight.
graph::App two_chains() {
  return parse(R"(
catan: 1
app: two
nodes:
  a: { fallback_rate: 10Hz }
  b: { fallback_rate: 20Hz }
  c: { fallback_rate: 5Hz }
  d: {}
  imu: { unscheduled: true, period: 5ms }
edges: [ a -> b, c -> d, imu -> c ]
subchains: { cd: [c, d] }
objective: [ { response_time: [a, b], weight: 1 }, { response_time: [c, d], weight: 2 } ]
)");
}

TEST(Compared, PicasKeepsChainsTogetherAndRanksTheirNodes) {
  const graph::App app = two_chains();
  const Decision decision = *decided("picas", app);
  const SubchainPlace& a = decision.assignment.places[app.graph.find_subchain("a")->index()];
  const SubchainPlace& b = decision.assignment.places[app.graph.find_subchain("b")->index()];
  const SubchainPlace& cd = decision.assignment.places[app.graph.find_subchain("cd")->index()];
  EXPECT_EQ(cd.levels, (std::vector<os::Level>{os::fixed_level(2), os::fixed_level(3)}));
  EXPECT_EQ(a.level_of(0), os::fixed_level(0));
  EXPECT_EQ(b.level_of(0), os::fixed_level(1));
  EXPECT_EQ(a.cpus, b.cpus);
  EXPECT_EQ(a.cpus.size(), 1U);
  EXPECT_NE(a.cpus, cd.cpus);
  EXPECT_EQ(decision.unscheduled_level, os::fixed_level(4));
  EXPECT_EQ(decision.dispatcher_level, os::fixed_level(5));
}

TEST(Compared, DeadlinesAreReservationsANode) {
  const graph::App app = two_chains();
  const Decision decision = *decided("deadline", app);
  const SubchainPlace& cd = decision.assignment.places[app.graph.find_subchain("cd")->index()];
  ASSERT_EQ(cd.reservations.size(), 2U);
  EXPECT_EQ(cd.reservations[1].runtime, std::chrono::microseconds{5500});
  EXPECT_EQ(cd.reservations[1].period, std::chrono::milliseconds{200});
  EXPECT_EQ(cd.pacing.period, std::chrono::milliseconds{200});
  EXPECT_EQ(cd.cpus, (os::CpuSet{2, 3}));
}

TEST(Compared, RatesAreOnOneCoreEachAtOnePriority) {
  for (const char* name : {"davare", "verucchi"}) {
    const graph::App app = two_chains();
    const Decision decision = *decided(name, app);
    std::vector<os::Level> levels;
    for (const SubchainPlace& place : decision.assignment.places) {
      EXPECT_EQ(place.cpus.size(), 1U);
      EXPECT_GE(place.pacing.period, std::chrono::milliseconds{5});
      EXPECT_LE(place.pacing.period, std::chrono::milliseconds{50});
      levels.push_back(place.level);
    }
    std::sort(levels.begin(), levels.end());
    EXPECT_EQ(levels, (std::vector<os::Level>{os::fixed_level(0), os::fixed_level(1), os::fixed_level(2)}));
    EXPECT_FALSE(decision.plan);
  }
}

TEST(Compared, ComputeTimesMayComeFromAFile) {
  for (const char* name : {"picas", "deadline", "davare", "verucchi"}) {
    EXPECT_TRUE((*make_policy(name))->needs_costs());
    const std::string with_file = std::string(name) + ":/nowhere/costs.yaml";
    EXPECT_FALSE((*make_policy(with_file))->needs_costs());
    EXPECT_EQ((*make_policy(with_file))->name(), with_file);
    EXPECT_FALSE(decided(with_file.c_str(), two_chains()).ok());
    EXPECT_FALSE(make_policy(std::string(name) + ":").ok());
  }
}

}  // namespace
}  // namespace ctn::policy
