// Both methods that assign rates: cases worked by hand, and what must hold of any app.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "baselines/davare.h"
#include "baselines/response_times.h"
#include "baselines/verucchi.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "planner/planner.h"
#include "planner/testing/random_apps.h"

namespace ctn::baselines {
namespace {

using testing::HasSubstr;

using Method = Result<RatePlan> (*)(const graph::App&, const model::CostTable&, const RateRequest&);

struct Named {
  const char* name;
  Method plan;
};

void PrintTo(const Named& named, std::ostream* out) { *out << named.name; }

class Rates : public testing::TestWithParam<Named> {};
INSTANTIATE_TEST_SUITE_P(All, Rates,
                         testing::Values(Named{"davare", plan_by_davare}, Named{"verucchi", plan_by_verucchi}),
                         [](const auto& test) { return test.param.name; });

// Nodes a, b, c of 2, 4 and 8 ms, each a subchain.
graph::AppSpec row() {
  graph::AppSpec spec = graph::spec_of({"a", "b", "c", "out"}, {"a b c out"});
  node(spec, "out").external = true;
  spec.objective = {graph::response("a b c out", 1.0)};
  return spec;
}

model::CostTable costs_of(const graph::App& app) {
  model::CostTable costs(app.graph, Millis{0});
  double cost = 2.0;
  for (const char* name : {"a", "b", "c"}) {
    if (const auto id = app.graph.find_node(name)) costs.set(*id, model::CostProfile::constant(Millis{cost}));
    cost *= 2.0;
  }
  return costs;
}

RatePlan planned(Method method, const graph::App& app, const model::CostTable& costs, const RateRequest& request) {
  auto plan = method(app, costs, request);
  EXPECT_TRUE(plan.ok()) << (plan.ok() ? "" : plan.error().message());
  const Status fine = check_rates(*plan, app, costs, request.cores);
  EXPECT_TRUE(fine.ok()) << (fine.ok() ? "" : fine.error().message());
  return *std::move(plan);
}

// A core each: every task runs all the time. Davare et al. know nothing of which task begins when: each task adds its
// period and its run, 2 x (2 + 4 + 8).
TEST(Davare, WithACoreEachPeriodsAreCosts) {
  const graph::App app = graph::build_app(row()).value();
  const RatePlan plan = planned(plan_by_davare, app, costs_of(app), {3, 0.0, 0});
  EXPECT_NEAR(plan.subchains[0].period.count(), 2.0, 1e-3);
  EXPECT_NEAR(plan.subchains[1].period.count(), 4.0, 1e-3);
  EXPECT_NEAR(plan.subchains[2].period.count(), 8.0, 1e-3);
  EXPECT_NEAR(plan.objective, 28.0, 1e-3);
  EXPECT_NEAR(plan.chains[0].latency.count(), 26.0, 1e-3);
}

// Two tasks on one core, a = 2 above b = 4, exactly: with k runs of a in one period of b, r_b = 4 + 2 k, t_b = r_b and
// t_a = t_b / k; the sum t_a + 2 + 2 t_b is lowest at k = 1 (6 + 2 + 12). With b above a: t_a = t_b = 6, too, and
// r_a = 6, r_b = 4: 22.
TEST(Davare, OnOneCoreTwoTasksTakeTurns) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "out"}, {"a b out"});
  node(spec, "out").external = true;
  spec.objective = {graph::response("a b out", 1.0)};
  const graph::App app = graph::build_app(spec).value();
  const RatePlan plan = planned(plan_by_davare, app, costs_of(app), {1, 0.0, 0});
  EXPECT_GE(plan.objective, 20.0 - 1e-6);
  EXPECT_LT(plan.objective, 20.5);
  EXPECT_GT(plan.subchains[0].priority, plan.subchains[1].priority);
}

// Two tasks on one core, each with a chain of its own. With the higher one's period given, the lower one's is best at
// its response time; so the optimum over exact response times is found by trying periods of the higher one, for both
// orders.
double best_of_two(double a, double b, double weight_a, double weight_b) {
  double best = kInfinity;
  for (const bool swapped : {false, true}) {
    const double high = swapped ? b : a;
    const double low = swapped ? a : b;
    const double weight_high = swapped ? weight_b : weight_a;
    const double weight_low = swapped ? weight_a : weight_b;
    for (double period = high * 1.001; period < 200.0 * (a + b); period *= 1.001) {
      const auto response = response_time(low, std::vector<PeriodicTask>{{high, period}}, 1e6);
      if (response) best = std::min(best, weight_high * (period + high) + weight_low * 2.0 * *response);
    }
  }
  return best;
}

