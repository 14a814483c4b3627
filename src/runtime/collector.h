// Collects what nodes and controllers have reported, drops what cannot be true, and passes the rest on to the event log
// (driver/event_log.h).
//
// How it collects: it drains the rings of successors before the rings of their predecessors, then passes the runs on in
// the opposite order. A node reports a run before its successors can consume it, so whatever a run consumed has been
// passed on before the run itself.
//
// Units: in the types. Thread safety: none; the housekeeping thread's (housekeeping.h).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "graph/app.h"
#include "os/os.h"
#include "record/events.h"
#include "runtime/clock_watch.h"
#include "runtime/controller_thread.h"
#include "runtime/measurements.h"
#include "runtime/node_link.h"
#include "runtime/registered_nodes.h"
#include "runtime/report_check.h"
#include "runtime/starvation.h"

namespace ctn::runtime {

// What channels between nodes of this process tell (connections.h). May be empty.
struct ChannelNews {
  // Values that were lost on their way, by edge name ("scan -> GL").
  std::function<std::vector<std::pair<std::string, std::uint64_t>>()> dropped;
  // Uses by nodes that may not, since this was last asked.
  std::function<std::vector<record::Notice>(TimePoint now)> misuses;
};

// What is collected from. References outlive the collector.
struct Reporting {
  Links& links;
  const std::vector<std::unique_ptr<ControllerThread>>& controllers;
  RegisteredNodes& registered;
  ChannelNews channels;
};

class Collector : private ReportSink {
 public:
  // All references outlive it.
  Collector(const graph::App& app, os::Os& os, Reporting from, ClockWatch& clocks, Measurements& measurements,
            EventLog& log);

  // All that was reported since the last call.
  void collect();
  // Says what was lost, which channels were misused, how often controllers were flooded, and what the kernel took.
  // About once a second.
  void note_losses();
  void note_misuses();
  void note_ignored_wakes();
  void check_starvation();
  bool has_pending_starvation() const { return starvation_.has_pending(); }

 private:
  void triggered(const record::Trigger& trigger) override { log_.triggered(trigger); }
  void slot_over(const record::SlotUse& slot) override { log_.slot_over(slot); }
  void stole(const record::Steal& steal) override { log_.stole(steal); }
  void hang_changed(SubchainId subchain, bool began, TimePoint at) override { log_.hang_changed(subchain, began, at); }
  void over_budget(const record::Overrun& overrun) override { log_.over_budget(overrun); }
  void woke_late(int cpu, TimePoint due, TimePoint woke) override { starvation_.woke_late(cpu, due, woke); }

  const graph::App& app_;
  os::Os& os_;
  Reporting from_;
  ClockWatch& clocks_;
  Measurements& measurements_;
  EventLog& log_;
  ReportCheck check_;
  std::vector<std::vector<record::Run>> collected_;  // by position in the topological order, reused
  Starvation starvation_;
  std::uint64_t losses_noted_ = 0;
  std::uint64_t ignored_wakes_noted_ = 0;
};

}  // namespace ctn::runtime
