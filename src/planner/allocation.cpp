#include "planner/allocation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "planner/group_bound.h"
#include "planner/local_search.h"
#include "planner/partitions.h"
#include "planner/pieces.h"

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFewSteps = 2e7;       // of dynamic programming over sets: up to here
constexpr std::size_t kFew = 13;        // subchains: never more
constexpr std::size_t kQuickLook = 60;  // effort
constexpr std::size_t kLookedAt = 64;   // partitions

class Joint {
 public:
  Joint(const Instance& instance, const Target& target, Effort& effort)
      : instance_(instance), effort_(effort), solver_(instance, target) {}

  Planned run(const Allocation* warm, const Planned* known) {
    if (known) best_ = *known;
    if (warm) try_allocation(*warm, kQuickLook);
    if (instance_.cores() == 1 && instance_.members.size() > 1) {
      best_.bound = try_allocation(all_on_one());
      return std::move(best_);
    }
    Prices prices(instance_, solver_);
    if (instance_.members.size() <= kFew && Partitions::steps(instance_) <= kFewSteps) {
      few(prices);
    } else {
      many(prices);
    }
    if (best_.found) best_.bound = std::min(best_.bound, best_.shares.value);
    return std::move(best_);
  }

 private:
  // The one allocation that there is on one core.
  Allocation all_on_one() const {
    int kind = 0;
    while (instance_.kind(kind).count == 0) ++kind;
    Allocation allocation = Allocation::none(instance_.members.size());
    allocation.shared_cores = 1;
    for (std::size_t i = 0; i < instance_.members.size(); ++i) allocation.share(i, kind);
    return allocation;
  }

  double known() const { return best_.found ? best_.shares.value : kInfinity; }
  double limit() const { return proof_of(known()); }

  // Returns what is proven of it.
  double try_allocation(const Allocation& allocation) { return try_allocation(allocation, effort_.left); }

  // With no more effort than that.
  double try_allocation(const Allocation& allocation, std::size_t most) {
    Effort part{std::min(most, effort_.left)};
    const std::size_t given = part.left;
    Shares shares = solver_.solve(allocation, known(), part);
    effort_.spend(given - part.left);
    const double proven = shares.bound;
    if (shares.found && shares.value < known()) {
      best_.found = true;
      best_.allocation = allocation;
      best_.shares = std::move(shares);
    }
    return proven;
  }

  void few(Prices& prices) {
    best_.bound = -kInfinity;
    std::vector<double> multipliers = solver_.multipliers();
    // The multipliers that are best for the best partition are good for its rivals too.
    constexpr int kRounds = 2;
    for (int round = 0; round < kRounds; ++round) {
      prices.refresh();
      Partitions partitions(instance_, prices);
      const double bound = partitions.bound();
      if (bound > best_.bound) {
        best_.bound = bound;
        multipliers = solver_.multipliers();
      }
      if (best_.bound >= limit()) return;
      const std::vector<Piece> best = partitions.best();
      if (best.empty()) break;
      const Allocation allocation = to_allocation(best, instance_.members.size());
      const bool seen = allocation == last_;
      last_ = allocation;
      try_allocation(allocation, kQuickLook);
      if (best_.bound >= limit()) return;
      if (seen) break;
    }
    solver_.set_multipliers(multipliers);
    prices.refresh();
    Partitions partitions(instance_, prices);
    bool complete = true;
    std::vector<std::pair<double, std::vector<Piece>>> rivals = partitions.below(limit(), complete);
    // A look at the most promising first: the better the best that is known, the less there is to prove.
    const std::size_t looked_at = std::min(rivals.size(), kLookedAt);
    for (std::size_t r = 0; r < looked_at && rivals[r].first < limit(); ++r) {
      solver_.set_multipliers(multipliers);
      double& bound = rivals[r].first;
      bound = std::max(bound, try_allocation(to_allocation(rivals[r].second, instance_.members.size()), kQuickLook));
    }
    double left_open = kInfinity;
    for (const auto& [bound, pieces] : rivals) {
      if (bound >= limit()) continue;
      if (effort_.left == 0) {
        left_open = std::min(left_open, bound);
        continue;
      }
      solver_.set_multipliers(multipliers);
      left_open = std::min(left_open, try_allocation(to_allocation(pieces, instance_.members.size())));
    }
    const double proven = std::min(known(), left_open);
    if (complete) best_.bound = std::max(best_.bound, proven);
  }

  void many(Prices& prices) {
    best_.bound = -kInfinity;
    LocalSearch search(instance_, prices);
    std::vector<Piece> pieces = best_.found ? to_pieces(best_.allocation) : search.start();
    std::vector<Piece> last;
    constexpr int kRounds = 6;
    for (int round = 0; round < kRounds && effort_.left > 0; ++round) {
      prices.refresh();
      best_.bound = std::max({best_.bound, spread_bound(instance_, prices), pooled_bound(instance_, prices)});
      search.improve(pieces, effort_);
      if (pieces == last) break;
      last = pieces;
      const Allocation allocation = to_allocation(pieces, instance_.members.size());
      try_allocation(allocation, std::max<std::size_t>(1, effort_.left / 4));
    }
    prices.refresh();
    best_.bound = std::max({best_.bound, spread_bound(instance_, prices), pooled_bound(instance_, prices)});
    if (best_.bound < limit() && effort_.left > 0) {
      best_.bound = std::max(best_.bound, cover_bound(instance_, prices, pieces, effort_));
    }
  }

  const Instance& instance_;
  Effort& effort_;
  SharesSolver solver_;
  Planned best_;
  Allocation last_;
};

}  // namespace

Planned plan_jointly(const Instance& instance, const Target& target, const Allocation* warm, const Planned* known,
                     Effort& effort) {
  return Joint(instance, target, effort).run(warm, known);
}

Planned plan_shares(const Instance& instance, const Target& target, const Allocation& allocation, Effort& effort) {
  SharesSolver solver(instance, target);
  Planned planned;
  planned.shares = solver.solve(allocation, kInfinity, effort);
  planned.found = planned.shares.found;
  planned.allocation = allocation;
  planned.bound = planned.shares.bound;
  return planned;
}

}  // namespace ctn::planner
