// What happens in a run of an application, as plain values: what the runtime (or the simulator) reports, the lineage
// follows (lineage.h) and the record stores (writer.h).
//
// Run numbers count from 1 for each node, without gaps. Units: in the types. Thread safety: plain values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/ids.h"
#include "base/ticks.h"
#include "base/time.h"
#include "dispatch/overrun.h"
#include "dispatch/slot_use.h"

namespace ctn::record {

// The runs of one predecessor that a run took as input: first..last, inclusive. A *latest* input takes one.
struct Consumed {
  NodeId predecessor;
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  friend bool operator==(const Consumed&, const Consumed&) = default;
};

// The age of an input from which nothing was ever taken.
constexpr Nanos kNoAge{-1};

struct Run {
  NodeId node;
  std::uint64_t number = 0;
  TimePoint begin{};
  TimePoint end{};
  Nanos cpu{0};                    // all of the node's threads added up
  std::uint32_t mode = 0;          // index into the node's modes
  bool emitted = true;             // false: it ran, but gave no output to its successors
  std::vector<Consumed> consumed;  // predecessors that had given nothing yet are left out
  int on_cpu = -1;                 // the CPU that it ended on; -1: not known
  std::vector<Nanos> ages{};       // of its inputs (ages.h), one a predecessor; empty: not known. Not in the record
  Nanos wait{0};                   // in which it neither ran nor was ready to run
  int threads = 1;                 // that it was to work on. Not in the record
  // Where these are several: from begin to end, less what it waited and while others had its core. Not in the record.
  Nanos elapsed{0};
  friend bool operator==(const Run&, const Run&) = default;
};

// A run that took another one as input.
struct Consumer {
  NodeId node;
  std::uint64_t run = 0;
  friend bool operator==(const Consumer&, const Consumer&) = default;
};

struct Trigger {
  SubchainId subchain;
  std::uint64_t number = 0;  // counts from 1 for each subchain
  TimePoint due{};           // when the plan wanted it
  TimePoint sent{};
};

using dispatch::Overrun;
using dispatch::SlotUse;
using dispatch::Steal;

// A plan came into force.
struct PlanChange {
  TimePoint at{};
  std::string reason;  // "bootstrap", "static", "measured", "periodic", "change", "power", "cpus", "asked"
  std::string json;
};

// A node's compute time has changed permanently.
struct CostChange {
  TimePoint at{};  // the end of the run that showed it
  NodeId node;
  std::uint32_t mode = 0;
  int core_kind = 0;       // index into the app's kinds of cores; 0 where it lists none
  Nanos before{0};         // the percentile that is planned with, of the runs before
  Nanos after{0};          // and of those since
  std::uint64_t runs = 0;  // since the change, as far as can be told
  friend bool operator==(const CostChange&, const CostChange&) = default;
};

// What was known of an external node's clock from then on.
struct ClockReading {
  TimePoint at{};
  NodeId node;
  Ticks ticks;
  friend bool operator==(const ClockReading&, const ClockReading&) = default;
};

// A weight or a bound of the app was changed while it ran.
struct AppChange {
  enum class What { kWeight, kMax, kMinRate };
  TimePoint at{};
  What what = What::kWeight;
  std::size_t item = 0;            // of kMinRate the node, else the term of the objective
  std::optional<double> before{};  // a weight, milliseconds, hertz; none: there was no bound
  std::optional<double> after{};
  friend bool operator==(const AppChange&, const AppChange&) = default;
};

// Anything a reader of the record must know: a level refused, reports lost, a watchdog that fired.
struct Notice {
  TimePoint at{};
  std::string kind;    // a stable word: "rates-only", "lost-reports", "watchdog", "replan-failed", "starved", ...
  std::string detail;  // for people
};

}  // namespace ctn::record
