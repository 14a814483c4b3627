// A good allocation of any number of subchains under given prices: from an even start, moves, swaps, and cores given
// and taken, until none is better.
//
// Units: milliseconds. Thread safety: one object a thread.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "planner/instance.h"
#include "planner/pieces.h"

namespace ctn::planner {

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

}  // namespace ctn::planner
