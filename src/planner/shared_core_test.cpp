#include "planner/shared_core.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace ctn::planner {
namespace {

using Items = std::vector<SharedCore::Item>;
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}

  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11U) * 0x1.0p-53;
  }
  double log_uniform(double low, double high) { return low * std::pow(high / low, uniform(0.0, 1.0)); }

 private:
  std::mt19937_64 random_;
};

// The least by trying all whole numbers; a free item, if there is one, is the first.
double least_by_trying(const Items& items, double usable, double min_frame, double max_frame) {
  double best = kNoLimit;
  std::vector<double> every(items.size());
  const auto judge = [&](double a, double b) {
    const double frame = std::max(b / usable, min_frame);
    if (frame <= max_frame * (1.0 + 1e-12)) best = std::min(best, a * frame);
  };
  const auto choose = [&](auto& self, std::size_t i) -> void {
    if (i == items.size()) {
      double a = 0.0;
      double b = 0.0;
      for (std::size_t k = items.front().free ? 1 : 0; k < items.size(); ++k) {
        a += items[k].weight * every[k];
        b += items[k].cost / every[k];
      }
      if (!items.front().free) return judge(a, b);
      const SharedCore::Item& free = items.front();
      const double n = std::min(free.most, std::sqrt(a * free.cost / (free.weight * b)));
      return judge(a + free.weight * n, b + free.cost / n);
    }
    for (every[i] = items[i].least; every[i] <= items[i].most; every[i] += 1.0) self(self, i + 1);
  };
  choose(choose, items.front().free ? 1 : 0);
  return best;
}

Items some_items(Draw& draw, bool free, double lightest) {
  Items items;
  const int count = 2 + static_cast<int>(draw.uniform(0.0, 3.0));
  for (int i = 0; i < count; ++i) {
    const double cost = draw.log_uniform(1.0, 12.0);
    const bool is_free = free && i == 0;
    items.push_back({draw.log_uniform(lightest, 1.0), cost, 1.0, is_free ? cost : std::floor(cost), is_free});
  }
  return items;
}

TEST(SharedCore, FindsTheBestWholeNumbers) {
  for (std::uint64_t seed = 1; seed <= 800; ++seed) {
    SCOPED_TRACE(seed);
    Draw draw(seed);
    SharedCore core;
    core.items() = some_items(draw, false, 0.01);
    const double best = least_by_trying(core.items(), 0.94, 0.0, kNoLimit);
    const SharedCore::Answer& answer = core.solve(0.94, 0.0, kNoLimit);
    ASSERT_TRUE(answer.feasible);
    EXPECT_EQ(answer.split, -1);
    EXPECT_NEAR(answer.value, best, 1e-10 * best);
  }
}

// Weights of a millionth too: the part of the curve that is walked must not be taken too short.
TEST(SharedCore, FindsTheBestBesideAFreeShare) {
  for (std::uint64_t seed = 1; seed <= 800; ++seed) {
    SCOPED_TRACE(seed);
    Draw draw(seed);
    SharedCore core;
    core.items() = some_items(draw, true, seed % 2 == 0 ? 0.01 : 1e-6);
    const double best = least_by_trying(core.items(), 0.94, 0.0, kNoLimit);
    const SharedCore::Answer& answer = core.solve(0.94, 0.0, kNoLimit);
    ASSERT_TRUE(answer.feasible);
    EXPECT_NEAR(answer.value, best, 1e-9 * best);
  }
}

TEST(SharedCore, WithALimitedFrameItIsABoundAndTheBestWhereNothingIsSplit) {
  int whole = 0;
  int split = 0;
  for (std::uint64_t seed = 1; seed <= 800; ++seed) {
    SCOPED_TRACE(seed);
    Draw draw(seed);
    SharedCore core;
    core.items() = some_items(draw, false, 0.01);
    const double min_frame = draw.uniform(1.0, 15.0);
    const double max_frame = min_frame * draw.uniform(1.0, 3.0);
    const double best = least_by_trying(core.items(), 0.94, min_frame, max_frame);
    const SharedCore::Answer& answer = core.solve(0.94, min_frame, max_frame);
    if (!std::isfinite(best)) continue;
    ASSERT_TRUE(answer.feasible);
    EXPECT_LE(answer.value, best * (1.0 + 1e-10));
    EXPECT_TRUE(answer.split >= 0 || std::abs(answer.value - best) <= 1e-10 * best);
    ++(answer.split < 0 ? whole : split);
  }
  EXPECT_GT(whole, 50);
  EXPECT_GT(split, 50);
}

TEST(SharedCore, FreeSharesAloneFollowTheSquareRootLaw) {
  SharedCore core;
  core.items() = {{4.0, 1.0, 1.0, 100.0, true}, {1.0, 9.0, 1.0, 100.0, true}};
  const SharedCore::Answer& answer = core.solve(0.5, 0.0, 1000.0);
  ASSERT_TRUE(answer.feasible);
  EXPECT_NEAR(answer.value, (2.0 + 3.0) * (2.0 + 3.0) / 0.5, 1e-9);
}

TEST(SharedCore, NoFrameIsNoAnswer) {
  SharedCore core;
  core.items() = {{1.0, 10.0, 1.0, 2.0, false}, {1.0, 10.0, 1.0, 2.0, false}};
  EXPECT_FALSE(core.solve(1.0, 0.0, 9.9).feasible) << "at most half a run of each a frame takes 10";
  EXPECT_TRUE(core.solve(1.0, 0.0, 10.0).feasible);
  EXPECT_FALSE(core.solve(0.0, 0.0, 10.0).feasible);
  EXPECT_FALSE(core.solve(1.0, 20.0, 10.0).feasible);
}

}  // namespace
}  // namespace ctn::planner
