#include "planner/allocation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kFew = 12;  // subchains: up to here by dynamic programming
constexpr int kSmallGroup = 5;    // subchains: larger groups are priced by a simpler bound at first
constexpr std::size_t kPartitions = 200'000;
constexpr std::size_t kQuickLook = 400;  // effort
constexpr std::size_t kLookedAt = 40;    // partitions

using Set = std::uint64_t;

std::vector<int> members_of(Set set) {
  std::vector<int> members;
  for (; set != 0; set &= set - 1) members.push_back(std::countr_zero(set));
  return members;
}

// A group of an allocation: a set, and how many cores it has. Several subchains have just one.
struct Piece {
  Set set = 0;
  int cores = 1;

  friend bool operator==(const Piece&, const Piece&) = default;
};

Allocation to_allocation(const std::vector<Piece>& pieces, std::size_t subchains) {
  Allocation allocation;
  allocation.core_of.assign(subchains, -1);
  allocation.owned.assign(subchains, 0);
  for (const Piece& piece : pieces) {
    const std::vector<int> members = members_of(piece.set);
    if (members.size() == 1) {
      allocation.owned[static_cast<std::size_t>(members.front())] = piece.cores;
    } else {
      for (const int i : members) allocation.core_of[static_cast<std::size_t>(i)] = allocation.shared_cores;
      ++allocation.shared_cores;
    }
  }
  return allocation;
}

std::vector<Piece> to_pieces(const Allocation& allocation) {
  std::vector<Piece> pieces(static_cast<std::size_t>(allocation.shared_cores));
  for (std::size_t i = 0; i < allocation.core_of.size(); ++i) {
    if (allocation.core_of[i] >= 0) {
      pieces[static_cast<std::size_t>(allocation.core_of[i])].set |= Set{1} << i;
    } else {
      pieces.push_back({Set{1} << i, allocation.owned[i]});
    }
  }
  return pieces;
}

// What groups cost under the multipliers of a solver, remembered.
class Prices {
 public:
  Prices(const Instance& instance, SharesSolver& solver) : instance_(instance), solver_(solver) { refresh(); }

  void refresh() {
    const SharesSolver::Prices& prices = solver_.prices();
    constant_ = prices.constant;
    known_.clear();
    root_.clear();
    owned_.clear();
    for (std::size_t i = 0; i < instance_.members.size(); ++i) {
      const double weight = std::max(0.0, prices.period[i] + prices.execution[i] - solver_.cap(i));
      root_.push_back(std::sqrt(weight * instance_.members[i].cost / instance_.usable));
      std::vector<double>& owned = owned_.emplace_back();
      for (int k = 1; k <= static_cast<int>(instance_.members[i].owned.size()); ++k) {
        owned.push_back(solver_.price_of_owned(static_cast<int>(i), k));
      }
    }
  }

  double constant() const { return constant_; }

  double of(const Piece& piece) {
    if (std::has_single_bit(piece.set)) return of_owned(std::countr_zero(piece.set), piece.cores);
    const auto [known, fresh] = known_.try_emplace(piece.set, 0.0);
    if (fresh) known->second = solver_.price_of_shared(members_of(piece.set));
    return known->second;
  }
  double of_owned(int i, int cores) const {
    const std::vector<double>& owned = owned_[static_cast<std::size_t>(i)];
    return cores <= static_cast<int>(owned.size()) ? owned[static_cast<std::size_t>(cores - 1)] : kInfinity;
  }
  // A bound that ignores whole numbers and rates: (sum of roots)^2, by Cauchy and Schwarz.
  double simple(Set set) const {
    double sum = 0.0;
    for (Set rest = set; rest != 0; rest &= rest - 1) sum += root_[static_cast<std::size_t>(std::countr_zero(rest))];
    return sum * sum;
  }
  double root(std::size_t i) const { return root_[i]; }

  double of_all(const std::vector<Piece>& pieces) {
    double sum = constant_;
    for (const Piece& piece : pieces) sum += of(piece);
    return sum;
  }

 private:
  const Instance& instance_;
  SharesSolver& solver_;
  double constant_ = 0.0;
  std::unordered_map<Set, double> known_;
  std::vector<double> root_;
  std::vector<std::vector<double>> owned_;
};

