// Which of the app's kinds of cores each of a session's CPUs is of. Core k of a plan is the k-th of the CPUs, so an app
// that lists its cores says of each CPU what it is: `big: { count: 2 }, little: { count: 4 }` on CPUs 0-5 makes 0 and 1
// big. Pure.
//
// Thread safety: plain values.
#pragma once

#include <cstddef>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "os/cpu_set.h"

namespace ctn::policy {

class CpuKinds {
 public:
  // All CPUs are alike.
  CpuKinds() = default;
  // Precondition: fits(app, cpus).
  CpuKinds(const graph::App& app, const os::CpuSet& cpus);

  // Whether there are as many CPUs as the app lists cores. kCaller.
  static Status fits(const graph::App& app, const os::CpuSet& cpus);

  // 0 for a CPU that is none of them.
  std::size_t of(int cpu) const;
  // Of the CPUs `online`, those of that kind.
  os::CpuSet of_kind(std::size_t kind, const os::CpuSet& online) const;
  // The app as it is where only the CPUs `online` are left: core k is the k-th of these.
  graph::App only_with(const graph::App& app, const os::CpuSet& online) const;

 private:
  std::vector<std::size_t> kinds_;  // by CPU number; empty: all are alike
};

}  // namespace ctn::policy
