// Which CPUs are online, for one who asks several times a second: the kernel's list stays open, and is parsed only
// where it has changed. To open it each time took most of what asking cost.
//
// Thread safety: each call from any thread (it locks).
#pragma once

#include <mutex>
#include <string>

#include "os/cpu_set.h"
#include "os/linux/descriptor.h"
#include "os/linux/files.h"

namespace ctn::os {

class OnlineCpus {
 public:
  explicit OnlineCpus(const LinuxRoots& roots) : roots_(roots) {}

  // As read_online_cpus() (topology.h), also where the list is too long for one read, or cannot be read.
  Result<CpuSet> now();

 private:
  const LinuxRoots& roots_;
  std::mutex mutex_;  // guards what follows
  Descriptor list_;   // from the first time on
  std::string text_;  // that was parsed last
  CpuSet cpus_;       // which it gave
};

}  // namespace ctn::os
