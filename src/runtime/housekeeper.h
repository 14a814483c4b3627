// The session's one thread at the ordinary level: it gathers what nodes and controllers reported, keeps the
// measurements, writes the record, and plans anew. Nothing on the hot path ever waits for it.
//
// How it gathers: it drains the rings of successors before those of their predecessors, then hands the runs on in the
// other order. A node reports a run before its successors can consume it, so whatever a run consumed has been handed on
// before the run itself.
//
// Units: in the types. Thread safety: run() is the thread's body; snapshot() and notice() from any thread that is not a
// node's or a dispatcher's (they lock).
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "catan/snapshot.h"
#include "graph/app.h"
#include "os/os.h"
#include "record/events.h"
#include "record/writer.h"
#include "runtime/controller.h"
#include "runtime/measurements.h"
#include "runtime/wiring.h"

namespace ctn::runtime {

class Housekeeper : private ReportSink {
 public:
  using Controllers = std::vector<std::unique_ptr<Controller>>;
  using Notify = std::function<void(const std::string&)>;

  // `writer` may be null. References outlive it.
  Housekeeper(const graph::App& app, os::Os& os, Wiring& wiring, TimePoint warm_from,
              std::unique_ptr<record::Writer> writer, Notify notify);

  // What else is to be done every so often, after the runs are gathered: re-planning.
  using Errand = std::function<void(TimePoint now)>;

  // Until stop(). `controllers` are drained too.
  void run(const Controllers& controllers, const Errand& errand);
  void stop();
  // After run() has returned and all nodes have ended: gathers the rest, closes the record.
  Status finish(const Controllers& controllers);

  // Kept for the snapshot and the record, and told to `notify` at once.
  void notice(const std::string& kind, const std::string& detail);
  // A plan came into force; the source is paced at `source_rate` under it.
  void plan_in_force(const plan::Plan& plan, Rate source_rate, const std::string& reason);

  bool all_measured() const;
  model::CostTable costs(Millis unmeasured) const;  // as Measurements has them
  model::CostTable typical_costs(Millis unmeasured) const;
  // Fills all of the snapshot but policy and real_time.
  void fill(Snapshot& snapshot, std::optional<double> hand_set_hz) const;

 private:
  void triggered(const record::Trigger& trigger) override;
  void slot_over(const record::Slot& slot) override;
  void stole(const record::Steal& steal) override;
  void hang_changed(SubchainId subchain, bool began) override;

  void gather(const Controllers& controllers);
  void note_losses(const Controllers& controllers);
  void write_notices();
  void flush();

  const graph::App& app_;
  os::Os& os_;
  Wiring& wiring_;
  std::unique_ptr<record::Writer> writer_;
  Notify notify_;
  std::atomic<std::uint32_t> stopping_{0};

  mutable std::mutex mutex_;  // guards what follows
  Measurements measurements_;
  std::vector<record::Notice> notices_;
  std::vector<record::PlanChange> plan_changes_;

  // Only this thread's.
  std::vector<std::vector<record::Run>> gathered_;  // by position in the topological order, reused
  std::size_t notices_written_ = 0;
  std::size_t plans_written_ = 0;
  std::uint64_t losses_noted_ = 0;
  bool record_failed_ = false;
};

}  // namespace ctn::runtime
