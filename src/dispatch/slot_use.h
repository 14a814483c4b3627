// What happened in the slots of a shared core, as its dispatcher tells it and records keep it.
//
// Units: in the types. Thread safety: plain values.
#pragma once

#include "base/ids.h"
#include "base/time.h"

namespace ctn::dispatch {

// A slot that is over, and had work.
struct SlotUse {
  int core = 0;  // as numbered in plans
  SubchainId subchain;
  TimePoint planned{};  // when it was to begin
  TimePoint begin{};    // when its own subchain became active: later if the slot was stolen from
  TimePoint end{};
  friend bool operator==(const SlotUse&, const SlotUse&) = default;
};

// An unfinished subchain went on in the slot of another one.
struct Steal {
  int core = 0;
  SubchainId thief;
  SubchainId victim;
  TimePoint begin{};
  TimePoint end{};
  friend bool operator==(const Steal&, const Steal&) = default;
};

}  // namespace ctn::dispatch
