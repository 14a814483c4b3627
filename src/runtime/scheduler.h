// Schedules an app's nodes, wherever their threads are: it makes plans, paces subchains, gives threads their levels and
// cores, gathers what they report, and takes everything back. It speaks with nodes through a region (region.h) alone,
// so it is the same for nodes of its own process (engine.h) and for those of others (server.h).
//
// Threads of a scheduler:
//   one a subchain             its trigger thread, level dispatcher
//   one a core                 the core's dispatcher, level dispatcher (policies that follow a plan)
//   one housekeeper            level ordinary, wherever the system puts it
// Threads of nodes, which are others' to make, it places:
//   of a scheduled node        on its subchain's cores, active or, where they are shared, as their dispatcher says
//                              (policies that follow a plan); ordinary, on all CPUs (hand-set rates)
//   of an unscheduled node     level unscheduled
//
// Members: a node joins with its first thread and may leave again, at any time. A subchain that misses one of its nodes
// is left out and nobody waits for it; the plan still has its place, so that the others' rates stay what they are. When
// the node is back, what was under way in the subchain when it left counts as ended.
//
// Units: in the types. Thread safety: prepare, start, stop from one thread; the rest from any that is not a node's or a
// dispatcher's.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "catan/snapshot.h"
#include "graph/app.h"
#include "model/cost.h"
#include "os/os.h"
#include "plan/plan.h"
#include "policy/cpu_kinds.h"
#include "policy/policy.h"
#include "policy/replan.h"
#include "runtime/adaptation.h"
#include "runtime/assignment_board.h"
#include "runtime/controller.h"
#include "runtime/enforcer.h"
#include "runtime/housekeeper.h"
#include "runtime/node_link.h"
#include "runtime/region.h"

namespace ctn::runtime {

struct SchedulerOptions {
  std::shared_ptr<const policy::Policy> policy;  // needs no costs: none are known at first
  os::CpuSet cpus;                               // empty: all that this thread may use
  std::string record;                            // path; empty: none
  std::string note;
  bool stealing = true;                      // false: nobody steals, whatever the app says
  bool replan = true;                        // false: the first plan that rests on measurements stays
  std::optional<graph::FrameMode> frames{};  // in place of the app's
  bool guard = false;                        // nodes are other processes': their threads are guarded (os.h)
  std::function<void(const std::string&)> on_notice;
};

// All problems with the requested CPUs, or the CPUs to use.
Result<os::CpuSet> choose_cpus(os::Os& os, const os::CpuSet& asked);

class Scheduler {
 public:
  // `region` was laid out for the app and as many cores as there are `cpus`, which are not empty. References outlive
  // it.
  static Result<std::unique_ptr<Scheduler>> create(const graph::App& app, os::Os& os, SchedulerOptions options,
                                                   os::CpuSet cpus, const Region& region);
  ~Scheduler();
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  const graph::App& app() const { return app_; }

  // Values that were lost on their way between nodes, by edge: for the losses that are told. Before start().
  using Dropped = Housekeeper::Dropped;
  void watch_dropped(Dropped dropped) { dropped_ = std::move(dropped); }

  // Makes the first plan, opens the record. Errors: a plan that cannot be made or read, rates that are not set, a
  // record that cannot be made.
  Status prepare();
  // Everybody who has joined is placed and paced. Errors: CPUs that cannot be had.
  Status start();
  // Everything is given back; nodes may still be running. Then they are to end, and finish() is called.
  void release();
  // Gathers what was reported last, closes the record. The first error of the record.
  Status finish();

  // `thread` of `process` is the node's own. Errors: an external node, one that is there already, threads or CPUs that
  // cannot be had.
  Status join(NodeId node, os::ProcessId process, os::ThreadId thread);
  // Another thread that works for the node. Errors: no room.
  Status add_thread(NodeId node, os::ProcessId process, os::ThreadId thread);
  // A thread that has ended, or works for it no more; it gets back what it had.
  void remove_thread(NodeId node, os::ThreadId thread);
  // With all its threads. `why`: for the notice, as in "its process has ended". Nothing if it is not there.
  void leave(NodeId node, const std::string& why);
  bool has(NodeId node) const;
  std::vector<os::ThreadId> threads(NodeId node) const { return links_[node.index()]->threads(); }

