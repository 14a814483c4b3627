#include "planner/cover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "planner/allocation.h"
#include "planner/group_bound.h"
#include "planner/random_apps.h"

namespace ctn::planner {
namespace {

using Partition = std::pair<double, std::vector<Piece>>;

// All partitions on no more than so many cores, with what they cost under the prices.
class EveryPartition {
 public:
  EveryPartition(const Instance& instance, Prices& prices) : instance_(instance), prices_(prices) { join(0); }

  std::vector<Partition> below(double limit) const {
    std::vector<Partition> cheap;
    std::copy_if(all_.begin(), all_.end(), std::back_inserter(cheap),
                 [&](const Partition& partition) { return partition.first < limit; });
    return cheap;
  }
  const Partition& best() const { return *std::min_element(all_.begin(), all_.end(), cheaper); }

 private:
  static bool cheaper(const Partition& a, const Partition& b) { return a.first < b.first; }

  void join(std::size_t i) {
    if (i == instance_.members.size()) return own(0, instance_.cores());
    for (std::size_t g = 0, count = pieces_.size(); g < count; ++g) {
      pieces_[g].set |= Set::of(i);
      join(i + 1);
      pieces_[g].set -= Set::of(i);
    }
    pieces_.push_back({Set::of(i), 1});
    join(i + 1);
    pieces_.pop_back();
  }

  void own(std::size_t g, int cores) {
    if (cores < 0) return;
    if (g == pieces_.size()) {
      all_.emplace_back(prices_.of_all(pieces_), pieces_);
      return;
    }
    const bool alone = pieces_[g].set.single();
    const int most = alone ? prices_.most_owned(pieces_[g].set.first(), 0) : 1;
    for (int k = 1; k <= most; ++k) {
      pieces_[g].cores = k;
      own(g + 1, cores - k);
    }
    pieces_[g].cores = 1;
  }

  const Instance& instance_;
  Prices& prices_;
  std::vector<Piece> pieces_;
  std::vector<Partition> all_;
};

std::vector<Partition> in_order(std::vector<Partition> partitions) {
  for (auto& [cost, pieces] : partitions) {
    std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.set < b.set; });
  }
  std::sort(partitions.begin(), partitions.end(), [](const Partition& a, const Partition& b) {
    return std::lexicographical_compare(a.second.begin(), a.second.end(), b.second.begin(), b.second.end(),
                                        [](const Piece& x, const Piece& y) {
                                          return std::pair{x.set, x.cores} < std::pair{y.set, y.cores};
                                        });
  });
  return partitions;
}

RandomCase some_case(std::uint64_t seed, RandomLimits limits) {
  limits.subchains = 5 + static_cast<int>(seed % 3);
  limits.chains = limits.subchains;
  limits.dearest = 20.0;
  limits.pairs = seed % 2 == 0;
  return random_case(seed, limits, 2 + static_cast<int>(seed / 3 % 3));
}

// Each case with the multipliers that are best for the best plan, as they are when gaps are closed.
struct Priced {
  explicit Priced(const RandomCase& any)
      : instance(make_instance(any.app, any.costs, any.cores, any.slack)),
        target(free_target(instance)),
        solver(instance, target),
        prices(instance, solver) {
    Effort effort;
    plan = plan_jointly(instance, target, nullptr, nullptr, std::numeric_limits<double>::infinity(), effort);
    if (!plan.found) return;
    solver.solve(plan.allocation, std::numeric_limits<double>::infinity(), effort);
    prices.refresh();
  }

  Instance instance;
  Target target;
  SharesSolver solver;
  Prices prices;
  Planned plan;
};

// Where cores differ too, nothing costs less than the simple bounds say.
TEST(GroupBound, IsNeverAboveTheBestPlan) {
  for (const bool kinds : {false, true}) {
    double closest = 0.0;
    for (std::uint64_t seed = 1; seed <= 120; ++seed) {
      SCOPED_TRACE(seed);
      RandomLimits limits;
      limits.kinds = kinds;
      limits.caps = seed % 3 == 0;
      Priced priced(some_case(seed, limits));
      ASSERT_TRUE(priced.plan.found);
      const double best = priced.plan.shares.value;
      const double bound =
          std::max(spread_bound(priced.instance, priced.prices), pooled_bound(priced.instance, priced.prices));
      EXPECT_LE(bound, best * (1.0 + 1e-9));
      closest = std::max(closest, bound / best);
    }
    EXPECT_GT(closest, 0.7) << "else it says nothing";
  }
}

