#include "planner/group_bound.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

}  // namespace

namespace {

double spread_over_alike(const Instance& instance, Prices& prices) {
  std::vector<double> heads;
  double mass = 0.0;
  const int cores = instance.cores();
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    const int index = static_cast<int>(i);
    const double alone = std::min(prices.of_owned(index, 1, 0), prices.root(i, 0) * prices.root(i, 0));
    double spread = alone;
    bool divisible = false;
    for (int k = 2; k <= prices.most_owned(index, 0); ++k) {
      const double price = prices.of_owned(index, k, 0);
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
  for (std::size_t i = static_cast<std::size_t>(cores); i < heads.size(); ++i) mass += heads[i];
  heads.resize(std::min(heads.size(), static_cast<std::size_t>(cores)));
  return prices.constant() + water_level_cost(heads, mass, cores);
}

// On a core of that kind a root is at least so many times what it is on one of the first.
double least_ratio(const Instance& instance, const Prices& prices, int kind) {
  double least = kInfinity;
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    if (prices.root(i, 0) > 0.0) least = std::min(least, prices.root(i, kind) / prices.root(i, 0));
  }
  return std::isfinite(least) ? least : 1.0;
}

// A load X, in roots on the first kind, costs at least (ratio X)^2 on one core of another; no load is indivisible.
double spread_over_kinds(const Instance& instance, Prices& prices) {
  std::vector<double> ratios;
  double capacity = 0.0;
  for (int kind = 0; kind < instance.kind_count(); ++kind) {
    ratios.push_back(least_ratio(instance, prices, kind));
    if (instance.kind(kind).count > 0) capacity += instance.kind(kind).count / (ratios.back() * ratios.back());
  }
  double mass = 0.0;
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    double root = prices.root(i, 0);
    for (int kind = 0; kind < instance.kind_count(); ++kind) {
      const double ratio = ratios[static_cast<std::size_t>(kind)];
      for (int k = 1; k <= prices.most_owned(static_cast<int>(i), kind); ++k) {
        root = std::min(root, std::sqrt(k * prices.of_owned(static_cast<int>(i), k, kind)) / ratio);
      }
    }
    mass += root;
  }
  return prices.constant() + (capacity > 0.0 && std::isfinite(capacity) ? mass * mass / capacity : 0.0);
}

// So much of what runs cost on a core of the first kind do all cores get done in a millisecond, at most.
double pooled_speed(const Instance& instance) {
  double sum = 0.0;
  for (int kind = 0; kind < instance.kind_count(); ++kind) {
    double speed = kind == 0 ? 1.0 : 0.0;
    for (const Member& member : instance.members) {
      if (member.on_kind(0).cost > 0.0) speed = std::max(speed, member.on_kind(0).cost / member.on_kind(kind).cost);
    }
    if (instance.kind(kind).count > 0) sum += instance.kind(kind).count * speed;
  }
  return sum;
}

}  // namespace

double spread_bound(const Instance& instance, Prices& prices) {
  return instance.kind_count() == 1 ? spread_over_alike(instance, prices) : spread_over_kinds(instance, prices);
}

double pooled_bound(const Instance& instance, Prices& prices) {
  struct Part {
    double weight = 0.0;  // at most what a millisecond of its period costs, whoever has which cores
    double cost = 0.0;    // on a core of the first kind
    double cap = 0.0;
  };
  std::vector<Part> parts;
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    const Member& member = instance.members[i];
    double weight = prices.weight(i);
    for (int kind = 0; kind < instance.kind_count(); ++kind) {
      const std::vector<Owned>& owned = member.on_kind(kind).owned;
      for (std::size_t k = 0; k < owned.size(); ++k) {
        const double period = owned[k].period;
        if (!std::isfinite(period) || period <= 0.0) continue;
        weight = std::min(weight, prices.of_owned(static_cast<int>(i), static_cast<int>(k + 1), kind) / period);
      }
    }
    parts.push_back({weight, member.on_kind(0).cost, std::max(member.min_period, member.exact_period)});
  }
  // p = max(cap, sqrt(C / b) / v); who is capped for some v is so for any larger one.
  double room = pooled_speed(instance) * instance.usable;
  double v = 0.0;
  std::vector<char> capped(parts.size(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    double roots = 0.0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (!capped[i]) roots += std::sqrt(parts[i].weight * parts[i].cost);
    }
    v = roots > 0.0 ? std::max(room, 0.0) / roots : kInfinity;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const Part& part = parts[i];
      if (capped[i] || part.cap <= 0.0 || part.weight <= 0.0) continue;
      if (!(std::sqrt(part.cost / part.weight) < part.cap * v)) continue;
      capped[i] = 1;
      room -= part.cost / part.cap;
      changed = true;
    }
  }
  double value = prices.constant();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (capped[i]) {
      value += parts[i].weight * parts[i].cap;
    } else if (v > 0.0 && std::isfinite(v)) {
      value += std::sqrt(parts[i].weight * parts[i].cost) / v;
    }
  }
  return value;
}

