// Random apps of several subchains: the planner against brute force, and what must hold of every plan.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "plan/json.h"
#include "plan/validate.h"
#include "planner/planner.h"
#include "planner/random_apps.h"

namespace ctn::planner {
namespace {

plan::Plan proven_plan(const RandomCase& any, Request request) {
  request.cores = any.cores;
  request.slack = any.slack;
  const auto plan = make_plan(any.app, any.costs, request);
  EXPECT_TRUE(plan.ok()) << (plan.ok() ? "" : plan.error().message());
  if (!plan) return {};
  const Status valid = plan::validate(*plan, any.app, any.costs, any.cores);
  EXPECT_TRUE(valid.ok()) << (valid.ok() ? "" : valid.error().message());
  return *plan;
}

// Every app of the kind, on 1 to 3 cores: the plan is called optimal, and it is.
void compare(const RandomLimits& limits, double tolerance, std::uint64_t apps) {
  std::uint64_t sharing = 0;
  std::uint64_t relaxed = 0;
  for (std::uint64_t seed = 1; seed <= apps; ++seed) {
    RandomLimits some = limits;
    some.subchains = 2 + static_cast<int>(seed % static_cast<std::uint64_t>(limits.subchains - 1));
    const RandomCase any = random_case(seed, some, 1 + static_cast<int>(seed % 3));
    SCOPED_TRACE("seed " + std::to_string(seed));
    const BruteForce::Best best = BruteForce(any).run();
    if (!best.found) {
      EXPECT_FALSE(make_plan(any.app, any.costs, {.cores = any.cores, .slack = any.slack}).ok());
      continue;
    }
    const plan::Plan plan = proven_plan(any, {});
    EXPECT_EQ(plan.quality, plan::Quality::kOptimal) << "gap " << plan.gap;
    EXPECT_NEAR(plan.relax_factor, best.factor, tolerance * best.factor);
    EXPECT_NEAR(plan.objective, best.objective, tolerance * best.objective);
    sharing += std::any_of(plan.cores.begin(), plan.cores.end(), [](const auto& core) { return !core.slots.empty(); });
    relaxed += plan.relax_factor > 1.0 ? 1 : 0;
  }
  EXPECT_GT(sharing, apps / 3) << "else nothing was compared";
  EXPECT_TRUE(!limits.bounds || relaxed > apps / 20) << relaxed;
}

TEST(SharingProperty, IsWhatBruteForceFinds) { compare({.subchains = 5, .dearest = 7.0}, 1e-9, 600); }

TEST(SharingProperty, IsWhatBruteForceFindsForSlicesOfManyFrames) {
  compare({.subchains = 3, .cheapest = 2.0, .dearest = 60.0}, 1e-9, 400);
}

TEST(SharingProperty, IsWhatBruteForceFindsWithNodesThatOverlap) { compare({.pairs = true}, 1e-9, 600); }

TEST(SharingProperty, IsWhatBruteForceFindsWithRateCaps) { compare({.caps = true, .pairs = true}, 1e-9, 600); }

TEST(SharingProperty, IsWhatBruteForceFindsWithExactRates) { compare({.exact = true}, 1e-9, 600); }

TEST(SharingProperty, IsWhatBruteForceFindsWithBounds) { compare({.caps = true, .bounds = true}, 2e-9, 600); }

// The brute force finds free shares by narrowing down, to so many digits.
TEST(SharingProperty, IsWhatBruteForceFindsWithAQueue) {
  compare({.subchains = 4, .dearest = 5.0, .queue = true, .caps = true}, 1e-7, 200);
}

TEST(SharingProperty, IsWhatBruteForceFindsWithAQueueAndBounds) {
  compare({.subchains = 3, .dearest = 5.0, .queue = true, .bounds = true}, 1e-6, 200);
}

}  // namespace
}  // namespace ctn::planner
