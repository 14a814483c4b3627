// A good allocation of any number of subchains under given prices: from an even start, moves, swaps, and cores given
// and taken, until none is better.
//
// Most of what could be looked at is ruled out before it has a price: a group costs at least the square of the sum of
// its roots (pieces.h). What two groups have nothing to exchange, and what a group would do with one more core, is
// remembered until a group changes.
//
// Units: milliseconds. Thread safety: one object a thread.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "planner/instance.h"
#include "planner/pieces.h"

namespace ctn::planner {

class LocalSearch {
 public:
  LocalSearch(const Instance& instance, Prices& prices);

  // Every core has its share of the load, by the roots: largest first to where there is least.
  std::vector<Piece> start() const;
  // The same of some subchains on so many cores of each kind; nothing where there is none.
  std::vector<Piece> start(const Set& some, const std::vector<int>& cores) const;

  // Until no move is better, under the present prices.
  void improve(std::vector<Piece>& pieces, Effort& effort);

 private:
  struct Core {
    Piece piece;
    double load = 0.0;  // the sum of its members' roots
  };

  // What a spare core may be used for: `from` becomes `to`, and what is left of it `rest`.
  struct Gift {
    double gain = 0.0;
    Piece from;
    Piece to;
    Piece rest;
  };

  // What is remembered of a piece.
  struct Known {
    std::uint32_t number = 0;
    std::vector<std::optional<Gift>> gifts;  // by kind: the best use of one more core of it
  };
  struct Hash {
    std::size_t operator()(const Piece& piece) const {
      return piece.set.hash() ^ static_cast<std::size_t>(piece.cores * 64 + piece.kind);
    }
  };

  // Of the pieces as they are, those that gain most by a core of a kind, the best first: whatever two of them do, one
  // is left.
  struct Leader {
    double gain = 0.0;
    std::size_t piece = 0;
  };
  using Leaders = std::vector<std::vector<Leader>>;  // by kind; none where no gain is to be had

  static double finite(double price) { return std::isfinite(price) ? price : 1e30; }
  double price(const Piece& piece) { return piece.set.empty() ? 0.0 : finite(prices_.of(piece)); }
  static bool clearly(double gain, double of) { return gain > 1e-12 * std::abs(of) + 1e-300; }

  bool pay(Effort& effort, std::size_t fixed, std::size_t looks);
  double root(std::size_t i) const;
  double roots(const Set& set, int kind) const;
  std::pair<bool, double> promise(std::size_t i, const Core& core) const;
  int spare(const std::vector<Piece>& pieces, int kind) const;
  Known& known(const Piece& piece);
  const Gift& gift(const Piece& piece, int kind);
  Gift best_use(const Piece& piece, int kind);
  const Gift* best_gift(const std::vector<Piece>& pieces);
  bool give_spare_cores(std::vector<Piece>& pieces);
  bool move_or_swap(std::vector<Piece>& pieces, Effort& effort);
  bool better_pair(Piece& from, Piece& to, bool swaps, Effort& effort);
  bool merge_and_give(std::vector<Piece>& pieces, Effort& effort);
  Leaders leaders(const std::vector<Piece>& pieces);
  double least_merged(const std::vector<Piece>& pieces, std::size_t g, std::size_t h, const Leaders& leaders) const;
  bool accept(std::vector<Piece>& pieces, std::vector<Piece> changed, double now);

  const Instance& instance_;
  Prices& prices_;
  bool by_work_;  // is effort counted, and not by fixed prices
  // What a group costs at least, of the square of its roots. With rates its price may be less, by what rates cost
  // beside each other: of few subchains all are then looked at.
  double ruled_ = 0.0;
  std::size_t priced_ = 0;  // exchanges between two groups, at most
  std::size_t looks_ = 0;   // since the search began
  std::size_t paid_ = 0;    // of the work
  std::unordered_map<Piece, Known, Hash> known_;
  std::unordered_set<std::uint64_t> settled_;  // pairs of numbers
};

}  // namespace ctn::planner
