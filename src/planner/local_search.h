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
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return root(a) > root(b); });
    std::vector<Core> cores;
    for (int kind = 0; kind < instance_.kind_count(); ++kind) {
      const auto given = static_cast<std::size_t>(instance_.kind(kind).count);
      for (std::size_t core = 0; core < std::min(count, given); ++core) cores.push_back({{0, 1, kind}, 0.0});
    }
    for (const std::size_t i : order) {
      Core& best = *std::min_element(cores.begin(), cores.end(),
                                     [&](const Core& a, const Core& b) { return promise(i, a) < promise(i, b); });
      best.piece.set |= Set{1} << i;
      best.load += prices_.root(i, best.piece.kind);
    }
    std::vector<Piece> pieces;
    for (const Core& core : cores) pieces.push_back(core.piece);
    drop_empty(pieces);
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
  struct Core {
    Piece piece;
    double load = 0.0;  // the sum of its members' roots
  };

  static double finite(double price) { return std::isfinite(price) ? price : 1e30; }
  double price(const Piece& piece) { return piece.set == 0 ? 0.0 : finite(prices_.of(piece)); }
  static bool clearly(double gain, double of) { return gain > 1e-12 * std::abs(of) + 1e-300; }

  // Of all kinds: on the one where it is least.
  double root(std::size_t i) const {
    double least = prices_.root(i, 0);
    for (int kind = 1; kind < instance_.kind_count(); ++kind) least = std::min(least, prices_.root(i, kind));
    return least;
  }
  // What a core's load would be with it; where all are alike an empty core comes first, however small the loads.
  std::pair<bool, double> promise(std::size_t i, const Core& core) const {
    const bool alike = instance_.kind_count() == 1;
    return {alike && core.piece.set != 0, alike ? core.load : core.load + prices_.root(i, core.piece.kind)};
  }
  static void drop_empty(std::vector<Piece>& pieces) {
    std::erase_if(pieces, [](const Piece& piece) { return piece.set == 0; });
  }

  int spare(const std::vector<Piece>& pieces, int kind) const {
    int left = instance_.kind(kind).count;
    for (const Piece& piece : pieces) left -= piece.kind == kind ? piece.cores : 0;
    return left;
  }

  // What a spare core may be used for: `from` becomes `to`, and what is left of it `rest`.
  struct Gift {
    double gain = 0.0;
    Piece from;
    Piece to;
    Piece rest;
  };

  // The best use of one more core of a kind: for one that owns cores of it, for a member of a shared core, or for all
  // that share one of another kind.
  void look_for_gifts(const std::vector<Piece>& pieces, int kind, Gift& best) {
    for (const Piece& piece : pieces) {
      const double now = price(piece);
      const auto look = [&](const Piece& to, const Piece& rest) {
        const double gain = now - price(to) - price(rest);
        if (gain > best.gain && clearly(gain, now)) best = {gain, piece, to, rest};
      };
      if (piece.kind != kind && piece.cores == 1) look({piece.set, 1, kind}, {});
      if (std::has_single_bit(piece.set)) {
        if (piece.kind == kind) look({piece.set, piece.cores + 1, kind}, {});
        continue;
      }
      for (Set left = piece.set; left != 0; left &= left - 1) {
        const Set one = left & (~left + 1);
        look({one, 1, kind}, {piece.set & ~one, 1, piece.kind});
      }
    }
  }

  Gift best_gift(const std::vector<Piece>& pieces) {
    Gift best;
    for (int kind = 0; kind < instance_.kind_count(); ++kind) {
      if (spare(pieces, kind) > 0) look_for_gifts(pieces, kind, best);
    }
    return best;
  }

  static void give(std::vector<Piece>& pieces, const Gift& gift) {
    *std::find(pieces.begin(), pieces.end(), gift.from) = gift.to;
    if (gift.rest.set != 0) pieces.push_back(gift.rest);
  }

  bool give_spare_cores(std::vector<Piece>& pieces) {
    bool given = false;
    for (Gift gift = best_gift(pieces); gift.gain > 0.0; gift = best_gift(pieces)) {
      give(pieces, gift);
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
        any = better_pair(pieces[g], pieces[h], h > g) || any;
      }
    }
    // A core may be too slow to be of use.
    drop_empty(pieces);
    return any;
  }

  // The best move from one to the other, or, if `swaps`, exchange between them.
  bool better_pair(Piece& from, Piece& to, bool swaps) {
    const double now = price(from) + price(to);
    const bool alike = from.kind == to.kind;
    double best = now;
    Set best_from = from.set;
    Set best_to = to.set;
    const auto look = [&](Set at_from, Set at_to) {
      if (alike && (at_from == 0 || at_to == 0)) return;
      const double then = price({at_from, 1, from.kind}) + price({at_to, 1, to.kind});
      if (then < best && clearly(best - then, now)) {
        best = then;
        best_from = at_from;
        best_to = at_to;
      }
    };
    if (!alike && swaps) look(to.set, from.set);
    for (Set left = from.set; left != 0; left &= left - 1) {
      const Set one = left & (~left + 1);
      look(from.set & ~one, to.set | one);
      if (!swaps) continue;
      for (Set other = to.set; other != 0; other &= other - 1) {
        const Set two = other & (~other + 1);
        look((from.set & ~one) | two, (to.set & ~two) | one);
      }
    }
    if (!(best < now)) return false;
    from.set = best_from;
    to.set = best_to;
    return true;
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
      for (std::size_t h = 0; h < pieces.size(); ++h) {
        if (h == g || pieces[h].cores > 1 || (h < g && pieces[h].kind == pieces[g].kind)) continue;
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
    const Gift gift = best_gift(changed);
    if (!(gift.gain > 0.0)) return false;
    give(changed, gift);
    const double then = prices_.of_all(changed);
    if (!(std::isfinite(then) && clearly(now - then, now))) return false;
    pieces = std::move(changed);
    return true;
  }

  const Instance& instance_;
  Prices& prices_;
};

}  // namespace ctn::planner
