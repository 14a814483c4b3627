#include "policy/levels.h"

#include <fmt/format.h>

#include <algorithm>

namespace ctn::policy {

os::Level to_os(dispatch::MemberLevel level) {
  switch (level) {
    case dispatch::MemberLevel::kOrdinary:
      return os::Level::kOrdinary;
    case dispatch::MemberLevel::kBackground:
      return os::Level::kBackground;
    case dispatch::MemberLevel::kActive:
      return os::Level::kActive;
  }
  return os::Level::kOrdinary;
}

void rise_above_assigned(Decision& decision) {
  int rank = -1;
  const auto take = [&](os::Level level) {
    rank = std::max(rank, static_cast<int>(level) - static_cast<int>(os::fixed_level(0)));
  };
  for (const SubchainPlace& place : decision.assignment.places) {
    take(place.level);
    for (const os::Level level : place.levels) take(level);
  }
  decision.unscheduled_level = os::Level::kUnscheduled;
  decision.dispatcher_level = os::Level::kDispatcher;
  if (rank < 0) return;
  decision.dispatcher_level = os::fixed_level(std::min(rank + 2, os::kFixedLevels - 1));
  decision.unscheduled_level = os::fixed_level(std::min(rank + 1, os::kFixedLevels - 2));
}

Status rise_above(Decision& decision, std::size_t ranks, const char* what) {
  const auto count = static_cast<int>(ranks);
  if (count + 2 > os::kFixedLevels) {
    return Error::caller(fmt::format("{} {} are more than there are fixed priorities", count, what),
                         "use another scheduler");
  }
  decision.unscheduled_level = os::fixed_level(count);
  decision.dispatcher_level = os::fixed_level(count + 1);
  return Done{};
}

}  // namespace ctn::policy
