#include "planner/shared_core.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Frames that differ by no more than this part are the same.
constexpr double kRounding = 1e-12;

}  // namespace

const SharedCore::Answer& SharedCore::solve(double usable, double least_frame, double most_frame) {
  usable_ = usable;
  least_frame_ = least_frame;
  most_frame_ = most_frame;
  answer_.feasible = false;
  answer_.value = kInfinity;
  if (!(usable > 0.0) || least_frame > most_frame * (1.0 + kRounding)) return answer_;
  start();
  double reached = 0.0;
  while (!heap_.empty()) {
    const Step step = heap_.front();
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    heap_.pop_back();
    if (step.at > reached) {
      between(reached, step.at);
      reached = step.at;
    }
    take(step);
    ++steps_;
    // Frames only get longer from here on.
    if (b_ > most_frame_ * usable_ * (1.0 + kRounding)) return answer_;
  }
  between(reached, kInfinity);
  return answer_;
}

void SharedCore::start() {
  a_ = 0.0;
  b_ = 0.0;
  root_ = 0.0;
  heap_.clear();
  now_.resize(items_.size());
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const Item& item = items_[i];
    // What costs nothing gains nothing by running less often.
    now_[i] = item.cost > 0.0 ? item.most : item.free ? item.most : item.least;
    a_ += item.weight * now_[i];
    b_ += item.cost / now_[i];
    push(i);
  }
}

void SharedCore::push(std::size_t i) {
  const Item& item = items_[i];
  if (item.weight <= 0.0 || item.cost <= 0.0) return;
  const double n = now_[i];
  if (item.free) {
    heap_.push_back({item.cost / (item.weight * n * n), static_cast<int>(i)});
  } else if (n > item.least) {
    heap_.push_back({item.cost / (item.weight * n * (n - 1.0)), static_cast<int>(i)});
  } else {
    return;
  }
  std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
}

// All points of the curve for t squared from `from` to `to`, where no n takes a step.
void SharedCore::between(double from, double to) {
  const double shortest = least_frame_ * usable_;
  const double longest = most_frame_ * usable_ * (1.0 + kRounding);
  if (root_ <= 0.0) {
    if (b_ > longest) return;
    const double frame = std::max(b_ / usable_, least_frame_);
    offer(a_ * frame, frame, 0.0, -1, 0.0);
    return;
  }
  const double first = std::max(std::sqrt(from), (shortest - b_) / root_);
  const double last = std::min(std::sqrt(to), (longest - b_) / root_);
  if (first > last) return;
  // (a + root / t)(b + root t) is least at sqrt(b / a).
  const double best = a_ > 0.0 ? std::sqrt(b_ / a_) : b_ > 0.0 ? kInfinity : first;
  const double t = std::clamp(best, first, last);
  if (!(t > 0.0) || !std::isfinite(t)) return;
  const double frame = std::max((b_ + root_ * t) / usable_, least_frame_);
  offer((a_ + root_ / t) * frame, frame, t, -1, 0.0);
}

void SharedCore::take(const Step& step) {
  const auto i = static_cast<std::size_t>(step.item);
  const Item& item = items_[i];
  const double n = now_[i];
  if (item.free) {
    a_ -= item.weight * n;
    b_ -= item.cost / n;
    root_ += std::sqrt(item.weight * item.cost);
    now_[i] = 0.0;
    return;
  }
  const double t = std::sqrt(step.at);
  const double before = b_ + root_ * t;
  const double more = item.cost / (n * (n - 1.0));
  for (const double frame : {least_frame_, most_frame_}) {
    const double part = (frame * usable_ - before) / more;
    if (part <= kRounding || part >= 1.0 - kRounding) continue;
    const double a = a_ + (root_ > 0.0 ? root_ / t : 0.0) - part * item.weight;
    offer(a * frame, frame, t, step.item, n - part);
  }
  a_ -= item.weight;
  b_ += more;
  now_[i] = n - 1.0;
  push(i);
}

void SharedCore::offer(double value, double frame, double t, int split, double every_of_split) {
  if (value >= answer_.value) return;
  answer_.feasible = true;
  answer_.value = value;
  answer_.frame = frame;
  answer_.split = split;
  answer_.every = now_;
  for (std::size_t i = 0; i < items_.size(); ++i) {
    if (now_[i] == 0.0) answer_.every[i] = std::sqrt(items_[i].cost / items_[i].weight) / t;
  }
  if (split >= 0) answer_.every[static_cast<std::size_t>(split)] = every_of_split;
}

}  // namespace ctn::planner
