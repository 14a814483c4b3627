#include "trial/trial.h"

#include <algorithm>
#include <cassert>
#include <cmath>

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

Overheads Overheads::with_steps(double factor) {
  assert(factor > 0.0);
  Overheads overheads;
  const auto scaled = [&](Nanos own) {
    const auto all = static_cast<double>((own + overheads.context_switch).count());
    return std::max(Nanos{std::llround(factor * all)} - overheads.context_switch, Nanos{0});
  };
  overheads.dispatch_timer = scaled(overheads.dispatch_timer);
  overheads.dispatch_event = scaled(overheads.dispatch_event);
  return overheads;
}

Figures Trial::run(const Schedule& schedule, const Options& options) const {
  assert(schedule.subchains.size() == app_.graph.subchains().size());
  assert(options.horizon > Nanos{0} && options.warm_up >= Nanos{0});
  return Machine(app_, samples_, prefixes_, schedule, options).run();
}

}  // namespace ctn::trial
