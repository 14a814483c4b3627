// Random apps of several subchains: the planner against brute force, and what must hold of every plan.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "plan/json.h"
#include "plan/recost.h"
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

TEST(SharingProperty, IsWhatBruteForceFindsOnCoresThatDiffer) {
  compare({.subchains = 4, .dearest = 7.0, .pairs = true, .kinds = true}, 1e-9, 600);
}

TEST(SharingProperty, IsWhatBruteForceFindsOnCoresThatDifferWithBoundsAndRates) {
  compare({.subchains = 4, .dearest = 7.0, .caps = true, .bounds = true, .kinds = true}, 2e-9, 400);
  compare({.subchains = 4, .dearest = 7.0, .exact = true, .kinds = true}, 1e-9, 300);
}

// The brute force finds free shares by narrowing down, to so many digits.
TEST(SharingProperty, IsWhatBruteForceFindsWithAQueue) {
  compare({.subchains = 4, .dearest = 5.0, .queue = true, .caps = true}, 1e-7, 200);
}

TEST(SharingProperty, IsWhatBruteForceFindsWithAQueueAndBounds) {
  compare({.subchains = 3, .dearest = 5.0, .queue = true, .bounds = true}, 1e-6, 200);
}

// On shared cores plans promise more for runs that wait than the planner reckons with: what it proves is a gap.
TEST(SharingProperty, WhereRunsWaitTheGapHoldsAgainstBruteForce) {
  int proven = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const RandomLimits limits{
        .subchains = 2 + static_cast<int>(seed % 3), .dearest = 7.0, .pairs = true, .waits = true};
    const RandomCase any = random_case(seed, limits, 1 + static_cast<int>(seed % 3));
    const BruteForce::Best best = BruteForce(any).run();
    const plan::Plan plan = proven_plan(any, {});
    EXPECT_GE(plan.objective, best.objective * (1.0 - 1e-9));
    EXPECT_LE(plan.objective * (1.0 - plan.gap), best.objective * (1.0 + 1e-9));
    if (plan.gap == 0.0) ++proven;
  }
  EXPECT_GT(proven, 20) << "where nobody waits, plans are optimal";
}

// The same plan where some nodes wait: as much of each core is used, and each chain takes at least as much longer as
// its subchains wait.
TEST(SharingProperty, WaitsLeaveLoadAsItIsAndAddToLatency) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const RandomLimits limits{.subchains = 4, .queue = seed % 3 == 0, .caps = seed % 2 == 0, .pairs = true};
    RandomCase any = random_case(seed, limits, 1 + static_cast<int>(seed % 3));
    const plan::Plan plan = proven_plan(any, {});
    const plan::Plan before = plan::recost(plan, any.app, any.costs).value();
    for (std::size_t node = 0; node < any.app.graph.nodes().size(); ++node) {
      if ((seed + node) % 2 == 0) any.costs.set_wait(NodeId(node), Millis{1.0 + static_cast<double>(node)});
    }
    const plan::Plan now = plan::recost(plan, any.app, any.costs).value();
    EXPECT_EQ(now.cores, before.cores);
    for (std::size_t i = 0; i < now.subchains.size(); ++i) EXPECT_EQ(now.subchains[i].slice, before.subchains[i].slice);
    for (std::size_t chain = 0; chain < now.chains.size(); ++chain) {
      double waits = 0.0;
      for (const graph::ChainElement& element : any.app.graph.chain_elements(now.chains[chain].path)) {
        if (element.subchain) waits += any.costs.subchain_wait(any.app.graph, *element.subchain).count();
      }
      EXPECT_GE((now.chains[chain].latency - before.chains[chain].latency).count(), waits - 1e-9);
    }
  }
}