TEST(Cover, FindsAllPartitionsBelowALimit) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Priced priced(some_case(seed, {.zeros = seed % 5 == 0}));
    const std::size_t count = priced.instance.members.size();
    const EveryPartition every(priced.instance, priced.prices);
    const double least = every.best().first;
    Effort effort;
    const std::vector<Piece> known = to_pieces(priced.plan.allocation);
    PairCover start = cover_by_pairs(priced.instance, priced.prices, known, effort);
    EXPECT_LE(start.bound, least * (1.0 + 1e-12)) << seed;
    ASSERT_EQ(start.prices.members.size(), count);

    const double limit = least * 1.02;
    Cover cover(priced.instance, priced.prices, start.prices, known);
    EXPECT_LE(cover.bound(limit, effort), least * (1.0 + 1e-12)) << seed;
    const Cover::Partitions cheap = cover.below(limit, effort);
    const std::vector<Partition> found = in_order(cheap.found);
    const std::vector<Partition> expected = in_order(every.below(cheap.complete_to));
    if (cheap.complete_to >= limit) {
      ASSERT_EQ(found.size(), expected.size()) << seed;
    }
    for (const Partition& partition : expected) {
      const auto same = std::find_if(found.begin(), found.end(),
                                     [&](const Partition& other) { return other.second == partition.second; });
      ASSERT_NE(same, found.end()) << seed;
      EXPECT_NEAR(same->first, partition.first, 1e-9 * partition.first) << seed;
    }
  }
}

// Whatever bounds frames, nothing is called a bound that the best plan is below, and no partition is lost whose shares
// cost less.
TEST(Cover, NeverExceedsTheBestPlan) {
  const std::vector<RandomLimits> kinds = {
      {.caps = true}, {.exact = true}, {.queue = true}, {.queue = true, .caps = true}};
  for (const RandomLimits& kind : kinds) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      Priced priced(some_case(seed, kind));
      if (!priced.plan.found) continue;
      const double best = priced.plan.shares.value;
      Effort effort;
      const std::vector<Piece> known = to_pieces(priced.plan.allocation);
      PairCover start = cover_by_pairs(priced.instance, priced.prices, known, effort);
      EXPECT_LE(start.bound, best * (1.0 + 1e-9)) << seed;
      Cover cover(priced.instance, priced.prices, start.prices, known);
      EXPECT_LE(cover.bound(best, effort), best * (1.0 + 1e-9)) << seed;
      const Cover::Partitions cheap = cover.below(best * 1.01, effort);
      const std::vector<Partition> own = in_order({{best, known}});
      const std::vector<Partition> found = in_order(cheap.found);
      const bool listed = std::any_of(found.begin(), found.end(),
                                      [&](const Partition& other) { return other.second == own.front().second; });
      EXPECT_TRUE(listed || cheap.complete_to <= best * (1.0 + 1e-9)) << seed;
    }
  }
}

TEST(Cover, ProvesWhatItCanWithLittleEffort) {
  for (const std::size_t steps : {0U, 1U, 3U, 10U, 30U, 100U}) {
    Priced priced(some_case(8, {}));
    Effort some{steps};
    Effort enough;
    const std::vector<Piece> known = to_pieces(priced.plan.allocation);
    PairCover start = cover_by_pairs(priced.instance, priced.prices, known, enough);
    Cover cover(priced.instance, priced.prices, start.prices, known);
    const double best = priced.plan.shares.value;
    EXPECT_LE(cover.bound(best, some), best);
    const Cover::Partitions cheap = cover.below(best * 1.01, some);
    EXPECT_LE(cheap.complete_to, best * 1.01);
    if (steps == 0) {
      EXPECT_TRUE(cover.gave_up());
    }
  }
}

// 20 subchains on 8 cores: the app with the widest gap when groups of more than a few members were not priced.
TEST(Cover, ClosesTheGapOfManySubchains) {
  const RandomCase any = random_case(11, {.subchains = 20, .chains = 20, .dearest = 20.0, .pairs = true}, 8);
  const Instance instance = make_instance(any.app, any.costs, any.cores, any.slack);
  const Target target = free_target(instance);
  Effort effort{300'000};
  const Planned plan =
      plan_jointly(instance, target, nullptr, nullptr, std::numeric_limits<double>::infinity(), effort);
  ASSERT_TRUE(plan.found);
  EXPECT_GE(plan.bound, plan.shares.value * (1.0 - 1e-6));
}

}  // namespace
}  // namespace ctn::planner
