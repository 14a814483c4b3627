// Random apps of more subchains than were ever proven optimal: every plan is valid, none is worse than what simpler
// ways to plan find, and planning again is quick.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "plan/validate.h"
#include "planner/allocation.h"
#include "planner/instance.h"
#include "planner/planner.h"
#include "planner/random_apps.h"

namespace ctn::planner {
namespace {

constexpr double kRounding = 1e-9;

Request request_for(const RandomCase& any, Request request) {
  request.cores = any.cores;
  request.slack = any.slack;
  return request;
}

plan::Plan valid_plan(const RandomCase& any, const Request& request) {
  const auto plan = make_plan(any.app, any.costs, request_for(any, request));
  EXPECT_TRUE(plan.ok()) << (plan.ok() ? "" : plan.error().message());
  if (!plan) return {};
  const Status valid = plan::validate(*plan, any.app, any.costs, any.cores);
  EXPECT_TRUE(valid.ok()) << (valid.ok() ? "" : valid.error().message());
  EXPECT_GE(plan->gap, 0.0);
  EXPECT_LT(plan->gap, 1.0);
  return *plan;
}

// What no plan is better than.
double bound_of(const plan::Plan& plan) { return plan.objective * (1.0 - plan.gap); }

struct Size {
  int subchains = 0;
  int cores = 0;
};
constexpr Size kSizes[] = {{100, 24}, {150, 128}, {200, 64}, {256, 64}, {200, 8}, {256, 3}, {180, 1}};

RandomLimits many(const Size& size) {
  return {.subchains = size.subchains, .chains = size.subchains, .dearest = 20.0, .pairs = true};
}

TEST(ManyProperty, IsNoWorseThanTwoStages) {
  std::uint64_t seed = 0;
  for (const Size& size : kSizes) {
    SCOPED_TRACE(size.subchains);
    const RandomCase any = random_case(++seed, many(size), size.cores);
    const plan::Plan joint = valid_plan(any, {.effort = 60'000});
    const plan::Plan staged = valid_plan(any, {.method = Method::kTwoStage, .effort = 10'000});
    EXPECT_LE(joint.objective, staged.objective * (1.0 + kRounding));
    EXPECT_LE(bound_of(joint), staged.objective * (1.0 + kRounding));
  }
}

// Subchains dealt to cores as it happens, each with the best shares of its allocation.
double best_of_random(const RandomCase& any, int tries) {
  const Instance instance = make_instance(any.app, any.costs, any.cores, any.slack);
  const Target target = free_target(instance);
  const std::size_t count = instance.members.size();
  std::mt19937_64 random(count);
  double best = std::numeric_limits<double>::infinity();
  for (int t = 0; t < tries; ++t) {
    std::vector<std::size_t> order(count);
    for (std::size_t i = 0; i < count; ++i) order[i] = i;
    for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
    const auto cores = static_cast<std::size_t>(any.cores);
    Allocation allocation = Allocation::none(count);
    for (std::size_t core = 0; core < cores; ++core) {
      const std::size_t begin = core * count / cores;
      const std::size_t end = (core + 1) * count / cores;
      if (end == begin) continue;
      if (end == begin + 1) {
        allocation.own(order[begin], 1, 0);
        continue;
      }
      ++allocation.shared_cores;
      for (std::size_t k = begin; k < end; ++k) allocation.share(order[k], 0);
    }
    Effort effort{2'000};
    const Planned planned = plan_shares(instance, target, allocation, effort);
    if (planned.found) best = std::min(best, planned.shares.value);
  }
  return best;
}

TEST(ManyProperty, IsNoWorseThanTheBestOfManyRandomAllocations) {
  for (const Size& size : kSizes) {
    SCOPED_TRACE(size.subchains);
    const RandomCase any = random_case(11, many(size), size.cores);
    const plan::Plan plan = valid_plan(any, {.effort = 60'000});
    const double random = best_of_random(any, 10);
    EXPECT_LE(plan.objective, random * (1.0 + kRounding));
    EXPECT_LE(bound_of(plan), random * (1.0 + kRounding));
  }
}

TEST(ManyProperty, PlansAreNearTheirBounds) {
  const Size size{200, 64};
  const plan::Plan plan = valid_plan(random_case(3, many(size), size.cores), {});
  EXPECT_LT(plan.gap, 0.05);
}

// Everything that an app may ask for.
TEST(ManyProperty, WhateverIsAskedForIsPlannedOrRefusedWithAReason) {
  std::uint64_t seed = 100;
  for (const Size& size : {Size{100, 24}, Size{200, 64}, Size{256, 16}}) {
    for (int asked = 0; asked < 7; ++asked) {
      SCOPED_TRACE(std::to_string(size.subchains) + " subchains, asked " + std::to_string(asked));
      RandomLimits limits = many(size);
      limits.caps = asked == 0 || asked == 6;
      limits.exact = asked == 1 || asked == 6;
      limits.kinds = asked == 2 || asked == 6;
      limits.bounds = asked == 3 || asked == 6;
      limits.queue = asked == 6;
      limits.all_queues = asked == 4;
      limits.zeros = asked == 5;
      const RandomCase any = random_case(++seed, limits, size.cores);
      for (const Method method : {Method::kJoint, Method::kTwoStage}) {
        const Request request = request_for(any, {.method = method, .effort = 3'000});
        const auto plan = make_plan(any.app, any.costs, request);
        if (!plan) {
          EXPECT_TRUE(limits.exact) << plan.error().message();
          EXPECT_NE(plan.error().message().find("exact rates"), std::string::npos) << plan.error().message();
          continue;
        }
        const Status valid = plan::validate(*plan, any.app, any.costs, any.cores);
        EXPECT_TRUE(valid.ok()) << (valid.ok() ? "" : valid.error().message());
      }
    }
  }
}

TEST(ManyProperty, AnExactRateIsMetWhereItHasACoreOfItsOwn) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    RandomLimits limits = many({120, 32});
    limits.exact = limits.caps = limits.bounds = true;
    valid_plan(random_case(seed, limits, 32), {.effort = 3'000});
  }
}

// Costs have changed a little: what is planned from the plan in force is hardly worse than it was.
TEST(ManyProperty, PlanningAgainStartsFromThePlanInForce) {
  const Size size{200, 64};
  RandomCase any = random_case(5, many(size), size.cores);
  const plan::Plan before = valid_plan(any, {});
  for (std::size_t i = 0; i < any.app.graph.nodes().size(); ++i) {
    const NodeId id(i);
    if (!any.app.graph.node(id).external) any.costs.set(id, any.costs[id].times(i % 3 == 0 ? 1.1 : 0.97));
  }
  const plan::Plan again = valid_plan(any, {.effort = 30'000, .warm = &before});
  EXPECT_LE(again.objective, 1.01 * valid_plan(any, {}).objective);
}

TEST(ManyProperty, TheSameAppGivesTheSamePlan) {
  const Size size{256, 64};
  const RandomCase any = random_case(9, many(size), size.cores);
  EXPECT_EQ(valid_plan(any, {.effort = 20'000}), valid_plan(any, {.effort = 20'000}));
}

TEST(ManyProperty, WithoutAnyEffortThereIsAPlanAllTheSame) {
  for (const Size& size : kSizes) {
    SCOPED_TRACE(size.subchains);
    valid_plan(random_case(21, many(size), size.cores), {.effort = 1});
  }
}

}  // namespace
}  // namespace ctn::planner
