#include "doctor/checks.h"

namespace ctn::doctor {

std::vector<Finding> judge(const os::LinuxRoots& roots, const Observed& observed) {
  return {
      check_permission(roots, observed),
      check_cgroup(roots, observed),
      check_time_limit(roots),
      check_slack(roots, observed),
      check_quota(roots),
      check_cpus(observed),
      check_capacity(observed),
      check_smt(roots, observed),
      check_isolated(roots, observed),
      check_governor(roots, observed),
      check_frequency_limit(roots, observed),
      check_boost(roots),
      check_idle(roots, observed),
      check_clock(roots),
      check_timer(observed),
      check_timer_slack(roots, observed),
      check_preemption(roots),
      check_steal(roots, observed),
  };
}

}  // namespace ctn::doctor
