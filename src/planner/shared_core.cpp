#include "planner/shared_core.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMeeting = 1e-9;  // t squared

}  // namespace

const SharedCore::Answer& SharedCore::solve(double usable, double min_frame, double max_frame) {
  usable_ = usable;
  least_frame_ = 0.0;
  most_frame_ = kInfinity;
  limited_ = false;
  clear();
  if (!(usable > 0.0) || min_frame > max_frame * (1.0 + kSameFrame)) return answer_;
  // Most frames are as long as they like: then a short part of the walk will do.
  double from = 0.0;
  double to = kInfinity;
  if (narrow(from, to)) {
    walk(from, to);
    if (answer_.feasible && answer_.frame >= min_frame && answer_.frame <= max_frame) return answer_;
  }
  clear();
  least_frame_ = min_frame;
  most_frame_ = max_frame;
  limited_ = true;
  walk(0.0, kInfinity);
  return answer_;
}

void SharedCore::clear() {
  answer_.feasible = false;
  answer_.value = kInfinity;
}

// The values of t squared between which the best point is, were the frame not bounded. With n not whole, the sum that
// is minimised is convex in log t and never above the true one: where it exceeds what one point attains, nothing better
// can be. False: not worth the while.
bool SharedCore::narrow(double& from, double& to) {
  constexpr double kWorthwhile = 12.0;  // steps
  double steps = 0.0;
  double first = 0.0;
  double last = kInfinity;
  double lowest = kInfinity;
  double highest = 0.0;
  bends_.clear();
  for (const Item& item : items_) {
    if (item.cost <= 0.0) {
      bends_.push_back({0.0, 0.0, item.weight * (item.free ? item.most : item.least)});
      continue;
    }
    if (item.weight <= 0.0) return false;
    const double root = std::sqrt(item.cost / item.weight);
    const Bend bend{root / item.most, item.free ? kInfinity : root / item.least,
                    2.0 * std::sqrt(item.weight * item.cost)};
    bends_.push_back(bend);
    steps += item.free ? 0.0 : item.most - item.least;
    first = std::max(first, bend.low);
    last = std::min(last, bend.high);
    lowest = std::min(lowest, bend.low);
    highest = std::max(highest, std::isfinite(bend.high) ? bend.high : bend.low);
  }
  if (steps < kWorthwhile || !(lowest > 0.0)) return false;
  // A point that is not far from the best, and the t where its own value is attained.
  double middle = std::sqrt(first * (std::isfinite(last) ? last : first));
  for (int look = 0; look < 3; ++look) {
    place(middle * middle);
    between(middle * middle, middle * middle);
    if (!answer_.feasible) return false;
    middle = std::sqrt((b_ + root_ * middle) / (a_ + root_ / middle));
    if (!(middle > 0.0) || !std::isfinite(middle)) return false;
  }
  const double limit = 2.0 * std::sqrt(answer_.value * usable_) * (1.0 + 1e-9);
  clear();
  if (relaxed_sum(middle) > limit) return false;
  const auto bisect = [&](double inside, double outside) {
    if (relaxed_sum(outside) <= limit) return outside;
    for (int i = 0; i < 12; ++i) {
      const double t = std::sqrt(inside * outside);
      (relaxed_sum(t) <= limit ? inside : outside) = t;
    }
    return outside;
  };
  const double low = bisect(middle, lowest * 0.5);
  const double high = bisect(middle, highest * 2.0);
  from = low * low;
  to = high * high;
  return true;
}

double SharedCore::relaxed_sum(double t) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const Item& item = items_[i];
    const Bend& bend = bends_[i];
    if (item.cost <= 0.0) {
      sum += t * bend.flat;
    } else if (t < bend.low) {
      sum += t * item.weight * item.most + item.cost / (t * item.most);
    } else if (t > bend.high) {
      sum += t * item.weight * item.least + item.cost / (t * item.least);
    } else {
      sum += bend.flat;
    }
  }
  return sum;
}

