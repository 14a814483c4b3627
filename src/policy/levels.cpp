#include "policy/levels.h"

#include <fmt/format.h>

namespace ctn::policy {

os::Level to_os(dispatch::Level level) {
  switch (level) {
    case dispatch::Level::kOrdinary:
      return os::Level::kOrdinary;
    case dispatch::Level::kBackground:
      return os::Level::kBackground;
    case dispatch::Level::kActive:
      return os::Level::kActive;
  }
  return os::Level::kOrdinary;
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