  // Makes sure that there is still a guard; to be called about every second.
  void tend_guard();
  void notice(const std::string& kind, const std::string& detail) { housekeeper_->notice(kind, detail); }
  // Cheap, unlike snapshot(), which sorts all that was measured.
  bool warmed_up() const { return housekeeper_ && housekeeper_->warmed_up(); }
  Snapshot snapshot() const;

 private:
  Scheduler(const graph::App& app, os::Os& os, SchedulerOptions options, os::CpuSet cpus, const Region& region);

  // scheduler_setup.cpp
  void keep_cpus_ready();
  Status open_record(TimePoint start, TimePoint warm_from, std::unique_ptr<record::Writer>& writer);
  Status decide_first();
  void spawn_controllers();
  Status place_controllers();
  os::CpuSet cpus_of_controller(std::size_t index) const;

  Assignment on_all_cores(Assignment assignment) const;
  Assignment assignment() const;
  void publish(Assignment assignment);
  Nanos period_of(SubchainId subchain) const;
  Rate source_rate() const;  // of the first subchain's head, as paced
  policy::Situation situation(const graph::App& app, const model::CostTable& costs,
                              const model::CostTable& typical) const;
  Result<policy::Decision> decide(const model::CostTable& costs);
  void complete(policy::Decision& decision, TimePoint begin) const;

  // The housekeeper's errands.
  void replan(TimePoint now);
  void follow_cpus(TimePoint now);
  void place_anew();
  void make_plan_anew(policy::PlanReason reason);
  void adopt(policy::Decision decision, policy::PlanReason reason);
  void settle_members();
  bool clear_for_return(SubchainId subchain);

  // Members.
  Status place(NodeId node, os::ProcessId process, os::ThreadId thread);
  void tell_holder(NodeId node);
  std::string broken_chains(NodeId node) const;
  bool complete(const graph::Subchain& subchain) const;

  graph::App app_;
  os::Os& os_;
  SchedulerOptions options_;
  os::CpuSet cpus_;         // that were given
  policy::CpuKinds kinds_;  // of these
  os::CpuSet there_;        // of these, the ones that are online: what is planned for
  TimePoint next_look_{};   // at which CPUs are online
  double slack_ = 0.0;
  const Region& region_;
  Links links_;
  Dropped dropped_;

  // From prepare() on.
  std::unique_ptr<Enforcer> enforcer_;
  std::unique_ptr<os::ReadyCpus> ready_cpus_;
  std::unique_ptr<Housekeeper> housekeeper_;
  policy::Decision decision_;  // in force, whoever is absent; the housekeeper's, once its thread runs
  std::optional<Adaptation> adaptation_;
  std::vector<policy::SubchainPlace> places_;  // by subchain; those in force, the housekeeper's as decision_ is
  bool replan_failed_ = false;
  int guards_replaced_ = 0;
  bool guard_missing_ = false;

  // From start() on.
  std::vector<SubchainLinks> subchains_;
  std::unique_ptr<Controls> controls_;
  std::vector<std::unique_ptr<Controller>> controllers_;  // subchains, then cores
  std::vector<os::ThreadId> controller_ids_;
  std::vector<std::unique_ptr<os::Thread>> threads_;
  std::unique_ptr<os::Thread> housekeeper_thread_;
  std::atomic<std::uint32_t> ready_{0};
  std::atomic<std::uint32_t> go_{0};
  std::atomic<bool> abandoned_{false};

  std::vector<bool> in_force_;  // by subchain: paced; the housekeeper's, once its thread runs
  mutable std::mutex mutex_;    // guards what follows
  std::vector<bool> members_;   // by node
  std::vector<bool> broken_;    // by subchain: a node of it has left since it was last settled
  bool released_ = false;
};

}  // namespace ctn::runtime
