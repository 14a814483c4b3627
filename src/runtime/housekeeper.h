// The session's one thread at the ordinary level: it gathers what nodes and controllers reported, keeps the
// measurements, writes the record, and plans anew. Nothing on the hot path ever waits for it.
//
// How it gathers: it drains the rings of successors before those of their predecessors, then hands the runs on in the
// other order. A node reports a run before its successors can consume it, so whatever a run consumed has been handed on
// before the run itself.
//
// Units: in the types. Thread safety: run() is the thread's body, and what its errand calls is that thread's; fill()
// and notice() from any thread that is not a node's or a dispatcher's (they lock).
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "catan/snapshot.h"
#include "graph/app.h"
#include "os/os.h"
#include "policy/hung_runs.h"
#include "policy/planning_budget.h"
#include "record/events.h"
#include "record/writer.h"
#include "runtime/controller.h"
#include "runtime/measurements.h"
#include "runtime/node_link.h"
#include "driver/power_watch.h"
#include "runtime/report_check.h"
#include "runtime/starvation.h"

namespace ctn::runtime {

class Housekeeper : private ReportSink {
 public:
  using Controllers = std::vector<std::unique_ptr<Controller>>;
  using Notify = std::function<void(const std::string&)>;

  // Values that were lost on their way between nodes, by edge name ("scan -> GL").
  using Dropped = std::function<std::vector<std::pair<std::string, std::uint64_t>>()>;

  // `writer` and `dropped` may be null. References outlive it.
  Housekeeper(const graph::App& app, os::Os& os, Links& links, Dropped dropped, TimePoint warm_from,
              std::unique_ptr<record::Writer> writer, Notify notify, policy::CpuKinds kinds = {});

  // What else is to be done every so often, after the runs are gathered: re-planning.
  using Errand = std::function<void(TimePoint now)>;

  // Until stop(). `controllers` are drained too.
  void run(const Controllers& controllers, const Errand& errand);
  void stop();
  // Makes it do its errand at once.
  void nudge();
  // After run() has returned and all nodes have ended: gathers the rest, closes the record.
  Status finish(const Controllers& controllers);

  // Kept for the snapshot and the record, and told to `notify` at once.
  void notice(const std::string& kind, const std::string& detail);
  // A plan came into force; the source is paced at `source_rate` under it.
  void plan_in_force(const plan::Plan& plan, Rate source_rate, const std::string& reason);

  // Another program runs the node from now on.
  void begins_anew(NodeId node);

  // The bootstrap is over.
  bool warmed_up() const;
  bool all_measured() const;
  model::CostTable costs(Millis unmeasured) const;  // as Measurements has them
  model::CostTable typical_costs(Millis unmeasured) const;
  // Whether a node's compute time has changed for good since the last call.
  bool take_cost_change();
  // The machine runs at another speed: tells it, and corrects what was measured before.
  void power_changed(const driver::PowerChange& change);
  // What planning has used so far.
  void planned(const policy::PlanningBudget& budget);
  // Fills all of the snapshot but policy and real_time.
  void fill(Snapshot& snapshot, std::optional<double> hand_set_hz) const;

 private:
  void triggered(const record::Trigger& trigger) override;
  void slot_over(const record::Slot& slot) override;
  void stole(const record::Steal& steal) override;
  void hang_changed(SubchainId subchain, bool began, TimePoint at) override;
  void woke_late(int cpu, TimePoint due, TimePoint woke) override;

  void gather(const Controllers& controllers);
  void note_losses(const Controllers& controllers);
  void note_floods(const Controllers& controllers);
  void judge_starvation();
  void write_notices();
  void flush();

  const graph::App& app_;
  os::Os& os_;
  Links& links_;
  Dropped dropped_;
  TimePoint warm_from_;
  std::unique_ptr<record::Writer> writer_;
  Notify notify_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint32_t> attention_{0};

  mutable std::mutex mutex_;  // guards what follows
  Measurements measurements_;
  ReportCheck check_;
  std::deque<record::Notice> notices_;  // the newest
  std::vector<record::Notice> unwritten_notices_;
  std::vector<record::PlanChange> unwritten_plans_;
  std::uint64_t plans_ = 0;
  record::Totals totals_;
  std::uint64_t cost_changes_ = 0;

  // Only this thread's.
  std::vector<std::vector<record::Run>> gathered_;  // by position in the topological order, reused
  bool cost_changed_ = false;
  Starvation starvation_;
  policy::HungRuns hung_runs_;
  std::uint64_t losses_noted_ = 0;
  std::uint64_t floods_noted_ = 0;
  bool record_failed_ = false;
};

}  // namespace ctn::runtime
