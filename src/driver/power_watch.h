// Detects that the machine's speed was changed: another clock limit or governor, or battery in place of mains. Tells by
// what factor that changes the compute times measured before. Pure.
//
// A clock limit that is half of what it was is taken to double compute times: an upper bound where a node waits for
// memory, which its next runs correct. Where one kind's CPUs changed by different ratios, or where the limits do not
// tell, the factor is unknown.
//
// Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "os/machine.h"
#include "policy/cpu_kinds.h"

namespace ctn::driver {

struct PowerChange {
  std::string what;  // for people
  // By kind of core: compute times are so many times as long; none: unknown.
  std::vector<std::optional<double>> factors;
};

class PowerWatch {
 public:
  PowerWatch(policy::CpuKinds kinds, std::size_t kind_count) : kinds_(std::move(kinds)), kind_count_(kind_count) {}

  // What has changed since the last look. What the system does not tell (a CPU that is offline) has not changed.
  std::optional<PowerChange> update(const os::PowerState& now);

 private:
  struct Compared;
  std::optional<double> factor_of(std::size_t kind, const std::vector<Compared>& cpus, bool mains_changed) const;

  policy::CpuKinds kinds_;
  std::size_t kind_count_;
  std::optional<bool> on_mains_;
  std::vector<os::PowerState::Cpu> cpus_;  // as last told
};

}  // namespace ctn::driver
