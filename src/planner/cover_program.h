// The prices at which groups are worth just what they cost: the linear program of covering every subchain by groups on
// no more cores than there are,
//
//   minimise   sum_j cost_j x_j
//   such that  sum of x_j over the groups that hold i = 1 for every subchain i,  sum_j cores_j x_j <= cores,  x >= 0
//
// by the primal simplex method over the groups given so far. Nothing rests on how exactly it is solved: its dual prices
// become a bound on all groups, given or not, with the least reduced cost there is (cover.h).
//
// Units: milliseconds. Thread safety: one object a thread.
#pragma once

#include <cstddef>
#include <vector>

#include "planner/pieces.h"

namespace ctn::planner {

// What being covered is worth to each subchain, and what a core costs (>= 0).
struct CoverPrices {
  std::vector<double> members;
  double core = 0.0;

  double worth(const Set& set) const {
    double sum = 0.0;
    for (const int i : set) sum += members[static_cast<std::size_t>(i)];
    return sum;
  }
  // What all subchains together would pay beyond the cores. No partition costs less, if no group is worth more than it
  // costs, its cores paid.
  double total(int cores) const {
    double sum = -core * cores;
    for (const double price : members) sum += price;
    return sum;
  }
};

struct Column {
  Piece piece;
  double cost = 0.0;

  double reduced(const CoverPrices& prices) const { return cost + piece.cores * prices.core - prices.worth(piece.set); }
};

class CoverProgram {
 public:
  // `most`: by subchain, a price that none is let above.
  CoverProgram(const std::vector<double>& most, int cores);

  void add(const Column& column) { columns_.push_back(column); }

  // Goes on from where the last call ended, for at most so many pivots. Returns how many steps it took (Effort).
  std::size_t solve(std::size_t most_pivots);

  const CoverPrices& prices() const { return prices_; }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  std::size_t rows() const { return prices_.members.size() + 1; }
  double* inverse(std::size_t row) { return inverse_.data() + row * rows(); }
  void price();
  std::size_t entering() const;
  std::size_t leaving(const Column& column);
  void pivot(std::size_t row, double cost);

  std::vector<Column> columns_;
  std::vector<double> inverse_;     // of the basis, by rows: one a subchain, and one for the cores
  std::vector<double> level_;       // of the basic variables, by row
  std::vector<double> basic_cost_;  // by row
  std::vector<double> direction_;   // of the entering column in terms of the basis
  CoverPrices prices_;
};

}  // namespace ctn::planner
