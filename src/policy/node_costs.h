// What one node's runs cost, as measured: an estimate for each kind of core that it ran on and each number of threads
// that its runs were to work on, with a watch over each of its modes that tells when the compute time has changed
// permanently.
//
// Which kind a run was on is told by the CPU that it ended on (record::Run::on_cpu), not by the plan in force: a
// subchain moves some time after the plan does, and threads may be moved by others than Catan.
//
// A kind that the node has not run on costs what the kind of its newest run does, times the ratio of the kinds' speeds.
//
// Threads. What a run takes on one thread is the CPU time of runs on one. That of runs on several is more, by what it
// takes to share the work, and stands for it only as long as there are no others. What a run takes on several is the
// elapsed time of runs on as many, once a few are known; on a number that it has not run on, what perfect scaling
// says; on another kind of core, so much of the time on one thread as where it was measured.
//
// A lasting change is told by CPU time, however many threads share it: what is elapsed also depends on what else wants
// the cores. What is known of other kinds and other numbers of threads is then scaled by as much: it is the work that
// has changed, as a rule, and neither the core nor how well the work is shared.
//
// Batches. What a run of a queue node costs may depend on how many items it found to take, and thus on the plan. What
// each item adds is estimated (model/batch_estimator.h), for each kind of core and number of threads by itself; all
// else is then of runs without any item, lasting changes too: batches that get larger, since the node runs less often,
// are none. Until it is known what an item adds, an alarm that goes with larger or smaller batches tells it. Where
// batches hardly differ it cannot be known, and costs are those of runs with such batches. Items are taken to share
// threads perfectly.
//
// What runs wait is taken to be the same on all kinds and any number of threads: that of those like the newest run.
//
// Units: as the estimator's. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "graph/app.h"
#include "model/batch_estimator.h"
#include "model/change_detector.h"
#include "model/cost.h"
#include "model/estimator.h"
#include "record/events.h"

namespace ctn::policy {

// Which runs count: those in the window that the app file says, of which those from before a lasting change are
// forgotten; or all, whatever changed.
enum class RunsThatCount { kRecent, kAll };

class NodeCosts {
 public:
  // `app` outlives it.
  NodeCosts(const graph::App& app, NodeId node, RunsThatCount count = RunsThatCount::kRecent);

  // A run on a core of that kind, with so many items (batch_sizes.h). Where it shows that the compute time has changed
  // permanently: from what to what. Precondition: kind < app.kinds().
  std::optional<record::CostChange> add(const record::Run& run, std::size_t items, std::size_t kind);

  // As if it had not run.
  void forget() { kinds_.assign(kinds_.size(), OnKind()); }

  bool measured() const { return count() > 0; }
  // Runs that are known, on the kind of core where it ran last.
  std::size_t count() const;
  // Puts what is known at that percentile into the table; nothing where the node has not run.
  void put_into(model::CostTable& table, double percentile) const;

  // Recent runs by kind of core, as often each as runs like it occur: what they take on one thread, without items.
  std::vector<std::vector<model::RunTime>> runs() const;

  // Runs on cores of that kind will take `factor` times as long as those seen.
  void rescale(std::size_t kind, double factor);
  // What runs on cores of that kind take now is not known: what was seen serves until there are a few more runs.
  void invalidate(std::size_t kind);

 private:
  // Of runs on one kind of core and one number of threads.
  struct Seen {
    model::Estimator cpu;
    model::Estimator elapsed;                      // on several threads
    std::vector<model::ChangeDetector> detectors;  // of CPU time, by mode
    std::uint64_t runs = 0;
    model::BatchEstimator batches{};  // of a queue node
  };
  using OnKind = std::map<int, Seen>;  // by number of threads; those that it ran on

  Seen& like(std::size_t kind, int threads);  // runs on these
  static void take_per_item(Seen& seen, int threads);
  static void per_item_changed(Seen& seen, int threads, Millis before);
  std::optional<record::CostChange> changed(const record::Run& run, std::size_t kind, std::size_t mode,
                                            std::size_t runs);
  std::map<int, Millis> elapsed_on(std::size_t kind, Millis alone_here, double percentile) const;

  const graph::App& app_;
  NodeId node_;
  RunsThatCount counted_;
  bool takes_batches_;
  std::vector<OnKind> kinds_;
  std::size_t newest_kind_ = 0;
  int newest_threads_ = 1;
};

}  // namespace ctn::policy