// What plans compete by: first the factor, then the objective.
void expect_no_worse(const plan::Plan& a, const plan::Plan& b) {
  constexpr double kRounding = 1e-8;
  EXPECT_LE(a.relax_factor, b.relax_factor * (1.0 + kRounding));
  if (a.relax_factor < b.relax_factor * (1.0 - kRounding)) return;
  EXPECT_LE(a.objective, b.objective * (1.0 + kRounding));
}

constexpr RandomLimits kMixed{.subchains = 6, .chains = 5, .dearest = 40.0, .queue = true, .caps = true, .pairs = true};

TEST(SharingProperty, ACoreMoreIsNeverWorse) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    RandomCase any = random_case(seed, kMixed, 1);
    plan::Plan fewer = proven_plan(any, {});
    for (any.cores = 2; any.cores <= 7; ++any.cores) {
      plan::Plan more = proven_plan(any, {});
      expect_no_worse(more, fewer);
      fewer = std::move(more);
    }
  }
}

constexpr RandomLimits kOnKinds{
    .subchains = 6, .chains = 5, .cheapest = 2.0, .dearest = 40.0, .caps = true, .pairs = true, .kinds = true};

// The same app with other numbers of cores of each kind.
RandomCase with_counts(RandomCase any, const std::vector<int>& counts) {
  any.cores = 0;
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    any.app.core_kinds[kind].count = counts[kind];
    any.cores += counts[kind];
  }
  return any;
}

TEST(SharingProperty, ACoreMoreOfAnyKindIsNeverWorse) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const RandomCase any = random_case(seed, kOnKinds, 1 + static_cast<int>(seed % 4));
    const plan::Plan fewer = proven_plan(any, {});
    for (std::size_t kind = 0; kind < any.app.kinds(); ++kind) {
      std::vector<int> counts = any.app.cores_by_kind(any.cores);
      ++counts[kind];
      expect_no_worse(proven_plan(with_counts(any, counts), {}), fewer);
    }
  }
}

TEST(SharingProperty, KindsThatAreAlikeAreLikeOne) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const RandomCase one = random_case(seed, kMixed, 3);
    RandomCase two = one;
    two.app.core_kinds = {{"a", 1, 1.0}, {"b", 2, 1.0}};
    const plan::Plan plan = proven_plan(one, {});
    EXPECT_NEAR(proven_plan(two, {}).objective, plan.objective, 1e-9 * plan.objective);
  }
}

TEST(SharingProperty, TwiceTheSpeedIsHalfTheCost) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    RandomCase fast = random_case(seed, kMixed, 2);
    RandomCase cheap = fast;
    fast.app.core_kinds = {{"fast", 2, 2.0}};
    for (std::size_t i = 0; i < fast.app.graph.nodes().size(); ++i) {
      cheap.costs.set(NodeId(i), fast.costs[NodeId(i)].times(0.5));
    }
    const plan::Plan plan = proven_plan(cheap, {});
    EXPECT_NEAR(proven_plan(fast, {}).objective, plan.objective, 1e-9 * plan.objective);
  }
}

TEST(SharingProperty, ACoreThatIsFarTooSlowIsLeftAlone) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    RandomLimits limits = kMixed;
    limits.caps = false;
    const RandomCase one = random_case(seed, limits, 2);
    RandomCase two = one;
    two.cores = 3;
    two.app.core_kinds = {{"good", 2, 1.0}, {"hopeless", 1, 0.001}};
    const plan::Plan plan = proven_plan(two, {});
    EXPECT_NEAR(plan.objective, proven_plan(one, {}).objective, 1e-9 * plan.objective);
    EXPECT_TRUE(plan.cores[2].slots.empty());
  }
}

