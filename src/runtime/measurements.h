// What a session has measured, for the snapshot: written by the housekeeping thread, read by any. What is planned with
// is not here (driver/planning_loop.h).
//
// Units: Nanos in, milliseconds out. Thread safety: each call locks. Memory: bounded, the newest `kSamples` of each
// metric.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "catan/snapshot.h"
#include "graph/app.h"
#include "os/cpu_set.h"
#include "plan/plan.h"
#include "plan/predicted_means.h"
#include "policy/planning_budget.h"
#include "record/events.h"
#include "record/run_metrics.h"
#include "record/writer.h"

namespace ctn::runtime {

// The newest samples of one metric.
class SampleWindow {
 public:
  static constexpr std::size_t kSamples = 16384;

  void add(Nanos sample);
  Summary summary_ms() const;  // count: all there ever were; the rest: of those kept

 private:
  std::vector<double> samples_;  // milliseconds
  std::size_t next_ = 0;
  std::uint64_t count_ = 0;
};

// What the plan in force says of its bounds and of what its nodes cost.
void show_plan(const graph::App& app, const plan::Plan& plan, Snapshot& snapshot);

class Measurements {
 public:
  // Samples that go back to a time before `warm_from` are left out. `app` outlives it.
  Measurements(const graph::App& app, TimePoint warm_from);

  // Runs have ended; each after those it consumed.
  void add(std::span<const record::Run> runs);
  // What is known of a clock of others from now on.
  void clock_read(const record::ClockReading& reading);
  // Predictions are averaged over the time they were in force, from `warm_from` on.
  void plan_in_force(TimePoint since, const plan::Plan& plan);
  // What is in force follows no plan.
  void no_plan_in_force();
  // So often compute times have changed permanently, so far.
  void cost_changes(std::uint64_t count);
  // These CPUs are planned for.
  void cpus_in_use(const os::CpuSet& cpus);
  // What re-planning has taken, so far.
  void planned(const policy::PlanningBudget& budget);
  // The kernel has kept CPUs from real-time threads so often, and so long, so far.
  void starved(std::uint64_t times, Nanos total);

  // A run was demoted.
  void over_budget();

  // Fills all but policy, real_time, changes, objective, min_rate_hz and notices, as of `now`. `hand_set_hz`: where no
  // plan tells.
  void fill(Snapshot& snapshot, TimePoint now, std::optional<double> hand_set_hz) const;
  // What the record ends with.
  record::Totals totals() const;

 private:
  const graph::App& app_;
  const TimePoint warm_from_;
  mutable std::mutex mutex_;  // guards what follows
  record::RunMetrics<SampleWindow> metrics_;
  plan::PredictedMeans predicted_;
  std::optional<plan::Plan> plan_;  // in force
  os::CpuSet cpus_;
  std::uint64_t plans_ = 0;
  std::uint64_t cost_changes_ = 0;
  std::uint64_t budget_overruns_ = 0;
  record::Totals totals_;
};

}  // namespace ctn::runtime
