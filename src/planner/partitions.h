// All ways to divide few subchains among cores, by dynamic programming over sets: the least that any costs under given
// prices, and all those that cost less than a limit.
//
// Units: milliseconds. Thread safety: one object a thread.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "planner/instance.h"
#include "planner/pieces.h"

namespace ctn::planner {

class Partitions {
 public:
  Partitions(const Instance& instance, Prices& prices) : instance_(instance), prices_(prices) {
    const std::size_t sets = std::size_t{1} << instance.members.size();
    group_.assign(sets, 0.0);
    exact_.assign(sets, 0);
    least_.assign(static_cast<std::size_t>(instance.cores) + 1,
                  std::vector<double>(sets, std::numeric_limits<double>::infinity()));
    for (Set set = 1; set < sets; ++set) {
      if (std::has_single_bit(set)) continue;
      const bool small = std::popcount(set) <= kSmallGroup;
      group_[set] = small ? prices_.of({set, 1}) : prices_.simple(set);
      exact_[set] = small ? 1 : 0;
    }
    for (auto& of_none : least_) of_none[0] = 0.0;
    for (Set set = 1; set < sets; ++set) {
      least_[1][set] = std::has_single_bit(set) ? prices_.of_owned(std::countr_zero(set), 1) : group_[set];
    }
    for (int cores = 2; cores < instance.cores; ++cores) {
      for (Set set = 1; set < sets; ++set) least_[static_cast<std::size_t>(cores)][set] = cheapest(set, cores);
    }
    // Of all cores only the whole is asked for.
    if (instance.cores > 1) least_.back().back() = cheapest(sets - 1, instance.cores);
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
  static constexpr int kSmallGroup = 5;  // subchains: larger groups are priced by a simpler bound at first
  static constexpr std::size_t kPartitions = 200'000;

  // The piece that the first subchain of the set is in.
  template <class Each>
  void each_first_piece(Set set, int cores, Each each) {
    const Set first = set & (~set + 1);
    const int i = std::countr_zero(set);
    for (int k = 1; k <= cores; ++k) {
      const double price = prices_.of_owned(i, k);
      if (k > prices_.most_owned(i)) break;
      if (std::isfinite(price)) each(Piece{first, k}, price);
    }
    const Set others = set & ~first;
    for (Set chosen = others; chosen != 0; chosen = (chosen - 1) & others) {
      each(Piece{first | chosen, 1}, group_[first | chosen]);
    }
  }

  double cheapest(Set set, int cores) {
    double least = std::numeric_limits<double>::infinity();
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

}  // namespace ctn::planner
