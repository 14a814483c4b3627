#include "trial/trial.h"

#include <algorithm>
#include <cassert>

#include "trial/machine.h"

namespace ctn::trial {

Overheads Overheads::none() {
  return {.timer_latency = Nanos{0},
          .timer_jitter = Nanos{0},
          .run = Nanos{0},
          .context_switch = Nanos{0},
          .dispatch_timer = Nanos{0},
          .dispatch_event = Nanos{0}};
}

// A step that a timer began takes more than one that an event did; how much of each there will be is not known.
Overheads Overheads::with_steps_of(Nanos mean) {
  Overheads overheads;
  if (mean <= Nanos{0}) return overheads;
  const Nanos usual = (overheads.dispatch_timer + overheads.dispatch_event) / 2;
  const Nanos own = std::max(mean - overheads.context_switch, Nanos{0});
  overheads.dispatch_timer = overheads.dispatch_timer * own.count() / usual.count();
  overheads.dispatch_event = overheads.dispatch_event * own.count() / usual.count();
  return overheads;
}

Figures Trial::run(const Schedule& schedule, const Options& options) const {
  assert(schedule.subchains.size() == app_.graph.subchains().size());
  assert(options.horizon > Nanos{0} && options.warm_up >= Nanos{0});
  return Machine(app_, samples_, prefixes_, schedule, options).run();
}

}  // namespace ctn::trial
