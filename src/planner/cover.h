// The cheapest ways to divide any number of subchains among cores under given prices: set partitioning.
//
// Every subchain pays a price for being covered, every core costs one; what a partition costs beyond what all pay for
// the cores is the sum of its groups' reduced costs, none of which is below zero. The prices are raised until that gap
// closes as far as it can (cover_program.h), by groups that are made as they are needed (group_finder.h). Few groups
// are then as cheap as a partition can afford that is better than what is known, and all partitions into these are
// found by depth-first search.
//
// Where effort runs out, what was proven so far holds.
//
// Units: milliseconds. Thread safety: one object a thread.
#pragma once

#include <utility>
#include <vector>

#include "planner/cover_program.h"
#include "planner/group_finder.h"
#include "planner/instance.h"
#include "planner/pieces.h"

namespace ctn::planner {

class Cover {
 public:
  struct Partitions {
    std::vector<std::pair<double, std::vector<Piece>>> found;  // with what they cost, the cheapest first
    double complete_to = 0.0;                                  // none that is not among them costs less
  };

  // The prices to begin with, and pieces that are of use.
  Cover(const Instance& instance, Prices& prices, CoverPrices start, const std::vector<Piece>& pieces);

  // A bound on what every partition costs; no better than `goal` is needed.
  double bound(double goal, Effort& effort);
  const CoverPrices& prices() const { return best_; }

  // Partitions that cost less than `limit`: all, or the cheapest. After bound().
  Partitions below(double limit, Effort& effort);

  // There are too many groups to find them all.
  bool gave_up() const { return gave_up_; }

 private:
  double total(const CoverPrices& at) const { return prices_.constant() + at.total(instance_.cores()); }
  bool find(const CoverPrices& at, double threshold, std::size_t most, Effort& effort);
  CoverPrices between(const CoverPrices& a, const CoverPrices& b, double part_of_b) const;

  const Instance& instance_;
  Prices& prices_;
  CoverPrices best_;
  double bound_;
  bool gave_up_ = false;
  CoverProgram program_;
  GroupFinder finder_;
};

}  // namespace ctn::planner