// ---- Few subchains: dynamic programming over sets

class Partitions {
 public:
  Partitions(const Instance& instance, Prices& prices) : instance_(instance), prices_(prices) {
    const std::size_t sets = std::size_t{1} << instance.members.size();
    group_.assign(sets, 0.0);
    exact_.assign(sets, 0);
    least_.assign(static_cast<std::size_t>(instance.cores + 1), std::vector<double>(sets, kInfinity));
    for (Set set = 1; set < sets; ++set) {
      if (std::has_single_bit(set)) continue;
      const bool small = std::popcount(set) <= kSmallGroup;
      group_[set] = small ? prices_.of({set, 1}) : prices_.simple(set);
      exact_[set] = small ? 1 : 0;
    }
    for (auto& of_none : least_) of_none[0] = 0.0;
    for (int cores = 1; cores <= instance.cores; ++cores) {
      for (Set set = 1; set < sets; ++set) least_[static_cast<std::size_t>(cores)][set] = cheapest(set, cores);
    }
  }

  // The least that any partition costs.
  double bound() const { return prices_.constant() + least_.back().back(); }

  // All partitions whose bound is below `limit`, the best first; at most so many (`complete` tells).
  std::vector<std::pair<double, std::vector<Piece>>> below(double limit, bool& complete) {
    found_.clear();
    limit_ = limit;
    complete_ = true;
    pieces_.clear();
    descend(least_.back().size() - 1, instance_.cores, prices_.constant());
    std::stable_sort(found_.begin(), found_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    complete = complete_;
    return std::move(found_);
  }

  std::vector<Piece> best() {
    std::vector<Piece> pieces;
    Set rest = least_.back().size() - 1;
    int cores = instance_.cores;
    while (rest != 0) {
      const double target = least_[static_cast<std::size_t>(cores)][rest];
      Piece chosen;
      each_first_piece(rest, cores, [&](const Piece& piece, double price) {
        const double value = price + least_[static_cast<std::size_t>(cores - piece.cores)][rest & ~piece.set];
        if (chosen.set == 0 && value <= target * (1.0 + 1e-14)) chosen = piece;
      });
      if (chosen.set == 0) return {};
      pieces.push_back(chosen);
      rest &= ~chosen.set;
      cores -= chosen.cores;
    }
    return pieces;
  }

 private:
  // The piece that the first subchain of the set is in.
  template <class Each>
  void each_first_piece(Set set, int cores, Each each) {
    const Set first = set & (~set + 1);
    const int i = std::countr_zero(set);
    for (int k = 1; k <= cores; ++k) {
      const double price = prices_.of_owned(i, k);
      if (std::isfinite(price)) each(Piece{first, k}, price);
    }
    const Set others = set & ~first;
    for (Set chosen = others; chosen != 0; chosen = (chosen - 1) & others) {
      each(Piece{first | chosen, 1}, group_[first | chosen]);
    }
  }

  double cheapest(Set set, int cores) {
    double least = kInfinity;
    each_first_piece(set, cores, [&](const Piece& piece, double price) {
      least = std::min(least, price + least_[static_cast<std::size_t>(cores - piece.cores)][set & ~piece.set]);
    });
    return least;
  }

  void descend(Set rest, int cores, double so_far) {
    if (!complete_) return;
    if (rest == 0) {
      if (found_.size() == kPartitions) {
        complete_ = false;
        return;
      }
      found_.emplace_back(so_far, pieces_);
      return;
    }
    each_first_piece(rest, cores, [&](const Piece& piece, double price) {
      const double others = least_[static_cast<std::size_t>(cores - piece.cores)][rest & ~piece.set];
      if (so_far + price + others >= limit_) return;
      if (!std::has_single_bit(piece.set) && !exact_[piece.set]) {
        group_[piece.set] = price = prices_.of(piece);
        exact_[piece.set] = 1;
        if (so_far + price + others >= limit_) return;
      }
      pieces_.push_back(piece);
      descend(rest & ~piece.set, cores - piece.cores, so_far + price);
      pieces_.pop_back();
    });
  }

  const Instance& instance_;
  Prices& prices_;
  std::vector<double> group_;               // by set
  std::vector<char> exact_;                 // by set: group_ is more than the simple bound
  std::vector<std::vector<double>> least_;  // by cores and set
  std::vector<std::pair<double, std::vector<Piece>>> found_;
  std::vector<Piece> pieces_;
  double limit_ = 0.0;
  bool complete_ = true;
};

// ---- More: local search

double water_level_cost(std::vector<double> heads, double mass, int cores);

class LocalSearch {
 public:
  LocalSearch(const Instance& instance, Prices& prices) : instance_(instance), prices_(prices) {}

