// What one node's runs cost, as measured: an estimate for each kind of core that it ran on, with a watch over each of
// its modes that tells when the compute time has changed permanently.
//
// Which kind a run was on is told by the CPU that it ended on (record::Run::on_cpu), not by the plan in force: a
// subchain moves some time after the plan does, and threads may be moved by others than Catan.
//
// A kind that the node has not run on costs what the kind of its newest run does, times the ratio of the kinds' speeds.
// When the compute time changes permanently on one kind, what is known of the others is scaled by as much: it is the
// work that has changed, as a rule, and not the core.
//
// What runs wait is taken to be the same on all kinds: that of the kind of the newest run.
//
// Units: as the estimator's. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "graph/app.h"
#include "model/change_detector.h"
#include "model/cost.h"
#include "model/estimator.h"
#include "record/events.h"

namespace ctn::policy {

class NodeCosts {
 public:
  // `app` outlives it.
  NodeCosts(const graph::App& app, NodeId node);

  // A run on a core of that kind. Where it shows that the compute time has changed permanently: from what to what.
  // Precondition: kind < app.kinds().
  std::optional<record::CostChange> add(const record::Run& run, std::size_t kind);

  bool measured() const { return count() > 0; }
  // Runs that are known, on the kind of core where it ran last.
  std::size_t count() const { return kinds_[newest_kind_].estimator.count(); }
  // Puts what is known at that percentile into the table; nothing where the node has not run.
  void put_into(model::CostTable& table, double percentile) const;

  // Recent runs by kind of core, as often each as runs like it occur.
  std::vector<std::vector<model::RunTime>> runs() const;

  // Runs on cores of that kind will take `factor` times as long as those seen.
  void rescale(std::size_t kind, double factor);
  // Nobody knows what runs on cores of that kind take now: what was seen serves until there are a few more runs.
  void invalidate(std::size_t kind);

 private:
  struct OnKind {
    model::Estimator estimator;
    std::vector<model::ChangeDetector> detectors;  // by mode
  };

  OnKind nothing_seen() const;
  std::optional<record::CostChange> changed(const record::Run& run, std::size_t kind, std::size_t mode,
                                            std::size_t runs);

  const graph::App& app_;
  NodeId node_;
  std::vector<OnKind> kinds_;
  std::size_t newest_kind_ = 0;
};

}  // namespace ctn::policy