TEST(SharingProperty, ManySubchainsArePlannedOnCoresThatDiffer) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    RandomLimits many = kOnKinds;
    many.subchains = seed % 2 == 0 ? 20 : 40;
    const RandomCase any = random_case(seed, many, 8);
    const plan::Plan plan = proven_plan(any, {.effort = 50'000});
    EXPECT_LT(plan.gap, 0.45);  // beyond exact sizes the bound for cores that differ is weak
    // No worse than on its fastest cores alone.
    std::vector<int> counts = any.app.cores_by_kind(any.cores);
    std::fill(counts.begin(), counts.end(), 0);
    const std::size_t fastest = fastest_kind(any.app);
    counts[fastest] = any.app.core_kinds[fastest].count;
    const plan::Plan alone = proven_plan(with_counts(any, counts), {.effort = 50'000});
    EXPECT_LE(plan.objective, alone.objective * 1.05);
  }
}

TEST(SharingProperty, ACheaperNodeIsNeverWorse) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    const RandomCase any = random_case(seed, kMixed, 1 + static_cast<int>(seed % 3));
    RandomCase cheaper = any;
    const NodeId node(seed % any.app.graph.nodes().size());
    // Not below min_slice: a slice of less has to hold a whole run.
    const double cost = any.costs[node].single_thread().count();
    cheaper.costs.set(node, model::CostProfile::constant(Millis{std::max(std::min(cost, 1.0), 0.9 * cost)}));
    const plan::Plan before = proven_plan(any, {});
    const plan::Plan after = proven_plan(cheaper, {});
    // Fewer slices of min_slice fit in a cheaper run, so that only what needs no more frames than that is comparable.
    const auto needs = [&](const plan::SubchainPlan& subchain, std::size_t i) {
      const double total = cheaper.costs.subchain_total(any.app.graph, SubchainId(i)).count();
      return subchain.cores.size() == 1 && subchain.share < 1.0 && subchain.share * total < 1.0 - 1e-9;
    };
    bool comparable = true;
    for (std::size_t i = 0; i < before.subchains.size(); ++i) comparable = comparable && !needs(before.subchains[i], i);
    if (comparable) expect_no_worse(after, before);
  }
}

TEST(SharingProperty, TenTimesTheTimeIsTenTimesThePlan) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    RandomLimits limits = kMixed;
    limits.caps = false;
    const RandomCase any = random_case(seed, limits, 2);
    RandomCase ten = any;
    ten.app.scheduler.min_slice *= 10;
    for (std::size_t i = 0; i < any.app.graph.nodes().size(); ++i) {
      ten.costs.set(NodeId(i), model::CostProfile::constant(any.costs[NodeId(i)].single_thread() * 10.0));
    }
    const plan::Plan one = proven_plan(any, {});
    const plan::Plan scaled = proven_plan(ten, {});
    EXPECT_NEAR(scaled.objective, 10.0 * one.objective, 1e-8 * scaled.objective);
  }
}

TEST(SharingProperty, TheOrderInWhichAnAppIsWrittenDoesNotMatter) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    RandomLimits limits = kMixed;
    const int cores = 1 + static_cast<int>(seed % 3);
    const plan::Plan plan = proven_plan(random_case(seed, limits, cores), {});
    limits.reversed = true;
    const plan::Plan reversed = proven_plan(random_case(seed, limits, cores), {});
    EXPECT_NEAR(reversed.objective, plan.objective, 1e-9 * plan.objective);
  }
}

TEST(SharingProperty, TheSameInputGivesTheSamePlan) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const RandomCase any = random_case(seed, kMixed, 2);
    EXPECT_EQ(proven_plan(any, {}), proven_plan(any, {}));
  }
}

TEST(SharingProperty, EveryPlanSurvivesJson) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const RandomCase any = random_case(seed, kMixed, 1 + static_cast<int>(seed % 4));
    const plan::Plan plan = proven_plan(any, {});
    const auto read = plan::from_json(plan::to_json(plan, any.app), any.app, "plan.json");
    ASSERT_TRUE(read.ok());
    EXPECT_EQ(*read, plan);
  }
}