  // Every core has its share of the load, by the roots: largest first to where there is least.
  std::vector<Piece> start() const {
    const std::size_t count = instance_.members.size();
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return prices_.root(a) > prices_.root(b); });
    std::vector<Piece> pieces(std::min(count, static_cast<std::size_t>(instance_.cores)));
    std::vector<double> load(pieces.size(), 0.0);
    for (const std::size_t i : order) {
      std::size_t least = 0;
      for (std::size_t g = 0; g < pieces.size(); ++g) {
        const bool empty = pieces[g].set == 0;
        if (empty != (pieces[least].set == 0) ? empty : load[g] < load[least]) least = g;
      }
      pieces[least].set |= Set{1} << i;
      load[least] += prices_.root(i);
    }
    return pieces;
  }

  // Until no move is better.
  void improve(std::vector<Piece>& pieces, Effort& effort) {
    bool better = true;
    while (better && effort.left > 0) {
      better = give_spare_cores(pieces);
      better = move_or_swap(pieces, effort) || better;
      better = merge_and_give(pieces, effort) || better;
    }
  }

 private:
  static double finite(double price) { return std::isfinite(price) ? price : 1e30; }
  double price(Set set, int cores = 1) { return set == 0 ? 0.0 : finite(prices_.of({set, cores})); }
  static bool clearly(double gain, double of) { return gain > 1e-12 * std::abs(of) + 1e-300; }

  int spare(const std::vector<Piece>& pieces) const {
    int used = 0;
    for (const Piece& piece : pieces) used += piece.cores;
    return instance_.cores - used;
  }

  // The best use of one more core: for one that owns cores, or for a member of a shared one.
  double best_gift(const std::vector<Piece>& pieces, Piece& from, Piece& to, Piece& rest) {
    double best = 0.0;
    for (const Piece& piece : pieces) {
      const double now = price(piece.set, piece.cores);
      if (std::has_single_bit(piece.set)) {
        const double then = prices_.of_owned(std::countr_zero(piece.set), piece.cores + 1);
        if (now - then > best && clearly(now - then, now)) {
          best = now - then;
          from = piece;
          to = {piece.set, piece.cores + 1};
          rest = {};
        }
        continue;
      }
      for (Set left = piece.set; left != 0; left &= left - 1) {
        const Set one = left & (~left + 1);
        const double then = price(one) + price(piece.set & ~one);
        if (now - then > best && clearly(now - then, now)) {
          best = now - then;
          from = piece;
          to = {one, 1};
          rest = {piece.set & ~one, 1};
        }
      }
    }
    return best;
  }

  void give(std::vector<Piece>& pieces, const Piece& from, const Piece& to, const Piece& rest) {
    *std::find(pieces.begin(), pieces.end(), from) = to;
    if (rest.set != 0) pieces.push_back(rest);
  }

  bool give_spare_cores(std::vector<Piece>& pieces) {
    bool given = false;
    Piece from, to, rest;
    while (spare(pieces) > 0 && best_gift(pieces, from, to, rest) > 0.0) {
      give(pieces, from, to, rest);
      given = true;
    }
    return given;
  }

  bool move_or_swap(std::vector<Piece>& pieces, Effort& effort) {
    bool any = false;
    for (std::size_t g = 0; g < pieces.size(); ++g) {
      for (std::size_t h = 0; h < pieces.size(); ++h) {
        if (g == h || pieces[g].cores != 1 || pieces[h].cores != 1) continue;
        if (!effort.spend(4)) return any;
        const double now = price(pieces[g].set) + price(pieces[h].set);
        double best = now;
        Set best_g = pieces[g].set;
        Set best_h = pieces[h].set;
        const auto look = [&](Set at_g, Set at_h) {
          if (at_g == 0 || at_h == 0) return;
          const double then = price(at_g) + price(at_h);
          if (then < best && clearly(best - then, now)) {
            best = then;
            best_g = at_g;
            best_h = at_h;
          }
        };
        for (Set left = pieces[g].set; left != 0; left &= left - 1) {
          const Set one = left & (~left + 1);
          look(pieces[g].set & ~one, pieces[h].set | one);
          if (h < g) continue;
          for (Set other = pieces[h].set; other != 0; other &= other - 1) {
            const Set two = other & (~other + 1);
            look((pieces[g].set & ~one) | two, (pieces[h].set & ~two) | one);
          }
        }
        if (best < now) {
          pieces[g].set = best_g;
          pieces[h].set = best_h;
          any = true;
        }
      }
    }
    return any;
  }

  // Two groups on one core, and the core that this frees to whom it serves best; or one core less for an owner of
  // several.
  bool merge_and_give(std::vector<Piece>& pieces, Effort& effort) {
    const double now = prices_.of_all(pieces);
    for (std::size_t g = 0; g < pieces.size(); ++g) {
      if (pieces[g].cores > 1) {
        std::vector<Piece> changed = pieces;
        --changed[g].cores;
        if (accept(pieces, std::move(changed), now)) return true;
        continue;
      }
      for (std::size_t h = g + 1; h < pieces.size(); ++h) {
        if (pieces[h].cores > 1) continue;
        if (!effort.spend(16)) return false;
        std::vector<Piece> changed = pieces;
        changed[g].set |= changed[h].set;
        changed.erase(changed.begin() + static_cast<std::ptrdiff_t>(h));
        if (accept(pieces, std::move(changed), now)) return true;
      }
    }
    return false;
  }

  bool accept(std::vector<Piece>& pieces, std::vector<Piece> changed, double now) {
    Piece from, to, rest;
    if (!(best_gift(changed, from, to, rest) > 0.0)) return false;
    give(changed, from, to, rest);
    const double then = prices_.of_all(changed);
    if (!(std::isfinite(then) && clearly(now - then, now))) return false;
    pieces = std::move(changed);
    return true;
  }

  const Instance& instance_;
  Prices& prices_;
};

