#include "policy/step_cost.h"

#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "trial/trial.h"

namespace ctn::policy {
namespace {

constexpr std::uint64_t kWindow = 200;  // steps
constexpr std::size_t kWindows = 5;
constexpr double kFactorMoved = 0.25;

double assumed(std::uint64_t by_timer, std::uint64_t by_event) {
  constexpr trial::Overheads kAssumed;
  const auto each = [&](Nanos step) { return static_cast<double>((step + kAssumed.context_switch).count()); };
  return static_cast<double>(by_timer) * each(kAssumed.dispatch_timer) +
         static_cast<double>(by_event) * each(kAssumed.dispatch_event);
}

}  // namespace

void StepCost::saw(Nanos cpu, std::uint64_t by_timer, std::uint64_t by_event) {
  if (by_timer + by_event < by_timer_ + by_event_ + kWindow) return;
  const double factor = static_cast<double>((cpu - cpu_).count()) / assumed(by_timer - by_timer_, by_event - by_event_);
  cpu_ = cpu;
  by_timer_ = by_timer;
  by_event_ = by_event;
  if (factor <= 0.0) return;  // a clock that says so is wrong
  recent_.push_back(factor);
  if (recent_.size() < kWindows) return;
  if (recent_.size() > kWindows) recent_.erase(recent_.begin());
  const double now = median_of(recent_);
  if (std::abs(now - factor_) > kFactorMoved * std::max(now, factor_)) factor_ = now;
}

}  // namespace ctn::policy
