// The machine: its CPUs, which of them are online, how fast they may run, and what it grants to real-time threads.
//
// Units: Nanos. Thread safety: any thread at any time. Cost: none of it is for the hot path; online_cpus(),
// power_state() and stolen_time() are cheap enough to be asked again and again, as they say.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "os/cpu_set.h"

namespace ctn::os {

struct Cpu {
  int number = 0;
  bool online = true;
  int core = 0;  // CPUs with equal core and package are hardware threads of one core
  int package = 0;
  std::optional<long> max_khz;  // where the kernel reports it
  std::optional<int> capacity;  // relative speed as the kernel sees it, 1024 for the fastest
};

struct Topology {
  std::vector<Cpu> cpus;  // ascending by number
  CpuSet online() const;
};

// What the machine grants to real-time threads, as found, not assumed.
struct RealTimeFacts {
  bool permitted = false;   // this process may raise a thread to kDispatcher; tried, not guessed
  std::string why_not;      // where not permitted: what was refused, and how to get it
  double reserved = 0.0;    // fraction of each CPU that the kernel keeps for ordinary threads
  std::string reserved_by;  // "fair server", "throttling", "fair server (assumed default)", "nothing"
};

// Facts for the record of a run; empty where unknown.
struct HostFacts {
  std::string utc;  // the wall clock when asked, ISO 8601 to the second; for readers only, nothing is computed from it
  std::string kernel;
  std::string cpu_model;
  std::string governor;
  std::string clock_source;
  int cpu_count = 0;
  Nanos steal{0};  // CPU time that a hypervisor took from this machine since boot, all CPUs
};

// What decides how fast CPUs run, as the kernel reports it; empty where it does not. For telling when it changes.
struct PowerState {
  struct Cpu {
    int number = 0;
    std::optional<long> limit_khz;  // the fastest that is allowed at present
    std::string governor;
    friend bool operator==(const Cpu&, const Cpu&) = default;
  };
  std::optional<bool> on_mains;  // false: on battery
  std::vector<Cpu> cpus;         // ascending by number
  friend bool operator==(const PowerState&, const PowerState&) = default;
};

// While it lives, idle CPUs stay ready for work. The kernel ends it with the process, however that ends.
class ReadyCpus {
 public:
  virtual ~ReadyCpus() = default;
};

class Machine {
 public:
  virtual ~Machine() = default;

  virtual Result<Topology> topology() = 0;
  // Cheap enough to be asked several times a second.
  virtual Result<CpuSet> online_cpus() = 0;
  virtual RealTimeFacts real_time_facts() = 0;
  virtual HostFacts host_facts() = 0;

  // Of these CPUs. Cheap enough to be asked once a second.
  virtual PowerState power_state(const CpuSet& cpus) = 0;
  // CPU time that a hypervisor took from each CPU since boot; those that are not told are left out. As cheap.
  virtual std::map<int, Nanos> stolen_time() = 0;

  // In a virtual machine, an idle CPU is given to others on the host, and comes back late and with cold caches: keeps
  // that from happening. Null where there is nothing to keep: on hardware of its own, idle CPUs save energy as the
  // system's settings say. kEnvironment where it is refused.
  virtual Result<std::unique_ptr<ReadyCpus>> keep_cpus_ready() = 0;
};

}  // namespace ctn::os
