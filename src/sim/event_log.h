// What happens in a simulation is reported here once, and passed on to the outcome (outcome.h), to the planning loop
// (driver/planning_loop.h), and to the record, where one is written.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "driver/planning_loop.h"
#include "graph/app.h"
#include "policy/stale_inputs.h"
#include "record/writer.h"
#include "sim/outcome.h"

namespace ctn::sim {

class EventLog {
 public:
  // Both outlive it.
  EventLog(const graph::App& app, TimePoint warm_from, driver::PlanningLoop& loop)
      : app_(app), collector_(app, warm_from), loop_(loop), stale_(app.graph) {}

  // What comes from now on is recorded, too.
  void record_to(std::unique_ptr<record::Writer> writer) { writer_ = std::move(writer); }
  // Closes the record, if there is one. Errors: the writer's.
  Status close(TimePoint now, const record::Totals& totals, const os::HostFacts& host);

  // A run has ended; each after those it consumed.
  void ended(const record::Run& run);
  void triggered(const record::Trigger& trigger);
  void slot_over(const record::SlotUse& slot);
  void stole(const record::Steal& steal);
  void hang_changed(SubchainId subchain, bool began, TimePoint at);
  void over_budget(const record::Overrun& overrun);
  void clock_read(const record::ClockReading& reading);
  void plan_in_force(TimePoint at, const plan::Plan& plan, const char* reason);
  void notice(const record::Notice& notice);

  const OutcomeCollector& collector() const { return collector_; }
  std::uint64_t hangs() const { return hangs_; }
  // But for those of hangs and of old data, which are counted.
  const std::vector<std::string>& notices() const { return notices_; }

 private:
  const graph::App& app_;
  OutcomeCollector collector_;
  driver::PlanningLoop& loop_;
  policy::StaleInputs stale_;
  std::uint64_t hangs_ = 0;
  std::vector<std::string> notices_;
  std::unique_ptr<record::Writer> writer_;
};

}  // namespace ctn::sim