// The least sum of squares of loads, one a core, each at least its head, where `mass` is poured on top.
double water_level_cost(std::vector<double> heads, double mass, int cores) {
  heads.resize(static_cast<std::size_t>(cores), 0.0);
  std::sort(heads.begin(), heads.end());
  double filled = 0.0;
  std::size_t low = 0;
  double level = 0.0;
  for (; low < heads.size(); ++low) {
    filled += heads[low];
    level = (filled + mass) / static_cast<double>(low + 1);
    if (low + 1 == heads.size() || level <= heads[low + 1]) break;
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < heads.size(); ++i) sum += i <= low ? level * level : heads[i] * heads[i];
  return sum;
}

// A lower bound for any number of subchains. Each has a root y so that k cores of its own cost at least y^2 / k, and a
// group on one core at least the square of the sum of its roots; spreading the sum evenly is then the least. What gains
// nothing from a second core cannot be spread: it is a head, on a core of its own.
double spread_bound(const Instance& instance, Prices& prices) {
  std::vector<double> heads;
  double mass = 0.0;
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    const int index = static_cast<int>(i);
    const int most = static_cast<int>(instance.members[i].owned.size());
    const double alone = std::min(prices.of_owned(index, 1), prices.root(i) * prices.root(i));
    double spread = alone;
    bool divisible = false;
    for (int k = 2; k <= most; ++k) {
      const double price = prices.of_owned(index, k);
      if (price < alone) divisible = true;
      spread = std::min(spread, price * k);
    }
    if (divisible) {
      mass += std::sqrt(spread);
    } else {
      heads.push_back(std::sqrt(alone));
    }
  }
  std::sort(heads.begin(), heads.end(), std::greater<>());
  // As many heads as there are cores; more than one on a core is never better than moving one away.
  for (std::size_t i = static_cast<std::size_t>(instance.cores); i < heads.size(); ++i) mass += heads[i];
  heads.resize(std::min(heads.size(), static_cast<std::size_t>(instance.cores)));
  return prices.constant() + water_level_cost(heads, mass, instance.cores);
}

