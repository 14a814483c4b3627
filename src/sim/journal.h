// What happens in a simulation, told once to all who want it: what it comes to (outcome.h), what is planned with
// (policy/hung_runs.h), and the record, where one is written.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "base/result.h"
#include "graph/app.h"
#include "policy/hung_runs.h"
#include "record/writer.h"
#include "sim/outcome.h"

namespace ctn::sim {

class Journal {
 public:
  // `app` outlives it.
  Journal(const graph::App& app, TimePoint warm_from) : app_(app), gathering_(app, warm_from), hung_runs_(app.graph) {}

  // What comes from now on is recorded, too.
  void record_to(std::unique_ptr<record::Writer> writer) { writer_ = std::move(writer); }
  // Closes the record, if there is one. Errors: the writer's.
  Status close(TimePoint now, const record::Totals& totals, const os::HostFacts& host);

  // A run has ended; each after those it consumed. Whether it tells what its node costs: one that hung alone does not.
  bool ended(const record::Run& run);
  void triggered(const record::Trigger& trigger);
  void slot_over(const record::SlotUse& slot);
  void stole(const record::Steal& steal);
  void hang_changed(SubchainId subchain, bool began, TimePoint at);
  void plan_in_force(TimePoint at, const plan::Plan& plan, const char* reason);
  void cost_changed(const record::CostChange& change);

  const Gathering& gathering() const { return gathering_; }
  std::uint64_t hangs() const { return hangs_; }

 private:
  const graph::App& app_;
  Gathering gathering_;
  policy::HungRuns hung_runs_;
  std::uint64_t hangs_ = 0;
  std::unique_ptr<record::Writer> writer_;
};

}  // namespace ctn::sim