TEST(SharingProperty, AWarmStartFindsTheSame) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const RandomCase any = random_case(seed, kMixed, 2);
    const plan::Plan cold = proven_plan(any, {});
    RandomCase later = any;
    const NodeId node(seed % any.app.graph.nodes().size());
    later.costs.set(node, model::CostProfile::constant(any.costs[node].single_thread() * 1.3));
    const plan::Plan warm = proven_plan(later, {.warm = &cold});
    EXPECT_NEAR(warm.objective, proven_plan(later, {}).objective, 1e-9 * warm.objective);
  }
}

TEST(SharingProperty, ALimitFindsThePlanThatIsBelowItAndNoneThatIsNot) {
  int bounds_met = 0;
  int bounds_missed = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    const int cores = 1 + static_cast<int>(seed % 3);
    RandomLimits limits = kMixed;
    limits.bounds = seed % 2 == 0;
    const RandomCase any = random_case(seed, limits, cores);
    const plan::Plan best = proven_plan(any, {});
    const auto below = [&](double limit, const plan::Plan* warm) {
      const auto found =
          make_plan_below(any.app, any.costs, {.cores = any.cores, .slack = any.slack, .warm = warm}, limit);
      EXPECT_TRUE(found.ok());
      return *found;
    };
    if (best.relax_factor > 1.0) {
      ++bounds_missed;
      EXPECT_FALSE(below(std::numeric_limits<double>::infinity(), nullptr)) << "no plan meets all bounds";
      continue;
    }
    ++bounds_met;
    const auto found = below(1.001 * best.objective, nullptr);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->objective, best.objective, 1e-9 * best.objective);
    EXPECT_TRUE(plan::validate(*found, any.app, any.costs, any.cores).ok());
    EXPECT_FALSE(below(0.999 * best.objective, nullptr));
    EXPECT_FALSE(below(0.999 * best.objective, &best));
  }
  EXPECT_GT(bounds_met, 10);
  EXPECT_GT(bounds_missed, 2);
}

TEST(SharingProperty, TwoStageIsNeverBetterThanJoint) {
  int worse = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    RandomLimits limits = kMixed;
    limits.caps = false;
    const RandomCase any = random_case(seed, limits, 2);
    const plan::Plan joint = proven_plan(any, {});
    const plan::Plan staged = proven_plan(any, {.method = Method::kTwoStage});
    EXPECT_EQ(staged.planner, "two-stage");
    expect_no_worse(joint, staged);
    worse += staged.objective > joint.objective * 1.001 ? 1 : 0;
  }
  EXPECT_GT(worse, 0);
}

TEST(SharingProperty, ExtremesArePlanned) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    const int cores = 1 + static_cast<int>(seed % 4);
    proven_plan(random_case(seed,
                            {.subchains = 7,
                             .cheapest = 0.01,
                             .dearest = 10'000.0,
                             .lightest = 1e-6,
                             .heaviest = 1e3,
                             .queue = true,
                             .caps = true,
                             .bounds = true},
                            cores),
                {});
    proven_plan(random_case(seed, {.subchains = 6, .zeros = true, .queue = true, .bounds = true}, cores), {});
    proven_plan(random_case(seed, {.subchains = 6, .all_queues = true, .caps = true}, cores), {});
  }
}

TEST(SharingProperty, LargeAppsArePlannedWithAProvenGap) {
  const RandomLimits many{
      .subchains = 64, .chains = 30, .cheapest = 1.0, .dearest = 500.0, .queue = true, .caps = true};
  for (const int cores : {1, 3, 16, 64, 200}) {
    SCOPED_TRACE(cores);
    const RandomCase any = random_case(7, many, cores);
    const plan::Plan plan = proven_plan(any, {.effort = 20'000});
    EXPECT_LT(plan.gap, 0.6);  // on 3 cores most costs are too small to be spread over frames, which the bound ignores
  }
}

TEST(SharingProperty, WithoutAnyEffortThereIsAPlanAllTheSame) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    proven_plan(random_case(seed, kMixed, 1 + static_cast<int>(seed % 3)), {.effort = 1});
  }
}

}  // namespace
}  // namespace ctn::planner