// ---- Both

class Joint {
 public:
  Joint(const Instance& instance, const Target& target, Effort& effort)
      : instance_(instance), effort_(effort), solver_(instance, target) {}

  Planned run(const Allocation* warm, const Planned* known) {
    if (known) best_ = *known;
    if (warm) try_allocation(*warm);
    if (instance_.cores == 1 && instance_.members.size() > 1) {
      // There is but one allocation.
      const std::size_t count = instance_.members.size();
      best_.bound = try_allocation({std::vector<int>(count, 0), std::vector<int>(count, 0), 1});
      return std::move(best_);
    }
    Prices prices(instance_, solver_);
    if (instance_.members.size() <= kFew) {
      few(prices);
    } else {
      many(prices);
    }
    if (best_.found) best_.bound = std::min(best_.bound, best_.shares.value);
    return std::move(best_);
  }

 private:
  double known() const { return best_.found ? best_.shares.value : kInfinity; }
  double limit() const { return known() - kProven * std::abs(known()); }

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
    constexpr int kRounds = 3;
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
      best_.bound = std::max(best_.bound, spread_bound(instance_, prices));
      search.improve(pieces, effort_);
      if (pieces == last) break;
      last = pieces;
      const Allocation allocation = to_allocation(pieces, instance_.members.size());
      try_allocation(allocation, std::max<std::size_t>(1, effort_.left / 4));
    }
    prices.refresh();
    best_.bound = std::max(best_.bound, spread_bound(instance_, prices));
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

// ---- Stage I

std::vector<Timing> equal_shares(const Instance& instance, const Allocation& allocation) {
  std::vector<int> sharing(static_cast<std::size_t>(allocation.shared_cores), 0);
  for (const int core : allocation.core_of) {
    if (core >= 0) ++sharing[static_cast<std::size_t>(core)];
  }
  std::vector<Timing> timings;
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    const Member& member = instance.members[i];
    if (allocation.core_of[i] < 0) {
      const Owned& owned = member.owned[static_cast<std::size_t>(allocation.owned[i] - 1)];
      timings.push_back({owned.period, owned.execution});
      continue;
    }
    const int rivals = sharing[static_cast<std::size_t>(allocation.core_of[i])];
    double period = std::max(rivals * member.cost / instance.usable, member.least_period);
    if (member.exact_period > 0.0) {
      period = period <= member.exact_period * (1.0 + kProven) ? member.exact_period : kInfinity;
    }
    timings.push_back({period, period});
  }
  return timings;
}

