// The groups that are worth more than they cost, or nearly so: all sets of subchains, of any size, whose reduced cost
// under cover prices is below a threshold.
//
// Members are added one after the other, those that pay most for their root (pieces.h) first. A group costs at least
// the square of the sum of its roots, so what any more members could bring is bounded by pouring them in, in that
// order, until the square grows faster than they pay; where that is not enough, no set beyond is looked at. The root of
// a group that has its exact price is known better: with whole numbers too,
//
//   min (A + A') (B + B') >= (sqrt(min A B) + sqrt(min A' B'))^2   by Cauchy and Schwarz,
//
// as long as nothing else bounds the frame.
//
// Units: milliseconds. Thread safety: one object a thread.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "planner/cover_program.h"
#include "planner/instance.h"
#include "planner/pieces.h"

namespace ctn::planner {

class GroupFinder {
 public:
  using Found = std::vector<std::pair<double, Column>>;  // with their reduced costs

  GroupFinder(const Instance& instance, Prices& prices);

  // All of reduced cost below `threshold`, cheapest first; where there are more than `most`, the cheapest of them, and
  // not all(). False: the effort ran out, and nothing is known of what was not found.
  bool find(const CoverPrices& at, double threshold, std::size_t most, Effort& effort);
  const Found& found() const { return found_; }
  bool all() const { return all_; }

 private:
  struct Item {
    double ratio = 0.0;  // price / root
    double root = 0.0;
    double price = 0.0;
    Set one;
    bool plain = true;
  };
  struct Group {
    Set set;
    double root = 0.0;  // of the least that it costs
    double worth = 0.0;
    bool plain = true;  // all members are
  };

  void sort_items();
  double least_with_more(const Group& group, std::size_t from) const;
  void add_members(const Group& group, std::size_t from, Effort& effort);
  void offer(const Column& column);

  const Instance& instance_;
  Prices& prices_;
  std::vector<char> plain_;    // by subchain: whole numbers, and no rate that bounds its frame
  std::vector<Column> alone_;  // subchains with cores of their own
  const CoverPrices* at_ = nullptr;
  double threshold_ = 0.0;
  std::size_t most_ = 0;
  bool all_ = true;
  std::size_t looks_ = 0;
  std::vector<Item> items_;  // by falling ratio
  Found found_;              // a heap, the dearest on top, while being filled
};

}  // namespace ctn::planner
