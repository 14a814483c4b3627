// The planner against solvers that others wrote, on apps too large for brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "planner/allocation.h"
#include "planner/planner.h"
#include "planner/random_apps.h"
#include "solvers/cbc_stage_one.h"
#include "solvers/ipopt_stage_two.h"
#include "solvers/rounding.h"

namespace ctn::solvers {
namespace {

using planner::Allocation;
using planner::Instance;
using planner::RandomCase;
using planner::RandomLimits;
using planner::Target;

constexpr double kSame = 1e-6;
constexpr std::uint64_t kApps = 36;
constexpr std::uint64_t kAppsOfStageOne = 16;  // CBC takes its time

// 5 to 8 subchains on 2 or 3 cores.
RandomCase random_app(std::uint64_t seed, RandomLimits limits) {
  limits.subchains = 5 + static_cast<int>(seed % 4);
  return random_case(seed, limits, 2 + static_cast<int>(seed / 4 % 2));
}

Instance instance_of(const RandomCase& any) { return planner::make_instance(any.app, any.costs, any.cores, any.slack); }

// Subchains that get faster with cores, some more than others.
void add_threads(Instance& instance) {
  double worth = 1.0;
  for (planner::Member& member : instance.members) {
    worth = worth > 0.9 ? 0.3 : worth + 0.2;
    member.on[0].owned.resize(static_cast<std::size_t>(instance.cores()), member.on[0].owned.front());
    for (std::size_t k = 1; k < member.on[0].owned.size(); ++k) {
      const double speed = 1.0 + worth * static_cast<double>(k);
      member.on[0].owned[k].period = std::max(member.on[0].owned.front().period / speed, member.min_period);
      member.on[0].owned[k].execution = member.on[0].owned.front().execution / speed;
    }
  }
}

void expect_valid(const Instance& instance, const Allocation& allocation) {
  int used = allocation.shared_cores;
  std::vector<int> sharing(static_cast<std::size_t>(allocation.shared_cores), 0);
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    EXPECT_NE(allocation.core_of[i] >= 0, allocation.owned[i] > 0);
    used += allocation.owned[i];
    if (allocation.core_of[i] >= 0) ++sharing[static_cast<std::size_t>(allocation.core_of[i])];
  }
  EXPECT_LE(used, instance.cores());
  for (const int members : sharing) EXPECT_GE(members, 2);
}

// Returns whether there is a plan.
bool compare_stage_one(const Instance& instance, const Target& target) {
  const StageOne theirs = cbc_stage_one(instance, target);
  EXPECT_TRUE(theirs.proven);
  planner::Effort effort;
  const planner::Planned ours = allocate_by_equal_shares(instance, target, effort);
  EXPECT_EQ(ours.found, theirs.found);
  if (!ours.found || !theirs.found) return false;
  EXPECT_NEAR(ours.shares.value, theirs.value, kSame * theirs.value);
  expect_valid(instance, ours.allocation);
  expect_valid(instance, theirs.allocation);
  const double value = [&] {
    double sum = 0.0;
    const std::vector<planner::Timing> timings = equal_shares(instance, ours.allocation);
    for (const planner::Group& group : target.groups) sum += group.weight * value_of(group, timings);
    return sum;
  }();
  EXPECT_NEAR(ours.shares.value, value, 1e-9 * value) << "of the allocation that it returns";
  return true;
}

void compare_stage_one(const RandomLimits& limits, bool threads = false) {
  std::uint64_t found = 0;
  for (std::uint64_t seed = 1; seed <= kAppsOfStageOne; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Instance instance = instance_of(random_app(seed, limits));
    if (threads) add_threads(instance);
    found += compare_stage_one(instance, objective_target(instance, limits.bounds ? 2.0 : 1.0)) ? 1 : 0;
  }
  EXPECT_GE(found, kAppsOfStageOne / 3) << "else little was compared";
}

TEST(StageOneAgainstCbc, IsTheSame) { compare_stage_one({.dearest = 20.0}); }

TEST(StageOneAgainstCbc, IsTheSameWithCoresOwned) { compare_stage_one({.dearest = 20.0, .pairs = true}, true); }

TEST(StageOneAgainstCbc, IsTheSameWithRatesAndBounds) {
  compare_stage_one({.dearest = 20.0, .caps = true, .bounds = true, .pairs = true});
}

TEST(StageOneAgainstCbc, IsTheSameWithExactRates) { compare_stage_one({.dearest = 20.0, .exact = true}); }

void compare_stage_two(const Instance& instance) {
  const Target target = free_target(instance);
  const Allocation allocation = dealt(instance);
  const StageTwo relaxed = ipopt_stage_two(instance, target, allocation);
  ASSERT_TRUE(relaxed.solved);
  planner::Effort effort;
  const planner::Planned ours = plan_shares(instance, target, allocation, effort);
  ASSERT_TRUE(ours.found);
  EXPECT_GE(ours.shares.value, relaxed.value * (1.0 - kSame));
  EXPECT_NEAR(ours.bound, ours.shares.value, 1e-9 * ours.shares.value) << "not proven";
  if (std::all_of(instance.members.begin(), instance.members.end(), [](const auto& m) { return m.queue; })) {
    EXPECT_NEAR(ours.shares.value, relaxed.value, kSame * relaxed.value);
  }
  for (const Frame frame : {Frame::kLongest, Frame::kShortest}) {
    const double rounding = objective_of(instance, rounded(instance, allocation, relaxed.timings, frame));
    EXPECT_LE(ours.shares.value, rounding * (1.0 + kSame));
  }
}

// `queues`: how many take batches, the first ones; their shares are free.
void compare_stage_two(const RandomLimits& limits, std::size_t queues) {
  for (std::uint64_t seed = 1; seed <= kApps; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Instance instance = instance_of(random_app(seed, limits));
    for (std::size_t i = 0; i < std::min(queues, instance.members.size()); ++i) instance.members[i].queue = true;
    compare_stage_two(instance);
  }
}

constexpr std::size_t kAll = planner::kMostSubchains;

TEST(StageTwoAgainstIpopt, IsNoBetterThanTheRelaxationAndNoWorseThanItsRounding) {
  compare_stage_two({.dearest = 20.0}, 0);
}

TEST(StageTwoAgainstIpopt, IsNoBetterThanTheRelaxationWithRateCapsAndAQueue) {
  compare_stage_two({.dearest = 20.0, .caps = true, .pairs = true}, 1);
}

// Where every subchain takes batches, all shares are free.
TEST(StageTwoAgainstIpopt, IsTheRelaxationWhereNothingIsToBeRounded) {
  compare_stage_two({.dearest = 20.0, .pairs = true}, kAll);
}

TEST(StageTwoAgainstIpopt, IsTheRelaxationWithRateCapsWhereNothingIsToBeRounded) {
  compare_stage_two({.dearest = 20.0, .caps = true}, kAll);
}

TEST(StageTwoAgainstIpopt, HoldsForQueuesBesideRateCapsOnOneCore) {
  for (std::size_t queues = 1; queues <= 4; ++queues) {
    for (std::uint64_t seed = 1; seed <= 150; ++seed) {
      SCOPED_TRACE(std::to_string(queues) + " queues, seed " + std::to_string(seed));
      Instance instance = instance_of(planner::random_case(seed, {.subchains = 4, .dearest = 20.0, .caps = true}, 1));
      for (std::size_t i = 0; i < queues; ++i) instance.members[i].queue = true;
      compare_stage_two(instance);
    }
  }
}

}  // namespace
}  // namespace ctn::solvers