TEST(Davare, IsNearTheBestThatExactResponseTimesAllow) {
  graph::AppSpec spec = graph::spec_of({"a", "b", "x", "y"}, {"a x", "b y"});
  node(spec, "x").external = node(spec, "y").external = true;
  double sum = 0.0;
  constexpr int kCases = 30;
  for (int i = 0; i < kCases; ++i) {
    const double weight = std::pow(10.0, -3.0 + 0.1 * i);
    const double cost = 1.0 + 3.0 * (i * 7 % kCases);
    spec.objective = {graph::response("a x", 1.0), graph::response("b y", weight)};
    const graph::App app = graph::build_app(spec).value();
    model::CostTable costs(app.graph, Millis{2});
    costs.set(*app.graph.find_node("b"), model::CostProfile::constant(Millis{cost}));
    const RatePlan plan = planned(plan_by_davare, app, costs, {1, 0.0, 0});
    const double best = best_of_two(2.0, cost, 1.0, weight);
    EXPECT_GE(plan.objective, best * (1.0 - 2e-3)) << weight << " " << cost;
    EXPECT_LE(plan.objective, best * 1.1) << weight << " " << cost;
    sum += plan.objective / best;
  }
  EXPECT_LT(sum / kCases, 1.03);
  RecordProperty("mean_over_best", std::to_string(sum / kCases));
}

// Exhaustive, and by hand: c takes all of its core, so each of its runs begins when it is triggered and takes 8 ms. b
// every 4 ms and a every 2 ms take all of theirs, so that a run of each ends just when its successor's begins. No chain
// is faster than its slowest period, 8, and its runs, 14.
TEST(Verucchi, RunsThatFollowEachOtherNeedNotWait) {
  const graph::App app = graph::build_app(row()).value();
  const RatePlan plan = planned(plan_by_verucchi, app, costs_of(app), {3, 0.0, 0});
  EXPECT_TRUE(plan.exhaustive);
  EXPECT_NEAR(plan.objective, 22.0, 1e-9);
  EXPECT_NEAR(plan.subchains[0].period.count(), 2.0, 1e-9);
  EXPECT_NEAR(plan.subchains[1].period.count(), 4.0, 1e-9);
  EXPECT_NEAR(plan.subchains[2].period.count(), 8.0, 1e-9);
}

// On one core everything at one rate, one after the other, is what no schedule can beat: 14 + 14.
TEST(Verucchi, OnOneCoreARowRunsAtOneRate) {
  const graph::App app = graph::build_app(row()).value();
  const RatePlan plan = planned(plan_by_verucchi, app, costs_of(app), {1, 0.0, 0});
  EXPECT_TRUE(plan.exhaustive);
  EXPECT_NEAR(plan.objective, 28.0, 1e-9);
  EXPECT_NEAR(plan.hyperperiod.count(), 14.0, 1e-9);
  for (const Precedence& precedence : plan.precedences) EXPECT_EQ(precedence.delay.count(), 0.0);
}

// b matters 100 times as much: it runs more often than c, by a power of two.
TEST(Verucchi, RatesArePowersOfTwoApart) {
  graph::AppSpec spec = row();
  spec.objective = {graph::period("a", 1.0), graph::period("c", 0.01)};
  const graph::App app = graph::build_app(spec).value();
  const RatePlan plan = planned(plan_by_verucchi, app, costs_of(app), {1, 0.0, 0});
  EXPECT_TRUE(plan.exhaustive);
  const double ratio = plan.subchains[2].period / plan.subchains[0].period;
  EXPECT_DOUBLE_EQ(std::log2(ratio), std::round(std::log2(ratio)));
  EXPECT_GT(ratio, 8.0);
}

TEST_P(Rates, ExactRatesAndCapsAreKept) {
  graph::AppSpec spec = row();
  node(spec, "b").min_rate = node(spec, "b").max_rate = graph::At<Rate>{Rate{40.0}, {}};
  node(spec, "a").max_rate = graph::At<Rate>{Rate{10.0}, {}};
  const graph::App app = graph::build_app(spec).value();
  const RatePlan plan = planned(GetParam().plan, app, costs_of(app), {1, 0.06, 0});
  EXPECT_NEAR(plan.subchains[1].period.count(), 25.0, 1e-9);
  EXPECT_GE(plan.subchains[0].period.count(), 100.0 - 1e-6);
}

