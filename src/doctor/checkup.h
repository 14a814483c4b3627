// What a machine is like for real-time scheduling: observed first (by trying and measuring, on any Os), then judged (on
// Linux, checks.h), one Finding a check.
//
// Units: Nanos. Thread safety: plain values; observe() from one thread, which it leaves as it was.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "os/os.h"

namespace ctn::doctor {

// kProblem alone hinders real-time scheduling; kWarning costs latency or CPU time; kNote is worth knowing.
enum class Verdict { kOk, kNote, kWarning, kProblem };
const char* to_string(Verdict verdict);

struct Finding {
  std::string check;  // a name that programs can rely on, as in docs/doctor.md
  Verdict verdict = Verdict::kOk;
  std::string found;
  std::string meaning;             // for Catan; empty where kOk
  std::string hint;                // what to do; empty where kOk
  std::vector<std::string> lines;  // to copy to where `hint` says
};

Verdict worst(const std::vector<Finding>& findings);

// How late a thread pinned to one CPU woke up from absolute sleeps, ascending; empty where it could not run there.
struct WakeUps {
  int cpu = 0;
  std::vector<Nanos> lateness;
  std::optional<Error> refused;

  // By nearest rank. Precondition: 0 < percent <= 100. Zero when there are none.
  Nanos percentile(double percent) const;
};

// Sleeps `count` times for `period` on each of the CPUs, on all at once, in threads of their own at `level`. Takes
// count * period.
std::vector<WakeUps> measure_wake_ups(os::Os& os, const os::CpuSet& cpus, os::Level level, int count, Nanos period);
// All CPUs' together, under the first one's number.
WakeUps together(const std::vector<WakeUps>& each);

// What cannot be read but has to be tried.
struct Observed {
  os::CpuSet cpus;  // the CPUs in question
  os::Topology topology;
  os::CpuSet allowed;  // the CPUs of the calling thread
  os::RealTimeFacts real_time;
  os::HostFacts host;                      // as of the beginning
  os::Level level = os::Level::kOrdinary;  // of `wake_ups`: real-time where that is permitted
  std::vector<WakeUps> wake_ups;           // one for each of `cpus`
  std::vector<WakeUps> ordinary;           // the same at the ordinary level
  std::optional<Error> not_ready;          // why idle CPUs cannot be kept ready
  bool keeps_ready = false;                // there is something to keep, and it can be
  Nanos measured{0};                       // how long the measuring took
  Nanos stolen{0};                         // CPU time a hypervisor took in that time, all CPUs
};

// Takes about 0.4 s. `cpus`: empty for all that the calling thread may use. Errors: kCaller for a CPU that the machine
// does not have, kEnvironment when it shows no CPUs at all.
Result<Observed> observe(os::Os& os, const os::CpuSet& cpus);

}  // namespace ctn::doctor
