// Schedules an app's nodes, wherever their threads are: it makes plans, paces subchains, sets levels and cores of
// threads, collects their reports, and restores everything at the end. It communicates with nodes through a region
// (region.h) alone, so it is the same for nodes of its own process (engine.h) and for nodes of others (server.h).
//
// What it is made of, and which thread owns what:
//   controller_threads.h   one thread a subchain, and one a core (policies that follow a plan), at level dispatcher
//   housekeeping.h         one thread, at level ordinary, which owns all that is planned and recorded
//   registered_nodes.h     which nodes are registered: any thread, locks
//   enforcer.h             the scheduling that threads had before: any thread, locks
//   notice_thread.h        one thread, at level ordinary, where there is an on_notice: calls it
//   measurements.h         from the housekeeping thread to any reader: lock
// This class puts them together, starts and stops them.
//
// It places the threads of nodes, which are made elsewhere:
//   of a scheduled node        on its subchain's cores, active or, where they are shared, as their controller says
//                              (policies that follow a plan); ordinary, on all CPUs (hand-set rates)
//   of an unscheduled node     level unscheduled
//
// Units: in the types. Thread safety: prepare, start, stop from one thread; the rest from any that is not a node's or a
// controller's.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "catan/snapshot.h"
#include "driver/notices.h"
#include "driver/planning_loop.h"
#include "flight/recorder.h"
#include "graph/app.h"
#include "os/os.h"
#include "policy/policy.h"
#include "record/writer.h"
#include "runtime/allowed_cpus.h"
#include "runtime/asked_changes.h"
#include "runtime/collector.h"
#include "runtime/controller_threads.h"
#include "runtime/enforcer.h"
#include "runtime/housekeeping.h"
#include "runtime/measurements.h"
#include "runtime/node_link.h"
#include "runtime/notice_thread.h"
#include "runtime/owning_thread.h"
#include "runtime/region.h"
#include "runtime/registered_nodes.h"

namespace ctn::runtime {

struct SchedulerOptions {
  std::shared_ptr<const policy::Policy> policy;  // needs no costs: none are known at first
  os::CpuSet cpus;                               // empty: all that this thread may use
  std::string record;                            // path; empty: none
  std::string note;
  bool stealing = true;                      // false: no subchain steals, whatever the app says
  bool replan = true;                        // false: the first plan that knows all nodes' costs stays
  std::optional<graph::FrameMode> frames{};  // in place of the app's
  std::size_t flight_bytes = flight::Recorder::kDefaultBytes;  // in which the last seconds are kept; 0: they are not
  bool guardian = false;                // nodes are other processes': a guardian restores their threads
  driver::Notices::Callback on_notice;  // see notice_thread.h
};

// All problems with the requested CPUs, or the CPUs to use.
Result<os::CpuSet> choose_cpus(os::Os& os, const os::CpuSet& asked);

class Scheduler {
 public:
  // `app` is as it runs by the policy (policy::as_run_by()). `region` was laid out for it and as many cores as there
  // are `cpus`, which are not empty. References outlive it.
  static Result<std::unique_ptr<Scheduler>> create(const graph::App& app, os::Os& os, SchedulerOptions options,
                                                   os::CpuSet cpus, const Region& region);
  ~Scheduler();
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  const graph::App& app() const { return app_; }

  // Before prepare().
  void watch_channels(ChannelNews channels) { channels_ = std::move(channels); }

  // Makes the first plan, opens the record. Errors: a plan that cannot be made or read, rates that are not set, a
  // record that cannot be made.
  Status prepare();
  // Places the threads of all nodes that have joined, and starts to trigger. Errors: CPUs that cannot be had.
  Status start();
  // Restores the scheduling of all threads; nodes may still be running. They are to end next, before finish() is
  // called.
  void end_scheduling();
  // Collects the last reports, closes the record, and returns when on_notice has been told all. Returns the first error
  // of the record.
  Status finish();

