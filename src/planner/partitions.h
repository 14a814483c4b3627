// All ways to divide few subchains among cores, by dynamic programming over sets: the least that any costs under given
// prices, and all those that cost less than a limit. Cores of a kind are not told apart: what counts is how many of
// each kind are left.
//
// Units: milliseconds. Thread safety: one object a thread.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "planner/instance.h"
#include "planner/pieces.h"

namespace ctn::planner {

class Partitions {
 public:
  Partitions(const Instance& instance, Prices& prices) : instance_(instance), prices_(prices) {
    number_states();
    price_groups();
    const std::size_t sets = std::size_t{1} << instance.members.size();
    least_.assign(states_, std::vector<double>(sets, kInfinity));
    for (auto& of_none : least_) of_none[0] = 0.0;
    for (std::size_t state = 1; state + 1 < states_; ++state) {
      const int last = last_core(state);
      for (Bits set = 1; set < sets; ++set) least_[state][set] = last >= 0 ? whole(set, last) : cheapest(set, state);
    }
    // Of all cores only the whole is asked for.
    const int last = last_core(states_ - 1);
    least_.back().back() = last >= 0 ? whole(sets - 1, last) : cheapest(sets - 1, states_ - 1);
  }

  // How many numbers it has to look at, for so many subchains and cores: sets within sets, for each number of cores
  // left.
  static double steps(const Instance& instance) {
    double steps = std::pow(3.0, static_cast<double>(instance.members.size())) * instance.kind_count();
    for (const CoreKind& kind : instance.kinds) steps *= kind.count + (instance.kind_count() == 1 ? 0 : 1);
    return steps;
  }

  // The least that any partition costs.
  double bound() const { return prices_.constant() + least_.back().back(); }

