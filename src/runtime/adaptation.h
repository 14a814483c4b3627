// When a session plans anew: what has changed is gathered here (compute times from the
// housekeeper, power and clock limits from the system), and turned into a reason to plan.
//
// Units: in the types. Thread safety: none; the housekeeper's thread.
#pragma once

#include <optional>

#include "graph/app.h"
#include "os/os.h"
#include "policy/replan.h"
#include "runtime/housekeeper.h"
#include "driver/power_watch.h"

namespace ctn::runtime {

class Adaptation {
 public:
  // References outlive it. `cpus`: the session's.
  Adaptation(const graph::App& app, os::Os& os, const os::CpuSet& cpus, const policy::CpuKinds& kinds, TimePoint start);

  // Why a plan is due now, if one is. Looks at what has changed.
  std::optional<policy::PlanReason> due(TimePoint now, Housekeeper& housekeeper);
  // Calls make() and notes what CPU time the calling thread took for it.
  template <class Make>
  void plan(TimePoint now, policy::PlanReason why, Housekeeper& housekeeper, Make&& make) {
    const Nanos before = os_.thread_cpu_time();
    make();
    clock_.made(now, why, os_.thread_cpu_time() - before);
    housekeeper.planned(clock_.budget());
  }

 private:
  void look_at_power(TimePoint now, Housekeeper& housekeeper);

  os::Os& os_;
  os::CpuSet cpus_;
  policy::ReplanClock clock_;
  driver::PowerWatch power_;
  TimePoint next_look_{};
};

}  // namespace ctn::runtime
