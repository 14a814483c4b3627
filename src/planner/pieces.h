// Groups of an allocation as bit sets, and what each costs under the multipliers of a solver: the currency of
// everything that looks for a good allocation.
//
// Units: milliseconds. Thread safety: one object a thread.
#pragma once

#include <vector>

#include "planner/instance.h"
#include "planner/set.h"
#include "planner/shares.h"

namespace ctn::planner {

std::vector<int> members_of(const Set& set);

// A group of an allocation: a set, and how many cores of which kind it has. Several subchains have just one.
struct Piece {
  Set set;
  int cores = 1;
  int kind = 0;

  friend bool operator==(const Piece&, const Piece&) = default;
};

Allocation to_allocation(const std::vector<Piece>& pieces, std::size_t subchains);
std::vector<Piece> to_pieces(const Allocation& allocation);

// By set, a price: open addressing, because prices are looked up more often than anything else is done.
class PriceMemory {
 public:
  // The set's price, to be written where it is new. Good until the next call. The set is not empty.
  struct Place {
    double& price;
    bool fresh;
  };
  Place at(const Set& set);
  void clear();

 private:
  struct Entry {
    Set set;  // empty: nothing
    double price = 0.0;
  };
  Entry& place_of(const Set& set);
  void grow();

  std::vector<Entry> entries_;  // none, or a power of two
  std::size_t used_ = 0;
};

// What groups cost under the multipliers of a solver, remembered. Together with constant() the costs of the groups of
// an allocation add up to a lower bound on the value of its best shares.
class Prices {
 public:
  Prices(const Instance& instance, SharesSolver& solver) : instance_(instance), solver_(solver) { refresh(); }

  // Takes the solver's present multipliers.
  void refresh();

  double constant() const { return constant_; }
  double of(const Piece& piece);
  double of_owned(int subchain, int cores, int kind) const;  // infinite where it has no use for so many
  int most_owned(int subchain, int kind) const { return static_cast<int>(on(kind).owned[index(subchain)].size()); }
  // A bound that ignores whole numbers and rates: (sum of roots)^2, by Cauchy and Schwarz.
  double simple(const Set& set, int kind) const;
  double weight(std::size_t subchain) const { return weight_[subchain]; }
  double root(std::size_t subchain, int kind) const { return on(kind).root[subchain]; }
  double of_all(const std::vector<Piece>& pieces);

  // Of the prices that had to be found out since the object was made: what its work is measured in.
  std::size_t steps() const { return steps_; }

 private:
  struct OfKind {
    PriceMemory known;
    std::vector<double> root;                // by subchain
    std::vector<std::vector<double>> owned;  // by subchain, and cores - 1
  };
  const OfKind& on(int kind) const { return kinds_[index(kind)]; }
  static std::size_t index(int number) { return static_cast<std::size_t>(number); }

  const Instance& instance_;
  SharesSolver& solver_;
  double constant_ = 0.0;
  std::vector<double> weight_;
  std::vector<OfKind> kinds_;
  std::size_t steps_ = 0;
};

}  // namespace ctn::planner
