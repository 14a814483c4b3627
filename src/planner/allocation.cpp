#include "planner/allocation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "planner/cover.h"
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
// Of many subchains, these parts of the effort: for the shares of what local search finds, and for closing the gap.
// More of it goes into proofs of less and less.
constexpr std::size_t kToTry = 64;
constexpr std::size_t kToCloseGap = 16;
constexpr std::size_t kToKeep = 4;     // of very many
constexpr double kWorthARound = 1e-3;  // of the value: what another round should gain where a plan is in force

class Joint {
 public:
  Joint(const Instance& instance, const Target& target, double cutoff, Effort& effort)
      : instance_(instance), cutoff_(cutoff), effort_(effort), solver_(instance, target) {}

  Planned run(const Allocation* warm, const Planned* known) {
    if (known) best_ = *known;
    if (instance_.cores() == 1 && instance_.members.size() > 1) {
      best_.bound = try_allocation(all_on_one());
      return std::move(best_);
    }
    if (warm) try_allocation(*warm, kQuickLook);
    Prices prices(instance_, solver_);
    if (instance_.members.size() <= kFew && Partitions::steps(instance_) <= kFewSteps) {
      few(prices);
    } else {
      many(prices, known ? nullptr : warm);
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

  double known() const { return best_.found ? std::min(best_.shares.value, cutoff_) : cutoff_; }
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

  // `again`: what a plan in force has, where there is one: then this is to be quick rather than thorough, if there are
  // very many.
  void many(Prices& prices, const Allocation* again) {
    best_.bound = -kInfinity;
    const bool very_many = instance_.members.size() > kCheap;
    // Local search has a use for any effort, the bounds for some.
    const std::size_t kept = very_many && !again ? effort_.left / kToKeep : 0;
    effort_.left -= kept;
    LocalSearch search(instance_, prices);
    // Whoever gives a cutoff has shares for the allocation to begin with, if none that are below it.
    const bool warm_will_do = again && std::isfinite(cutoff_);
    std::vector<Piece> pieces = best_.found    ? to_pieces(best_.allocation)
                                : warm_will_do ? to_pieces(*again)
                                               : search.start();
    std::vector<Piece> last;
    constexpr int kRounds = 6;
    for (int round = 0; round < kRounds && effort_.left > 0; ++round) {
      const double before = this->known();
      prices.refresh();
      raise_bound(std::max(spread_bound(instance_, prices), pooled_bound(instance_, prices)));
      search.improve(pieces, effort_);
      if (pieces == last) break;
      last = pieces;
      try_allocation(to_allocation(pieces, instance_.members.size()), std::max<std::size_t>(1, effort_.left / kToTry));
      if (very_many && again && this->known() > before * (1.0 - kWorthARound)) break;
    }
    effort_.left += kept;
    prices.refresh();
    raise_bound(std::max(spread_bound(instance_, prices), pooled_bound(instance_, prices)));
    if (!best_.found && !std::isfinite(cutoff_)) try_allocation(to_allocation(pieces, instance_.members.size()));
    // Where cores differ, spreading is all that is known.
    if (best_.found && best_.bound < limit() && instance_.kind_count() == 1) {
      if (!very_many || (!again && pair_cover_effort(instance_) < effort_.left)) close_gap(prices);
    }
  }

  void raise_bound(double bound) { best_.bound = std::max(best_.bound, bound); }

  // Bounds by covering, and partitions that by these may be better than what is known. Multipliers that are best for
  // one of them are poor for the others: the bound rises with those that suit them all.
  void close_gap(Prices& prices) {
    constexpr int kRounds = 8;
    Effort part{effort_.left / kToCloseGap};
    const std::size_t given = part.left;
    std::vector<double> multipliers = solver_.multipliers();
    PairCover start = cover_by_pairs(instance_, prices, to_pieces(best_.allocation), part);
    raise_bound(start.bound);
    for (int round = 0; round < kRounds && best_.bound < limit() && part.left > 0; ++round) {
      Cover cover(instance_, prices, std::move(start.prices), to_pieces(best_.allocation));
      raise_bound(cover.bound(limit(), part));
      if (best_.bound >= limit()) break;
      Cover::Partitions rivals = cover.below(limit(), part);
      multipliers = look_at(rivals, multipliers, part);
      // Where these are all, what a look leaves open is settled.
      if (rivals.complete_to >= limit()) settle(rivals, multipliers, part);
      double proven = std::min(rivals.complete_to, known());
      for (const auto& [bound, pieces] : rivals.found) proven = std::min(proven, bound);
      raise_bound(proven);
      if (cover.gave_up() || rivals.found.empty()) break;
      start.prices = cover.prices();
      solver_.set_multipliers(multipliers);
      prices.refresh();
    }
    effort_.spend(given - part.left);
  }

  // The most promising, each from the same multipliers. Returns a mean of these and of those that are best for each.
  std::vector<double> look_at(Cover::Partitions& rivals, const std::vector<double>& multipliers, Effort& part) {
    constexpr std::size_t kMost = 30;
    constexpr double kInertia = 3.0;
    std::vector<double> mean = multipliers;
    double weight = kInertia;
    const std::size_t looked_at = std::min(rivals.found.size(), kMost);
    for (std::size_t r = 0; r < looked_at && rivals.found[r].first < limit(); ++r) {
      try_rival(rivals.found[r], multipliers, kQuickLook, part);
      weight += 1.0;
      for (std::size_t m = 0; m < mean.size(); ++m) mean[m] += (solver_.multipliers()[m] - mean[m]) / weight;
    }
    return mean;
  }

  void settle(Cover::Partitions& rivals, const std::vector<double>& multipliers, Effort& part) {
    for (auto& rival : rivals.found) {
      if (rival.first < limit() && part.left > 0) try_rival(rival, multipliers, part.left / 2, part);
    }
  }

  // Raises the bound that comes with it.
  void try_rival(std::pair<double, std::vector<Piece>>& rival, const std::vector<double>& multipliers, std::size_t most,
                 Effort& part) {
    auto& [bound, pieces] = rival;
    const std::size_t before = effort_.left;
    solver_.set_multipliers(multipliers);
    bound = std::max(bound, try_allocation(to_allocation(pieces, instance_.members.size()), most));
    part.spend(before - effort_.left);
    effort_.left = before;  // which pays for the part as a whole
  }

  const Instance& instance_;
  double cutoff_;
  Effort& effort_;
  SharesSolver solver_;
  Planned best_;
  Allocation last_;
};

// Of the cores that are left; an empty set where they do not do.
Piece fewest_cores(const Instance& instance, std::size_t i, const std::vector<int>& spare) {
  Piece best;
  for (int kind = 0; kind < instance.kind_count(); ++kind) {
    const std::vector<Owned>& owned = instance.members[i].on_kind(kind).owned;
    const int most = std::min(static_cast<int>(owned.size()), spare[static_cast<std::size_t>(kind)]);
    for (int cores = 1; cores <= most; ++cores) {
      if (!std::isfinite(owned[static_cast<std::size_t>(cores - 1)].period)) continue;
      if (best.set.empty() || cores < best.cores) best = {Set::of(i), cores, kind};
      break;
    }
  }
  return best;
}

}  // namespace

Planned plan_exact_apart(const Instance& instance, const Target& target, double bound, Effort& effort) {
  SharesSolver solver(instance, target);
  Prices prices(instance, solver);
  std::vector<int> spare;
  for (const CoreKind& kind : instance.kinds) spare.push_back(kind.count);
  std::vector<Piece> pieces;
  Set others;
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    const Piece piece = instance.members[i].exact_period > 0.0 ? fewest_cores(instance, i, spare) : Piece{};
    if (piece.set.empty()) {
      others |= Set::of(i);
      continue;
    }
    pieces.push_back(piece);
    spare[static_cast<std::size_t>(piece.kind)] -= piece.cores;
  }
  const std::vector<Piece> rest = LocalSearch(instance, prices).start(others, spare);
  if (pieces.empty() || (rest.empty() && !others.empty())) return {};
  pieces.insert(pieces.end(), rest.begin(), rest.end());
  Planned planned = plan_shares(instance, target, to_allocation(pieces, instance.members.size()), effort);
  planned.bound = std::min(bound, planned.shares.value);
  return planned;
}

Planned plan_jointly(const Instance& instance, const Target& target, const Allocation* warm, const Planned* known,
                     double cutoff, Effort& effort) {
  return Joint(instance, target, cutoff, effort).run(warm, known);
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
