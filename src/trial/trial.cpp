#include "trial/trial.h"

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

Figures Trial::run(const Schedule& schedule, const Options& options) const {
  assert(schedule.subchains.size() == app_.graph.subchains().size());
  assert(options.horizon > Nanos{0} && options.warm_up >= Nanos{0});
  return Machine(app_, samples_, prefixes_, schedule, options).run();
}

}  // namespace ctn::trial