namespace {

constexpr int kCoverRounds = 400;
constexpr std::size_t kLargest = 2;  // members of a column

class PairPrices {
 public:
  PairPrices(const Instance& instance, Prices& prices) : instance_(instance), prices_(prices) {
    const std::size_t count = instance.members.size();
    for (std::size_t i = 0; i < count; ++i) {
      const int most = std::min(instance.cores(), prices.most_owned(static_cast<int>(i), 0));
      for (int k = 1; k <= most; ++k) add({i, i, k, prices.of_owned(static_cast<int>(i), k, 0)});
      for (std::size_t j = 0; j < i; ++j) add({j, i, 1, prices.of({Set::of(j) | Set::of(i), 1})});
    }
  }

  std::size_t choices() const { return choices_.size(); }

  PairCover improve(const std::vector<Piece>& known) {
    const std::size_t count = instance_.members.size();
    const double goal = start(known);
    if (!std::isfinite(goal)) return {-kInfinity, {std::vector<double>(count, 0.0), 0.0}};
    PairCover best{-kInfinity, at_};
    double patience = 1.0;
    int failures = 0;
    std::vector<int> covered(count);
    for (int round = 0; round < kCoverRounds; ++round) {
      const double value = evaluate(covered);
      if (value > best.bound) {
        best = {value, at_};
        failures = 0;
      } else if (++failures == 8) {
        patience *= 0.6;
        failures = 0;
        at_ = best.prices;
        if (patience < 1e-3) break;
        continue;
      }
      double norm = 0.0;
      for (const int times : covered) norm += (1.0 - times) * (1.0 - times);
      if (norm == 0.0 || goal - value <= 1e-12 * std::abs(goal)) break;
      const double step = patience * (goal - value) / norm;
      for (std::size_t i = 0; i < count; ++i) at_.members[i] += step * (1.0 - covered[i]);
    }
    return best;
  }

 private:
  // Cores of its own for one, or one core for two.
  struct Choice {
    std::size_t first = 0;
    std::size_t last = 0;
    int cores = 1;
    double cost = 0.0;
  };

  void add(const Choice& choice) {
    if (std::isfinite(choice.cost)) choices_.push_back(choice);
  }

  // What a group that is known costs, and its core, shared out among its members by their roots. Returns the cost of
  // all that is known.
  double start(const std::vector<Piece>& known) {
    double goal = prices_.constant();
    double sharing = 0.0;
    int shared = 0;
    for (const Piece& piece : known) {
      const double cost = prices_.of(piece);
      goal += cost;
      if (piece.set.single()) continue;
      sharing += cost;
      ++shared;
    }
    // What one more core would be worth: with even loads X on K cores, the cost K X^2 falls by X^2 for another.
    at_.core = shared > 0 ? sharing / shared : (goal - prices_.constant()) / instance_.cores();
    at_.members.assign(instance_.members.size(), 0.0);
    for (const Piece& piece : known) {
      const double worth = prices_.of(piece) + at_.core * piece.cores;
      const auto members = static_cast<double>(piece.set.size());
      double roots = 0.0;
      for (const int i : piece.set) roots += prices_.root(static_cast<std::size_t>(i), 0);
      for (const int i : piece.set) {
        const auto index = static_cast<std::size_t>(i);
        at_.members[index] = roots > 0.0 ? worth * prices_.root(index, 0) / roots : worth / members;
      }
    }
    return goal;
  }

