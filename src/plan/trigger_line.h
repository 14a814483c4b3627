// How often a subchain is triggered at most, as a line over time: what promises (promise.h), and what a search knows of
// them (planner/surrogate.h), are bounded by.
//
// Units: milliseconds. Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <vector>

#include "base/time.h"
#include "model/unscheduled.h"
#include "plan/limits.h"

namespace ctn::plan {

struct TriggerLine {
  double at_once = 0.0;  // in no time at all
  double rate = 0.0;     // and so many more a ms

  double within(double ms) const { return at_once + rate * ms; }
};

// Of all such loads, in ms of what is loaded.
inline TriggerLine line_of(const std::vector<model::UnscheduledLoad>& loads) {
  TriggerLine line;
  for (const model::UnscheduledLoad& load : loads) {
    line.at_once += std::max(1.0 + load.sooner / load.apart - load.over, 0.0) * load.run.count();
    line.rate += load.run / load.apart;
  }
  return line;
}

// What is known of the triggers of one.
struct TriggersKnown {
  double spacing = 0.0;    // between two of them, on average
  double sooner = 0.0;     // some come so much closer together than that
  double carried = 0.0;    // and by so much more what their runs do, which runs before them may have left undone
  Nanos held{0};           // a follower's period (holds_of_follower()); 0: it is none
  double held_back = 0.0;  // of one with a pause: no two are closer together; 0: they may be
};

// Of the bounds that hold the one that says least of so long a time.
inline TriggerLine trigger_line(const TriggersKnown& known, double ms) {
  TriggerLine least{1.0 + (known.sooner + known.carried) / known.spacing, 1.0 / known.spacing};
  const auto take = [&](int at_once, double apart) {
    const TriggerLine line{at_once + known.carried / apart, 1.0 / apart};
    if (line.within(ms) < least.within(ms)) least = line;
  };
  if (known.held_back > 0.0) take(1, known.held_back);
  if (known.held == Nanos{0}) return least;
  for (const Hold& hold : holds_of_follower(known.held)) {
    if (hold.apart >= graph::kShortestPeriod) take(hold.at_once, to_millis(hold.apart).count());
  }
  return least;
}

}  // namespace ctn::plan
