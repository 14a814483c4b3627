// What a step of a controller takes, as measured: CPU time from when it wakes until it sleeps again, the mean of all
// controllers. It differs from machine to machine, and with whose threads they trigger; who plans runs of a tenth of a
// millisecond has to know it.
//
// What is told is steady: it changes when it was wrong by a quarter in most of the last windows of steps.
//
// Units: Nanos. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/time.h"

namespace ctn::policy {

class StepCost {
 public:
  // So much has been used so far, in so many steps. To be called now and then.
  void saw(Nanos cpu, std::uint64_t steps);

  // 0: not known yet.
  Nanos value() const { return value_; }

 private:
  Nanos cpu_{0};               // up to the window that is under way
  std::uint64_t steps_ = 0;    // the same
  std::vector<Nanos> recent_;  // means of windows, the oldest first
  Nanos value_{0};
};

}  // namespace ctn::policy
