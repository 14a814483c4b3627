// How to tell that the process of a dispatcher was stopped (SIGSTOP, a debugger) and goes on: a call comes much later
// than was asked for. Nothing of ours outranks the calling thread, and the kernel keeps a CPU from real-time threads
// for only 50 ms at a time. No subchain is charged for such a time, since the dispatcher gave it to none.
#pragma once

#include "base/time.h"

namespace ctn::dispatch {

constexpr Nanos kStandstill = std::chrono::milliseconds{250};

// `asked_for`: kNever where no call was asked for.
constexpr bool stood_still(TimePoint asked_for, TimePoint now) {
  return asked_for != kNever && now - asked_for >= kStandstill;
}

}  // namespace ctn::dispatch
