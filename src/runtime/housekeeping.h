// The housekeeping loop: the one thread of a session at the ordinary level. Every 50 ms it collects what was reported
// (collector.h), updates which nodes are registered (registered_nodes.h), does a step of the planning loop
// (driver/planning_loop.h), and writes the record. Nothing on the hot path ever waits for it.
//
// Its thread has it alone (owning_thread.h). What other threads tell it goes through RegisteredNodes and Notices, and
// what they read is in Measurements.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "driver/planning_loop.h"
#include "flight/recorder.h"
#include "graph/app.h"
#include "os/os.h"
#include "runtime/allowed_cpus.h"
#include "runtime/asked_changes.h"
#include "runtime/clock_watch.h"
#include "runtime/collector.h"
#include "runtime/controller_threads.h"
#include "runtime/enforcer.h"
#include "runtime/incomplete_subchains.h"
#include "runtime/region.h"
#include "runtime/registered_nodes.h"
#include "runtime/unscheduled_watch.h"

namespace ctn::runtime {

class Housekeeping : private driver::PlanningHost {
 public:
  // `loop` has decided. Without a `writer` nothing is recorded, without a `recorder` (which outlives it) the last
  // seconds are not kept. References outlive it.
  Housekeeping(const graph::App& app, os::Os& os, const Region& region, Enforcer& enforcer, AllowedCpus& allowed,
               AskedChanges& asked, ControllerThreads& controllers, Reporting from, Measurements& measurements,
               driver::Notices& notices, std::unique_ptr<record::Writer> writer, flight::Recorder* recorder,
               driver::PlanningLoop loop);
  ~Housekeeping() override = default;
  Housekeeping(const Housekeeping&) = delete;
  Housekeeping& operator=(const Housekeeping&) = delete;

  // The first decision is in force: it is published and recorded.
  void begin(TimePoint start);
  // The subchains whose nodes have all registered are paced. To be called before controllers run.
  void pace_registered();
  // Goes on until `sleep_until` says that it is to end.
  void run(const std::function<bool(TimePoint)>& sleep_until);
  // Once all nodes have ended: collects the rest, closes the record. Errors: the first of the record.
  Status finish();

  const policy::Decision& decision() const { return loop_.decision(); }

 private:
  // --- driver::PlanningHost ---
  Result<os::CpuSet> usable_cpus() override { return allowed_.now(); }
  os::PowerState power_state() override { return os_.power_state(cpus_); }
  driver::ControllerWork controller_work() override { return controllers_.work(); }
  void raise(const driver::Levels& levels) override;
  void in_force(const policy::Decision& decision, policy::PlanReason reason) override;
  void cpus_changed(const os::CpuSet& cpus) override;
  void notice(const std::string& kind, const std::string& detail) override { log_.notice({os_.now(), kind, detail}); }

  void step(TimePoint& next_flush);
  void publish(const policy::Decision& decision);
  void carry_out_changes(TimePoint now);
  void keep_places(TimePoint now);
  void update_registered();
  bool prepare_restart(SubchainId subchain);
  void let_go_of_incomplete(TimePoint now);
  void tell_nodes(SubchainId subchain, bool incomplete);
  void wake_nodes(SubchainId subchain);

  const graph::App& app_;
  os::Os& os_;
  const Region& region_;
  Enforcer& enforcer_;
  AllowedCpus& allowed_;
  AskedChanges& asked_;
  ControllerThreads& controllers_;
  Links& links_;
  RegisteredNodes& registered_;
  Measurements& measurements_;
  flight::Recorder* const recorder_;
  const os::CpuSet cpus_;            // that were given
  AskedChanges::State carried_out_;  // what was asked, as the loop has it
  driver::PlanningLoop loop_;
  ClockWatch clocks_;
  EventLog log_;
  Collector collector_;
  UnscheduledWatch unscheduled_;
  IncompleteSubchains incomplete_;
  std::vector<bool> paced_;         // by subchain: all of its nodes are registered, and a controller is to hold it
  std::vector<os::CpuSet> places_;  // by subchain: where its threads are to be, as published last
  TimePoint published_{};
  bool moved_told_ = false;
};

}  // namespace ctn::runtime