  // The bound at the present cover prices, and how often its groups cover each subchain.
  double evaluate(std::vector<int>& covered) {
    const int cores = instance_.cores();
    std::vector<double> least(static_cast<std::size_t>(cores + 1), kInfinity);
    std::vector<const Choice*> of(static_cast<std::size_t>(cores + 1), nullptr);
    for (const Choice& choice : choices_) {
      const double first = at_.members[choice.first];
      const double reduced = choice.cost - (choice.first == choice.last ? first : first + at_.members[choice.last]);
      const auto k = static_cast<std::size_t>(choice.cores);
      if (reduced < least[k]) {
        least[k] = reduced;
        of[k] = &choice;
      }
    }
    const double larger = least_of_larger_groups();
    if (larger < least[1]) {
      least[1] = larger;
      of[1] = nullptr;
    }
    at_.core = 0.0;
    for (int k = 1; k <= cores; ++k) at_.core = std::max(at_.core, -least[static_cast<std::size_t>(k)] / k);
    // The cheapest way to fill the cores; one may stay empty.
    std::vector<double> filled(static_cast<std::size_t>(cores + 1), 0.0);
    std::vector<int> last(static_cast<std::size_t>(cores + 1), 0);
    for (int k = 1; k <= cores; ++k) {
      const auto at = static_cast<std::size_t>(k);
      filled[at] = filled[at - 1];
      for (int j = 1; j <= k; ++j) {
        const double with = filled[static_cast<std::size_t>(k - j)] + least[static_cast<std::size_t>(j)];
        if (with < filled[at]) {
          filled[at] = with;
          last[at] = j;
        }
      }
    }
    std::fill(covered.begin(), covered.end(), 0);
    for (int k = cores; k > 0;) {
      const int j = last[static_cast<std::size_t>(k)];
      if (j > 0) {
        if (const Choice* choice = of[static_cast<std::size_t>(j)]) {
          ++covered[choice->first];
          if (choice->last != choice->first) ++covered[choice->last];
        } else {
          for (const int i : larger_) ++covered[static_cast<std::size_t>(i)];
        }
      }
      k -= std::max(1, j);
    }
    double value = prices_.constant() + filled.back();
    for (const double price : at_.members) value += price;
    return value;
  }

  // A bound on the reduced cost of every group with more members than the columns have: (sum x)^2 is at least
  // 2 t (sum x) - t^2 for any t, and then every member counts for itself.
  double least_of_larger_groups() {
    const std::size_t count = instance_.members.size();
    if (count <= kLargest) return kInfinity;
    double best = -kInfinity;
    double total = 0.0;
    for (std::size_t i = 0; i < count; ++i) total += prices_.root(i, 0);
    const double even = total / instance_.cores();
    std::vector<std::pair<double, int>> gains(count);
    for (const double factor : {0.5, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0}) {
      const double t = factor * even;
      for (std::size_t i = 0; i < count; ++i)
        gains[i] = {2.0 * t * prices_.root(i, 0) - at_.members[i], static_cast<int>(i)};
      std::sort(gains.begin(), gains.end());
      double sum = -t * t;
      std::size_t taken = 0;
      while (taken < count && (taken <= kLargest || gains[taken].first < 0.0)) {
        sum += gains[taken++].first;
      }
      if (sum <= best) continue;
      best = sum;
      larger_.clear();
      for (std::size_t i = 0; i < taken; ++i) larger_.push_back(gains[i].second);
    }
    return best;
  }

  const Instance& instance_;
  Prices& prices_;
  std::vector<Choice> choices_;
  CoverPrices at_;           // a core costs so much that no group is worth more than it costs
  std::vector<int> larger_;  // a group that least_of_larger_groups found
};

}  // namespace

std::size_t pair_cover_effort(const Instance& instance) {
  const std::size_t count = instance.members.size();
  const auto cores = static_cast<std::size_t>(instance.cores());
  return count * (count + 1) / 2 + cores * cores * kCoverRounds / 2 / 1'000;
}

PairCover cover_by_pairs(const Instance& instance, Prices& prices, const std::vector<Piece>& known, Effort& effort) {
  PairPrices pairs(instance, prices);
  effort.spend(1 + pairs.choices());
  return pairs.improve(known);
}

}  // namespace ctn::planner
