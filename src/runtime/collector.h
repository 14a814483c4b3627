// Collects what nodes and controllers have reported. Each run is passed on to the record, to the measurements that
// snapshots show, and to the planning loop.
//
// How it collects: it drains the rings of successors before those of their predecessors, then passes the runs on in the
// opposite order. A node reports a run before its successors can consume it, so whatever a run consumed has been passed
// on before the run itself.
//
// Units: in the types. Thread safety: none; the housekeeping thread's (housekeeping.h).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "driver/planning_loop.h"
#include "graph/app.h"
#include "os/os.h"
#include "policy/stale_inputs.h"
#include "record/events.h"
#include "record/writer.h"
#include "runtime/clock_watch.h"
#include "runtime/controller.h"
#include "runtime/measurements.h"
#include "runtime/node_link.h"
#include "runtime/notices.h"
#include "runtime/registered_nodes.h"
#include "runtime/report_check.h"
#include "runtime/starvation.h"

namespace ctn::runtime {

// Values that were lost on their way between nodes, by edge name ("scan -> GL").
using Dropped = std::function<std::vector<std::pair<std::string, std::uint64_t>>()>;

// Where what happened goes. References outlive the collector.
struct Collecting {
  Links& links;
  const std::vector<std::unique_ptr<Controller>>& controllers;
  RegisteredNodes& registered;
  Measurements& measurements;
  Notices& notices;
  Dropped dropped;                         // may be empty
  std::unique_ptr<record::Writer> writer;  // null: nothing is recorded
};

class Collector : private ReportSink {
 public:
  // All references outlive it.
  Collector(const graph::App& app, os::Os& os, Collecting from, ClockWatch& clocks, driver::PlanningLoop& loop);

  // All that was reported since the last call.
  void collect();
  // What is known of a clock of others from now on.
  void clock_read(const record::ClockReading& reading);
  // A plan came into force.
  void plan_in_force(const plan::Plan& plan, policy::PlanReason reason);

  // A weight or a bound was changed.
  void app_changed(const record::AppChange& change);

  // Says what was lost, how often dispatchers were flooded, and what the kernel took. About once a second.
  void note_losses();
  void note_ignored_wakes();
  void check_starvation();
  bool has_pending_starvation() const { return starvation_.has_pending(); }

  // Writes what was recorded. About once a second.
  void flush();
  // Closes the record. Errors: the writer's.
  Status close();

 private:
  void triggered(const record::Trigger& trigger) override;
  void slot_over(const record::SlotUse& slot) override;
  void stole(const record::Steal& steal) override;
  void hang_changed(SubchainId subchain, bool began, TimePoint at) override;
  void over_budget(const record::Overrun& overrun) override;
  void woke_late(int cpu, TimePoint due, TimePoint woke) override;

  void pass_on(std::vector<record::Run>& runs, TimePoint now);
  void write_notices();

  const graph::App& app_;
  os::Os& os_;
  Collecting from_;
  ClockWatch& clocks_;
  driver::PlanningLoop& loop_;
  ReportCheck check_;
  std::vector<std::vector<record::Run>> collected_;  // by position in the topological order, reused
  Starvation starvation_;
  policy::StaleInputs stale_;
  std::uint64_t losses_noted_ = 0;
  std::uint64_t ignored_wakes_noted_ = 0;
  bool record_failed_ = false;
};

}  // namespace ctn::runtime