  // All partitions whose bound is below `limit`, the best first; at most so many (`complete` tells).
  std::vector<std::pair<double, std::vector<Piece>>> below(double limit, bool& complete) {
    found_.clear();
    limit_ = limit;
    complete_ = true;
    pieces_.clear();
    descend(least_.back().size() - 1, states_ - 1, prices_.constant());
    std::stable_sort(found_.begin(), found_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    complete = complete_;
    return std::move(found_);
  }

  std::vector<Piece> best() {
    std::vector<Piece> pieces;
    Bits rest = least_.back().size() - 1;
    std::size_t state = states_ - 1;
    while (rest != 0) {
      const double target = least_[state][rest];
      Some chosen;
      each_first_piece(rest, state, [&](const Some& piece, double price) {
        const double value = price + least_[after(state, piece)][rest & ~piece.set];
        if (chosen.set == 0 && value <= target * (1.0 + 1e-14)) chosen = piece;
      });
      if (chosen.set == 0) return {};
      pieces.push_back(piece_of(chosen));
      rest &= ~chosen.set;
      state = after(state, chosen);
    }
    return pieces;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  static constexpr int kSmallGroup = 5;  // subchains: larger groups are priced by a simpler bound at first
  static constexpr std::size_t kPartitions = 200'000;

  using Bits = std::uint64_t;  // a set, as a number that counts
  struct Some {                // a piece
    Bits set = 0;
    int cores = 1;
    int kind = 0;
  };
  static Piece piece_of(const Some& some) { return {Set::of_bits(some.set), some.cores, some.kind}; }

  // A state is how many cores of each kind are left, as one number.
  void number_states() {
    states_ = 1;
    for (const CoreKind& kind : instance_.kinds) {
      stride_.push_back(states_);
      states_ *= static_cast<std::size_t>(kind.count) + 1;
    }
  }
  int left(std::size_t state, int kind) const {
    const auto k = static_cast<std::size_t>(kind);
    return static_cast<int>(state / stride_[k] % (static_cast<std::size_t>(instance_.kind(kind).count) + 1));
  }
  std::size_t after(std::size_t state, const Some& piece) const {
    return state - static_cast<std::size_t>(piece.cores) * stride_[static_cast<std::size_t>(piece.kind)];
  }
  // The kind of the one core that is left; -1 where there are more.
  int last_core(std::size_t state) const {
    for (int kind = 0; kind < instance_.kind_count(); ++kind) {
      if (instance_.kind(kind).count > 0 && stride_[static_cast<std::size_t>(kind)] == state) return kind;
    }
    return -1;
  }

  void price_groups() {
    const std::size_t sets = std::size_t{1} << instance_.members.size();
    group_.assign(instance_.kinds.size(), std::vector<double>(sets, 0.0));
    exact_.assign(instance_.kinds.size(), std::vector<char>(sets, 0));
    for (int kind = 0; kind < instance_.kind_count(); ++kind) {
      const auto k = static_cast<std::size_t>(kind);
      for (Bits set = 1; set < sets; ++set) {
        if (std::has_single_bit(set)) continue;
        const bool small = std::popcount(set) <= kSmallGroup;
        group_[k][set] = small ? prices_.of({Set::of_bits(set), 1, kind}) : prices_.simple(Set::of_bits(set), kind);
        exact_[k][set] = small ? 1 : 0;
      }
    }
  }

  // All of a set on the one core that is left.
  double whole(Bits set, int kind) const {
    if (std::has_single_bit(set)) return prices_.of_owned(std::countr_zero(set), 1, kind);
    return group_[static_cast<std::size_t>(kind)][set];
  }

  // The piece that the first subchain of the set is in.
  template <class Each>
  void each_first_piece(Bits set, std::size_t state, Each each) {
    const Bits first = set & (~set + 1);
    const int i = std::countr_zero(set);
    for (int kind = 0; kind < instance_.kind_count(); ++kind) {
      const int cores = left(state, kind);
      for (int k = 1; k <= std::min(cores, prices_.most_owned(i, kind)); ++k) {
        const double price = prices_.of_owned(i, k, kind);
        if (std::isfinite(price)) each(Some{first, k, kind}, price);
      }
      if (cores == 0) continue;
      const std::vector<double>& group = group_[static_cast<std::size_t>(kind)];
      const Bits others = set & ~first;
      for (Bits chosen = others; chosen != 0; chosen = (chosen - 1) & others) {
        each(Some{first | chosen, 1, kind}, group[first | chosen]);
      }
    }
  }

  double cheapest(Bits set, std::size_t state) {
    double least = kInfinity;
    each_first_piece(set, state, [&](const Some& piece, double price) {
      least = std::min(least, price + least_[after(state, piece)][set & ~piece.set]);
    });
    return least;
  }

  void descend(Bits rest, std::size_t state, double so_far) {
    if (!complete_) return;
    if (rest == 0) {
      if (found_.size() == kPartitions) {
        complete_ = false;
        return;
      }
      found_.emplace_back(so_far, pieces_);
      return;
    }
    each_first_piece(rest, state, [&](const Some& piece, double price) {
      const std::size_t then = after(state, piece);
      const double others = least_[then][rest & ~piece.set];
      if (so_far + price + others >= limit_) return;
      const auto kind = static_cast<std::size_t>(piece.kind);
      if (!std::has_single_bit(piece.set) && !exact_[kind][piece.set]) {
        group_[kind][piece.set] = price = prices_.of(piece_of(piece));
        exact_[kind][piece.set] = 1;
        if (so_far + price + others >= limit_) return;
      }
      pieces_.push_back(piece_of(piece));
      descend(rest & ~piece.set, then, so_far + price);
      pieces_.pop_back();
    });
  }

  const Instance& instance_;
  Prices& prices_;
  std::size_t states_ = 1;
  std::vector<std::size_t> stride_;         // by kind: what one core of it counts in a state
  std::vector<std::vector<double>> group_;  // by kind and set
  std::vector<std::vector<char>> exact_;    // by kind and set: group_ is more than the simple bound
  std::vector<std::vector<double>> least_;  // by state and set
  std::vector<std::pair<double, std::vector<Piece>>> found_;
  std::vector<Piece> pieces_;
  double limit_ = 0.0;
  bool complete_ = true;
};

}  // namespace ctn::planner
