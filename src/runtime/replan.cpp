#include "runtime/replan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ctn::runtime {
namespace {

constexpr int kHangMultiple = 10;
constexpr Nanos kShortestHang = std::chrono::seconds{1};

bool differs(Millis before, Millis after) {
  return std::abs((after - before).count()) > kSwapThreshold * std::max(before, after).count();
}

}  // namespace

bool worth_a_swap(const plan::Plan& current, const plan::Plan& candidate) {
  for (std::size_t index = 0; index < candidate.subchains.size(); ++index) {
    const plan::SubchainPlan& before = current.subchains[index];
    const plan::SubchainPlan& after = candidate.subchains[index];
    if (before.cores != after.cores || before.threads != after.threads || before.every != after.every) return true;
    if (differs(before.period, after.period) || differs(before.execution, after.execution)) return true;
  }
  return false;
}

dispatch::Pacing pacing_of(const plan::SubchainPlan& subchain) {
  const Nanos hang_after = std::max(kShortestHang, to_nanos(subchain.execution * kHangMultiple));
  return dispatch::pacing_of_owned(subchain.period, subchain.execution, hang_after);
}

}  // namespace ctn::runtime