  // As registered_nodes.h has them; nodes join and leave from prepare() on.
  Status join(NodeId node, os::ProcessId process, os::ThreadId thread);
  Status add_thread(NodeId node, os::ProcessId process, os::ThreadId thread);
  void remove_thread(NodeId node, os::ThreadId thread);
  void leave(NodeId node, const std::string& why);
  // A thread of a program of the app that is no node's: CPUs that are taken from it from now on are not planned for,
  // until its program has gone (allowed_cpus.h).
  void watch_cpus_of(os::ThreadId thread) { parts_->allowed.watch(thread); }
  void forget_cpus_of(os::ThreadId thread) { parts_->allowed.forget(thread); }
  // Of a node that is not external.
  std::vector<os::ThreadId> threads(NodeId node) const { return links_[node.index()]->threads(); }

  // Other weights, bounds or CPUs from now on; a plan for them follows at once. Errors: it does not run; its policy
  // never plans again; what is wrong with the changes, all of it, and then nothing is changed. kCaller.
  Status change(const Changes& changes);

  // The memory in which the last seconds are kept, for readers (flight/recording.h), from prepare() on. Errors: none is
  // kept.
  Result<os::Descriptor> flight() const;
  // Saves what is kept as a new record; `why` is told in it. Errors: none is kept; as Recording::save() has them.
  Status save_flight(const std::string& path, const std::string& why) const;

  // Makes sure that the guardian still runs; to be called about every second.
  void check_guardian() { parts_->enforcer.check_guardian(); }
  void notice(const std::string& kind, const std::string& detail) { notices_.add({os_.now(), kind, detail}); }
  // Whether nodes have levels above ordinary. From prepare() on.
  bool real_time() const { return parts_->enforcer.real_time(); }
  // Cheap, unlike snapshot(), which sorts all that was measured.
  bool warmed_up() const { return prepared_.load(std::memory_order_acquire) && os_.now() >= parts_->warm_from; }
  Snapshot snapshot() const;
  // Whether the calling thread is the one that calls on_notice.
  bool delivers_notices() const { return notice_thread_.is_current(); }

 private:
  // From prepare() on; none of it changes but by itself. Each uses only parts before it.
  struct Parts {
    Parts(TimePoint warm, std::optional<double> hertz, bool real_time, std::unique_ptr<os::Guardian> guardian,
          std::unique_ptr<record::Writer> writer, std::unique_ptr<flight::Recorder> flight, driver::PlanningLoop loop,
          Scheduler& of);

    const TimePoint warm_from;
    const std::optional<double> hand_set_hz;           // rate of the first subchain's head, where no plan tells
    const std::unique_ptr<flight::Recorder> recorder;  // null: the last seconds are not kept
    Enforcer enforcer;
    AllowedCpus allowed;
    AskedChanges asked;
    Measurements measurements;
    ControllerThreads controllers;
    OwningThread<Housekeeping> housekeeping;
    std::unique_ptr<os::ReadyCpus> ready_cpus{};  // while the session is under way
  };

  Scheduler(const graph::App& app, os::Os& os, SchedulerOptions options, os::CpuSet cpus, const Region& region);

  driver::PlanningLoop planning_loop(double slack) const;
  void keep_cpus_ready();
  record::Header header(TimePoint start, TimePoint warm_from, bool real_time, const driver::PlanningLoop& loop) const;
  Result<std::unique_ptr<record::Writer>> open_record(const record::Header& header) const;
  std::unique_ptr<flight::Recorder> open_recorder(const record::Header& header);

  graph::App app_;
  os::Os& os_;
  const SchedulerOptions options_;
  const os::CpuSet cpus_;  // that were given
  const Region& region_;
  Links links_;
  ChannelNews channels_;
  NoticeThread notice_thread_;
  driver::Notices& notices_;
  RegisteredNodes registered_;
  std::unique_ptr<Parts> parts_;
  std::atomic<bool> scheduling_ended_{false};
  std::atomic<bool> prepared_{false};  // another thread that asks sees all of the parts, or none
};

}  // namespace ctn::runtime
