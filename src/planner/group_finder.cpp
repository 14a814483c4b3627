#include "planner/group_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-12;
constexpr std::size_t kLooksAStep = 8;  // of effort

bool cheaper(const std::pair<double, Column>& a, const std::pair<double, Column>& b) {
  if (a.first != b.first) return a.first < b.first;
  return a.second.piece.set < b.second.piece.set;
}

}  // namespace

GroupFinder::GroupFinder(const Instance& instance, Prices& prices) : instance_(instance), prices_(prices) {
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    const Member& member = instance.members[i];
    plain_.push_back(!member.queue && member.min_period == 0.0 && member.exact_period == 0.0);
    const int most = std::min(instance.cores(), prices.most_owned(static_cast<int>(i), 0));
    for (int cores = 1; cores <= most; ++cores) {
      const double cost = prices.of_owned(static_cast<int>(i), cores, 0);
      if (std::isfinite(cost)) alone_.push_back({{Set::of(i), cores}, cost});
    }
  }
}

bool GroupFinder::find(const CoverPrices& at, double threshold, std::size_t most, Effort& effort) {
  at_ = &at;
  threshold_ = threshold;
  most_ = most;
  all_ = true;
  found_.clear();
  sort_items();
  for (const Column& column : alone_) offer(column);
  add_members({}, 0, effort);
  std::sort_heap(found_.begin(), found_.end(), cheaper);
  return effort.left > 0;
}

void GroupFinder::sort_items() {
  items_.clear();
  for (std::size_t i = 0; i < instance_.members.size(); ++i) {
    const double root = prices_.root(i, 0);
    const double price = at_->members[i];
    const double free = price > 0.0 ? kInfinity : price < 0.0 ? -kInfinity : 0.0;
    items_.push_back({root > 0.0 ? price / root : free, root, price, Set::of(i), plain_[i] != 0});
  }
  std::stable_sort(items_.begin(), items_.end(), [](const Item& a, const Item& b) { return a.ratio > b.ratio; });
}

// The least reduced cost of the group with any of the items from there on, as if they could be had in part.
double GroupFinder::least_with_more(const Group& group, std::size_t from) const {
  double root = group.root;
  double worth = group.worth;
  for (std::size_t i = from; i < items_.size(); ++i) {
    const Item& item = items_[i];
    const double room = 0.5 * item.ratio - root;
    if (!(room > 0.0)) break;
    if (room < item.root) {
      root += room;
      worth += room * item.ratio;
      break;
    }
    root += item.root;
    worth += item.price;
  }
  return root * root * (1.0 - kRounding) - worth + at_->core;
}

void GroupFinder::add_members(const Group& group, std::size_t from, Effort& effort) {
  for (std::size_t i = from; i < items_.size(); ++i) {
    // Those that follow pay less for their root, so neither they nor more of them will do.
    if (least_with_more(group, i) >= threshold_) return;
    if (++looks_ % kLooksAStep == 0) effort.spend(1);
    if (effort.left == 0) return;
    const Item& item = items_[i];
    Group more{group.set | item.one, group.root + item.root, group.worth + item.price, group.plain && item.plain};
    if (least_with_more(more, i + 1) >= threshold_) continue;
    if (!group.set.empty()) {
      if (!more.plain) effort.spend(1);
      const double cost = prices_.of({more.set, 1});
      // What some cannot share, perhaps others can beside them: bounds on frames are not the same for all.
      if (std::isfinite(cost)) offer({{more.set, 1}, cost});
      if (more.plain) more.root = std::max(more.root, std::sqrt(cost));
    }
    add_members(more, i + 1, effort);
  }
}

void GroupFinder::offer(const Column& column) {
  const double reduced = column.reduced(*at_);
  if (reduced >= threshold_) return;
  found_.emplace_back(reduced, column);
  std::push_heap(found_.begin(), found_.end(), cheaper);
  if (found_.size() <= most_) return;
  all_ = false;
  std::pop_heap(found_.begin(), found_.end(), cheaper);
  found_.pop_back();
  threshold_ = found_.front().first;
}

}  // namespace ctn::planner