namespace {

// With equal shares only the *sizes* of the groups matter: subchain i has k cores of its own, or is one of m on a core.
// So the search chooses a class for each subchain, not a partner; those of a class are then put together in their
// order.
class StageOne {
 public:
  StageOne(const Instance& instance, const Target& target, Effort& effort)
      : instance_(instance), target_(target), effort_(effort) {
    const std::size_t count = instance.members.size();
    for (std::size_t i = 0; i < count; ++i) {
      const Member& member = instance.members[i];
      std::vector<Choice>& choices = choices_.emplace_back();
      for (int k = 1; k <= static_cast<int>(member.owned.size()); ++k) {
        const Owned& owned = member.owned[static_cast<std::size_t>(k - 1)];
        if (std::isfinite(owned.period)) choices.push_back({{owned.period, owned.execution}, k, 1});
      }
      for (int m = 2; m <= static_cast<int>(count); ++m) {
        double period = std::max(m * member.cost / instance.usable, member.least_period);
        if (member.exact_period > 0.0) {
          if (period > member.exact_period * (1.0 + kProven)) continue;
          period = member.exact_period;
        }
        choices.push_back({{period, period}, 1, m});
      }
      std::stable_sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) {
        return a.timing.period + a.timing.execution < b.timing.period + b.timing.execution;
      });
    }
    chosen_.assign(count, 0);
    in_class_.assign(count + 1, 0);
    timings_.resize(count);
  }

  Planned run() {
    Planned planned;
    for (std::size_t i = 0; i < choices_.size(); ++i) {
      if (choices_[i].empty()) return planned;
      timings_[i] = shortest(i);
    }
    descend(0, 0);
    planned.found = std::isfinite(best_);
    if (!planned.found) return planned;
    planned.allocation = built();
    planned.shares.value = best_;
    planned.bound = effort_.left > 0 ? best_ : 0.0;
    return planned;
  }

 private:
  struct Choice {
    Timing timing;
    int cores = 1;
    int rivals = 1;  // how many share the core, itself included
  };

  Timing shortest(std::size_t i) const {
    Timing timing{kInfinity, kInfinity};
    for (const Choice& choice : choices_[i]) {
      timing.period = std::min(timing.period, choice.timing.period);
      timing.execution = std::min(timing.execution, choice.timing.execution);
    }
    return timing;
  }

  double value() const {
    double sum = 0.0;
    for (const Group& group : target_.groups) sum += group.weight * value_of(group, timings_);
    return sum;
  }

  bool limits_hold() const {
    return std::all_of(target_.limits.begin(), target_.limits.end(),
                       [&](const Group& limit) { return value_of(limit, timings_) <= limit.limit * (1.0 + kProven); });
  }

  // Cores that the classes begun need, each of them full.
  int cores_needed(int owned) const {
    int cores = owned;
    for (std::size_t m = 2; m < in_class_.size(); ++m) {
      cores += static_cast<int>((static_cast<std::size_t>(in_class_[m]) + m - 1) / m);
    }
    return cores;
  }
  // Subchains that are still missing for all classes begun to be full.
  std::size_t missing() const {
    std::size_t sum = 0;
    for (std::size_t m = 2; m < in_class_.size(); ++m) {
      sum += (m - static_cast<std::size_t>(in_class_[m]) % m) % m;
    }
    return sum;
  }

  void descend(std::size_t i, int owned) {
    if (effort_.left == 0) return;
    if (i == choices_.size()) {
      if (missing() > 0 || !limits_hold()) return;
      const double found = value();
      if (found < best_) {
        best_ = found;
        best_choice_ = chosen_;
      }
      return;
    }
    const Timing before = timings_[i];
    for (std::size_t c = 0; c < choices_[i].size(); ++c) {
      const Choice& choice = choices_[i][c];
      const bool shares = choice.rivals > 1;
      if (shares) ++in_class_[static_cast<std::size_t>(choice.rivals)];
      const int used = owned + (shares ? 0 : choice.cores);
      timings_[i] = choice.timing;
      chosen_[i] = c;
      effort_.spend(1);
      if (cores_needed(used) <= instance_.cores && missing() <= choices_.size() - i - 1 &&
          value() < best_ - kProven * std::abs(best_) && limits_hold()) {
        descend(i + 1, used);
      }
      if (shares) --in_class_[static_cast<std::size_t>(choice.rivals)];
    }
    timings_[i] = before;
  }

  Allocation built() const {
    Allocation allocation;
    allocation.core_of.assign(choices_.size(), -1);
    allocation.owned.assign(choices_.size(), 0);
    std::map<int, std::pair<int, int>> open;  // class: core, and how many it has
    for (std::size_t i = 0; i < choices_.size(); ++i) {
      const Choice& choice = choices_[i][best_choice_[i]];
      if (choice.rivals == 1) {
        allocation.owned[i] = choice.cores;
        continue;
      }
      auto& [core, members] = open.try_emplace(choice.rivals, -1, choice.rivals).first->second;
      if (members == choice.rivals) {
        core = allocation.shared_cores++;
        members = 0;
      }
      allocation.core_of[i] = core;
      ++members;
    }
    return allocation;
  }

  const Instance& instance_;
  const Target& target_;
  Effort& effort_;
  std::vector<std::vector<Choice>> choices_;
  std::vector<std::size_t> chosen_;
  std::vector<std::size_t> best_choice_;
  std::vector<int> in_class_;  // by m
  std::vector<Timing> timings_;
  double best_ = kInfinity;
};

}  // namespace

Planned allocate_by_equal_shares(const Instance& instance, const Target& target, Effort& effort) {
  return StageOne(instance, target, effort).run();
}

}  // namespace ctn::planner
