// What steps of controllers take, as measured: CPU time from when one wakes until it sleeps again. It differs from
// machine to machine, and with whose threads they trigger; a planner for runs of a tenth of a millisecond has to know
// it.
//
// What is told is how many times as long they take as trials assume (trial::Overheads), of as many steps that a timer
// began, or something else; and it is steady: it changes when it was wrong by a quarter in most of the last windows.
//
// Thread safety: none; one owner.
#pragma once

#include <cstdint>
#include <vector>

#include "base/time.h"

namespace ctn::policy {

class StepCost {
 public:
  // So much CPU time has been used so far, in so many steps of each kind. To be called now and then.
  void saw(Nanos cpu, std::uint64_t by_timer, std::uint64_t by_event);

  // 1: as trials assume, as far as is known.
  double factor() const { return factor_; }

 private:
  // Up to the window that is under way.
  Nanos cpu_{0};
  std::uint64_t by_timer_ = 0;
  std::uint64_t by_event_ = 0;

  std::vector<double> recent_;  // factors of windows, the oldest first
  double factor_ = 1.0;
};

}  // namespace ctn::policy
