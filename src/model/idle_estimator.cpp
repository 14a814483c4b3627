#include "model/idle_estimator.h"

#include <cmath>

namespace ctn::model {
namespace {

constexpr double kIdleMoved = 0.1;
constexpr double kAlmost = 0.05;

double whole_if_almost(double part) {
  if (part < kAlmost) return 0.0;
  return part > 1.0 - kAlmost ? 1.0 : part;
}

}  // namespace

void IdleEstimator::MovingMean::add(double value) {
  if (values_.size() < kWindow) {
    values_.push_back(value);
  } else {
    sum_ -= values_[oldest_];
    values_[oldest_] = value;
    oldest_ = (oldest_ + 1) % kWindow;
  }
  sum_ += value;
}

void IdleEstimator::add(bool idle, Nanos cpu) {
  part_.add(idle ? 1.0 : 0.0);
  if (idle) cost_.add(static_cast<double>(cpu.count()));
  if (part_.count() < kMinRuns) return;
  const double part = whole_if_almost(part_.mean());
  const bool is_bound = part == 0.0 || part == 1.0;
  if (part != told_.part && (is_bound || std::abs(part - told_.part) > kIdleMoved)) told_.part = part;
  if (cost_.count() == 0) return;
  const Millis cost{cost_.mean() / 1e6};
  if (std::abs((cost - told_.cost).count()) > kIdleMoved * told_.cost.count()) told_.cost = cost;
}

}  // namespace ctn::model