TEST_P(Rates, BoundsThatCannotHoldAreNamed) {
  graph::AppSpec spec = row();
  spec.objective[0].max = graph::At<Nanos>{std::chrono::milliseconds{10}, {}};
  const graph::App app = graph::build_app(spec).value();
  const RatePlan plan = planned(GetParam().plan, app, costs_of(app), {1, 0.06, 0});
  ASSERT_EQ(plan.relaxed.size(), 1U);
  EXPECT_EQ(plan.relaxed[0].key, "objective[0].max");
  EXPECT_GT(plan.relax_factor, 2.0);
}

TEST_P(Rates, WhatCannotBeIsTheCallersMistake) {
  graph::AppSpec spec = row();
  node(spec, "c").min_rate = node(spec, "c").max_rate = graph::At<Rate>{Rate{200.0}, {}};
  const graph::App app = graph::build_app(spec).value();
  const auto none = GetParam().plan(app, costs_of(app), {2, 0.06, 0});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind(), ErrorKind::kCaller);
  EXPECT_THAT(none.error().message(), HasSubstr("exact rates"));
  EXPECT_FALSE(GetParam().plan(app, costs_of(app), {0, 0.06, 0}));
  EXPECT_FALSE(GetParam().plan(app, costs_of(app), {1, 1.0, 0}));
}

TEST_P(Rates, TheSameAppHasTheSameAnswer) {
  const planner::RandomCase any = planner::random_case(7, {}, 2);
  const RateRequest request{any.cores, any.slack, 0};
  EXPECT_EQ(*GetParam().plan(any.app, any.costs, request), *GetParam().plan(any.app, any.costs, request));
}

#ifdef CATAN_SANITIZED
constexpr std::uint64_t kApps = 24;  // one of each size and kind; they take ten times as long
#else
constexpr std::uint64_t kApps = 120;
#endif

// Every kind of app that the planner is tested with, some too large to be searched through.
TEST_P(Rates, HoldWhateverTheApp) {
  std::uint64_t planned_apps = 0;
  for (std::uint64_t seed = 0; seed < kApps; ++seed) {
    planner::RandomLimits limits;
    limits.subchains = 1 + static_cast<int>(seed % 6) + (seed % 24 == 23 ? 14 : 0);
    limits.queue = seed % 4 == 1;
    limits.caps = seed % 2 == 0;
    limits.exact = seed % 5 == 2;
    limits.zeros = seed % 3 == 0 && !limits.exact;  // an exact rate would be infinite
    limits.bounds = seed % 3 == 1;
    limits.pairs = seed % 2 == 1;
    limits.kinds = seed % 7 == 3;
    const planner::RandomCase any = planner::random_case(seed, limits, 1 + static_cast<int>(seed % 3));
    const RateRequest request{any.cores, any.slack, GetParam().plan == plan_by_davare ? 40U : 40'000U};
    const auto plan = GetParam().plan(any.app, any.costs, request);
    if (!plan) {
      EXPECT_TRUE(limits.exact) << "seed " << seed << ": " << plan.error().message();
      continue;
    }
    ++planned_apps;
    const Status fine = check_rates(*plan, any.app, any.costs, any.cores);
    EXPECT_TRUE(fine.ok()) << "seed " << seed << ": " << fine.error().message();
  }
  EXPECT_GT(planned_apps, kApps * 5 / 6);
}

TEST_P(Rates, ALargeAppIsPlannedWithinTheEffort) {
  planner::RandomLimits limits;
  limits.subchains = 64;
  limits.chains = 40;
  const planner::RandomCase any = planner::random_case(3, limits, 4);
  const auto plan =
      GetParam().plan(any.app, any.costs, {any.cores, any.slack, GetParam().plan == plan_by_davare ? 5U : 0U});
  ASSERT_TRUE(plan.ok());
  EXPECT_FALSE(plan->exhaustive);
  const Status fine = check_rates(*plan, any.app, any.costs, any.cores);
  EXPECT_TRUE(fine.ok()) << fine.error().message();
}

}  // namespace
}  // namespace ctn::baselines
