// A run that used more CPU time than its budget, as its controller tells it and records keep it.
//
// Units: in the types. Thread safety: plain values.
#pragma once

#include <cstdint>

#include "base/ids.h"
#include "base/time.h"

namespace ctn::dispatch {

struct Overrun {
  SubchainId subchain;
  std::uint64_t number = 0;  // of the trigger that its run goes back to
  TimePoint at{};            // when it was demoted
  Nanos cpu{0};              // that it had used by then
  friend bool operator==(const Overrun&, const Overrun&) = default;
};

}  // namespace ctn::dispatch
