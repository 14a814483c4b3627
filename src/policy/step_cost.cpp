#include "policy/step_cost.h"

#include <algorithm>

namespace ctn::policy {
namespace {

constexpr std::uint64_t kWindow = 200;  // steps
constexpr std::size_t kWindows = 5;
constexpr double kMoved = 0.25;

Nanos median_of(std::vector<Nanos> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void StepCost::saw(Nanos cpu, std::uint64_t steps) {
  if (steps < steps_ + kWindow) return;
  recent_.push_back((cpu - cpu_) / static_cast<Nanos::rep>(steps - steps_));
  cpu_ = cpu;
  steps_ = steps;
  if (recent_.size() < kWindows) return;
  if (recent_.size() > kWindows) recent_.erase(recent_.begin());
  const Nanos now = median_of(recent_);
  const auto most = static_cast<double>(std::max(now, value_).count());
  if (static_cast<double>(std::max(now - value_, value_ - now).count()) > kMoved * most) value_ = now;
}

}  // namespace ctn::policy
