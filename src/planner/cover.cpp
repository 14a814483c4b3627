#include "planner/cover.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kPasses = 40;
constexpr std::size_t kNewColumns = 300;  // a pass
constexpr std::size_t kMostPivots = 2'000;
constexpr double kCloseEnough = 0.02;  // of the gap to the goal: what more prices could close
// New columns are looked for between the best prices so far and the program's: its own leap about.
constexpr double kTowardsProgram = 0.6;
constexpr std::size_t kSearchedColumns = 4'000;
constexpr std::size_t kMostFound = 128;  // partitions
constexpr std::size_t kMostNodes = 500'000;
constexpr std::size_t kNodesAStep = 256;  // of effort

std::vector<double> most_prices(const CoverPrices& start) {
  double sum = 0.0;
  for (const double price : start.members) sum += std::max(0.0, price);
  const double mean = sum / static_cast<double>(start.members.size());
  std::vector<double> most;
  for (const double price : start.members) most.push_back(1.2 * std::max(0.0, price) + 0.2 * mean);
  return most;
}

// All partitions into given columns whose reduced costs add up to less than a limit.
class PartitionSearch {
 public:
  PartitionSearch(const GroupFinder::Found& columns, std::size_t subchains, int cores, double core_price)
      : cores_(cores), core_price_(core_price), everyone_(Set::up_to(subchains)), by_first_(subchains) {
    std::vector<std::size_t> times(subchains, 0);
    for (const auto& [reduced, column] : columns) {
      for (const int i : column.piece.set) ++times[static_cast<std::size_t>(i)];
    }
    // The subchain with the fewest columns first. A set has its bits in that order here.
    order_.resize(subchains);
    std::iota(order_.begin(), order_.end(), 0);
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return times[a] < times[b]; });
    std::vector<std::size_t> rank(subchains);
    for (std::size_t r = 0; r < subchains; ++r) rank[order_[r]] = r;
    for (const auto& [reduced, column] : columns) {
      Set set;
      for (const int i : column.piece.set) set |= Set::of(rank[static_cast<std::size_t>(i)]);
      by_first_[static_cast<std::size_t>(set.first())].push_back({set, column.piece.cores, reduced});
    }
  }

  // False: there are too many, or they are too far to seek.
  bool run(double limit, Effort& effort) {
    limit_ = limit;
    nodes_ = 0;
    complete_ = true;
    found_.clear();
    descend(everyone_, cores_, 0.0);
    effort.spend(1 + nodes_ / kNodesAStep);
    std::stable_sort(found_.begin(), found_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    return complete_;
  }

  // By how much they cost more than the prices' total.
  const std::vector<std::pair<double, std::vector<Piece>>>& found() const { return found_; }

 private:
  struct Choice {
    Set set;
    int cores = 1;
    double reduced = 0.0;
  };

  void descend(const Set& rest, int cores, double so_far) {
    if (rest.empty()) return keep(so_far + cores * core_price_);
    for (const Choice& choice : by_first_[static_cast<std::size_t>(rest.first())]) {
      if (so_far + choice.reduced >= limit_) return;
      complete_ = complete_ && ++nodes_ <= kMostNodes;
      if (!complete_) return;
      if (choice.cores > cores || !choice.set.within(rest)) continue;
      chosen_.push_back(&choice);
      descend(rest - choice.set, cores - choice.cores, so_far + choice.reduced);
      chosen_.pop_back();
    }
  }

  void keep(double cost) {
    if (cost >= limit_) return;
    if (found_.size() == kMostFound) {
      complete_ = false;
      return;
    }
    std::vector<Piece> pieces;
    for (const Choice* choice : chosen_) {
      Piece& piece = pieces.emplace_back(Piece{{}, choice->cores});
      for (const int r : choice->set) piece.set |= Set::of(order_[static_cast<std::size_t>(r)]);
    }
    found_.emplace_back(cost, std::move(pieces));
  }

  int cores_;
  double core_price_;
  Set everyone_;
  std::vector<std::vector<Choice>> by_first_;  // the first member's rank; by rising cost
  std::vector<std::size_t> order_;             // subchain by rank
  double limit_ = 0.0;
  std::size_t nodes_ = 0;
  bool complete_ = true;
  std::vector<const Choice*> chosen_;
  std::vector<std::pair<double, std::vector<Piece>>> found_;
};

}  // namespace

Cover::Cover(const Instance& instance, Prices& prices, CoverPrices start, const std::vector<Piece>& pieces)
    : instance_(instance),
      prices_(prices),
      best_(std::move(start)),
      bound_(-kInfinity),
      program_(most_prices(best_), instance.cores()),
      finder_(instance, prices) {
  for (const Piece& piece : pieces) {
    const double cost = prices.of(piece);
    if (cost < kInfinity) program_.add({piece, cost});
  }
}

CoverPrices Cover::between(const CoverPrices& a, const CoverPrices& b, double part_of_b) const {
  CoverPrices mean = a;
  mean.core += part_of_b * (b.core - a.core);
  for (std::size_t i = 0; i < mean.members.size(); ++i) mean.members[i] += part_of_b * (b.members[i] - a.members[i]);
  return mean;
}

// Where a part of the effort does not do, all of it would not be well spent either.
bool Cover::find(const CoverPrices& at, double threshold, std::size_t most, Effort& effort) {
  Effort part{effort.left / 2};
  const std::size_t given = part.left;
  const bool done = finder_.find(at, threshold, most, part);
  effort.spend(given - part.left);
  gave_up_ = !done;
  return done;
}

double Cover::bound(double goal, Effort& effort) {
  for (int pass = 0; pass < kPasses; ++pass) {
    CoverPrices at = best_;
    if (pass > 0) {
      effort.spend(program_.solve(kMostPivots));
      if (total(program_.prices()) - bound_ < kCloseEnough * (goal - bound_)) break;
      at = between(best_, program_.prices(), kTowardsProgram);
    }
    if (!find(at, 0.0, kNewColumns, effort)) break;
    // A core dearer by as much as the cheapest group lacks, and no group is worth more than it costs.
    if (!finder_.found().empty()) at.core -= finder_.found().front().first;
    if (total(at) > bound_) {
      bound_ = total(at);
      best_ = std::move(at);
      if (bound_ >= goal) break;
    }
    for (const auto& [reduced, column] : finder_.found()) program_.add(column);
  }
  return bound_;
}

Cover::Partitions Cover::below(double limit, Effort& effort) {
  Partitions partitions{{}, bound_};
  if (gave_up_) return partitions;
  const double gap = limit - bound_;
  double share = 1.0;
  for (; share > 0.1; share *= 0.5) {
    if (!find(best_, share * gap, kSearchedColumns, effort)) return partitions;
    if (finder_.all()) break;
  }
  if (!finder_.all()) return partitions;
  PartitionSearch search(finder_.found(), instance_.members.size(), instance_.cores(), best_.core);
  for (const double part : {1.0 / 32, 1.0 / 16, 1.0 / 8, 1.0 / 4, 1.0 / 2, 1.0}) {
    const double level = part * share * gap;
    const bool complete = search.run(level, effort);
    if (complete || partitions.found.empty()) {
      partitions.found = search.found();
      for (auto& [cost, pieces] : partitions.found) cost += bound_;
    }
    if (!complete || effort.left == 0) break;
    partitions.complete_to = part * share < 1.0 ? bound_ + level : limit;
  }
  return partitions;
}

}  // namespace ctn::planner