void SharedCore::walk(double from, double to) {
  place(from);
  next_.resize(items_.size());
  for (std::size_t i = 0; i < items_.size(); ++i) next_[i] = step_of(i);
  double reached = from;
  for (;;) {
    std::size_t first = 0;
    for (std::size_t i = 1; i < next_.size(); ++i) {
      if (next_[i] < next_[first]) first = i;
    }
    if (next_.empty() || !(next_[first] <= to) || next_[first] == kInfinity) break;
    const double at = next_[first];
    if (at > reached) {
      between(reached, at);
      reached = at;
    }
    take(first, at);
    ++steps_;
    // Frames only get longer from here on.
    if (limited_ && b_ > most_frame_ * usable_ * (1.0 + kSameFrame)) return;
  }
  between(reached, to);
}

// Every n as it is best for this t squared; the larger of two that are equal.
void SharedCore::place(double at) {
  root_ = 0.0;
  now_.resize(items_.size());
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const Item& item = items_[i];
    double n = item.most;
    if (item.cost <= 0.0) {
      // What costs nothing gains nothing by running less often.
      n = item.free ? item.most : item.least;
    } else if (item.weight > 0.0 && at > 0.0) {
      const double ratio = item.cost / (item.weight * at);
      if (item.free) {
        if (ratio < item.most * item.most) {
          now_[i] = 0.0;
          root_ += std::sqrt(item.weight * item.cost);
          continue;
        }
      } else {
        // n (n - 1) < ratio
        n = std::clamp(std::floor(0.5 * (1.0 + std::sqrt(1.0 + 4.0 * ratio))), item.least, item.most);
        while (n > item.least && n * (n - 1.0) >= ratio) n -= 1.0;
      }
    }
    now_[i] = n;
  }
  add_up();
}

// Anew rather than by differences: nothing may be left of items that follow t.
void SharedCore::add_up() {
  a_ = 0.0;
  b_ = 0.0;
  for (std::size_t i = 0; i < items_.size(); ++i) {
    if (now_[i] == 0.0) continue;
    a_ += items_[i].weight * now_[i];
    b_ += items_[i].cost / now_[i];
  }
}

// The t squared at which an item takes its next step; infinite where it takes none.
double SharedCore::step_of(std::size_t i) const {
  const Item& item = items_[i];
  const double n = now_[i];
  if (item.weight <= 0.0 || item.cost <= 0.0 || n == 0.0) return kInfinity;
  if (item.free) return item.cost / (item.weight * n * n);
  return n > item.least ? item.cost / (item.weight * n * (n - 1.0)) : kInfinity;
}

// All points of the curve for t squared from `from` to `to`, where no n takes a step.
void SharedCore::between(double from, double to) {
  if (!limited_ && from < to) {
    // The sum that is minimised is a minimum of smooth ones, so the best point is none where two of them meet: it is
    // where its own is least, at t squared = B / A.
    const double at = b_ / a_;
    if (at < from * (1.0 - kMeeting) || at > to * (1.0 + kMeeting)) return;
  }
  const double shortest = least_frame_ * usable_;
  const double longest = most_frame_ < kInfinity ? most_frame_ * usable_ * (1.0 + kSameFrame) : kInfinity;
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

void SharedCore::take(std::size_t i, double at) {
  const Item& item = items_[i];
  if (item.free) {
    root_ += std::sqrt(item.weight * item.cost);
    now_[i] = 0.0;
    add_up();
  } else {
    const double more = at * item.weight;  // C / (n (n - 1))
    if (limited_) cross(i, at, more);
    a_ -= item.weight;
    b_ += more;
    now_[i] -= 1.0;
  }
  next_[i] = step_of(i);
}

// Where the frame passes one of its limits in the middle of a step.
void SharedCore::cross(std::size_t i, double at, double more) {
  const Item& item = items_[i];
  const double t = std::sqrt(at);
  const double before = b_ + root_ * t;
  for (const double frame : {least_frame_, most_frame_}) {
    const double part = (frame * usable_ - before) / more;
    if (part <= kSameFrame || part >= 1.0 - kSameFrame) continue;
    const double a = a_ + (root_ > 0.0 ? root_ / t : 0.0) - part * item.weight;
    offer(a * frame, frame, t, static_cast<int>(i), now_[i] - part);
  }
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
