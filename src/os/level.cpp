#include "os/level.h"

namespace ctn::os {

const char* to_string(Level level) {
  switch (level) {
    case Level::kOrdinary:
      return "ordinary";
    case Level::kBackground:
      return "background";
    case Level::kActive:
      return "active";
    case Level::kUnscheduled:
      return "unscheduled";
    case Level::kDispatcher:
      return "dispatcher";
  }
  return "fixed";
}

}  // namespace ctn::os
