// All that happens while an app runs is reported here once, in life and in the simulator, and passed on to the
// measurements (measurements.h), the planning loop (planning_loop.h), the notices that a user gets (notices.h), the
// record, where one is written, and the flight recorder.
//
// Units: in the types; it reads no clock. Thread safety: none; one owner, in life the housekeeping thread.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "base/result.h"
#include "driver/measurements.h"
#include "driver/notices.h"
#include "driver/planning_loop.h"
#include "graph/app.h"
#include "plan/json.h"
#include "policy/hung_runs.h"
#include "policy/policy.h"
#include "policy/stale_inputs.h"
#include "record/events.h"
#include "record/sink.h"
#include "record/writer.h"

namespace ctn::driver {

template <class Samples>
class EventLog {
 public:
  // All outlive it.
  EventLog(const graph::App& app, PlanningLoop& loop, Measurements<Samples>& measurements, Notices& notices)
      : app_(app), loop_(loop), measurements_(measurements), notices_(notices), stale_(app.graph) {}

  // What comes from now on is recorded, too. Null: nothing is.
  void record_to(std::unique_ptr<record::Writer> writer) { writer_ = std::move(writer); }
  // What comes from now on goes there, too; it outlives this. Null: nowhere.
  void keep_in(record::Sink* keeper) { keeper_ = keeper; }

  // A run has ended; each after those it consumed.
  void ran(const record::Run& run) {
    measurements_.ran(run);
    write(run);
    for (record::Notice& told : stale_.ran(run)) notice(std::move(told));
    const std::optional<record::CostChange> change = loop_.ran(run);
    if (!change) return;
    measurements_.cost_changed();
    write(*change);
  }
  void triggered(const record::Trigger& trigger) {
    measurements_.triggered(trigger.sent);
    write(trigger);
  }
  void slot_over(const record::SlotUse& slot) { write(slot); }
  void stole(const record::Steal& steal) {
    measurements_.stole(steal.begin);
    write(steal);
  }
  // To be told before the run that hangs has ended.
  void hang_changed(SubchainId subchain, bool began, TimePoint at) {
    if (began) {
      measurements_.hang_began();
      loop_.hang_began(subchain, at);
    }
    notice(policy::notice_of_hang(app_.graph.subchain(subchain).name, began, at));
  }
  void over_budget(const record::Overrun& overrun) {
    measurements_.over_budget();
    write(overrun);
  }
  // What is known of a clock of others from now on.
  void clock_read(const record::ClockReading& reading) {
    measurements_.clock_read(reading);
    loop_.clock_known(reading.node, reading.ticks);
    write(reading);
  }
  void in_force(TimePoint at, const policy::Decision& decision, policy::PlanReason reason) {
    if (!decision.plan) return measurements_.no_plan_in_force();
    measurements_.plan_in_force(at, *decision.plan);
    if (writer_ || keeper_ != nullptr) {
      write(record::PlanChange{at, policy::to_string(reason), plan::to_json(*decision.plan, app_)});
    }
  }
  // A weight or a bound was changed.
  void app_changed(const record::AppChange& change) { write(change); }
  void notice(record::Notice notice) {
    notices_.add(std::move(notice));
    write_notices();
  }

  // Writes what was recorded, and what others have added to the notices.
  void flush(TimePoint now) {
    write_notices();
    if (keeper_ != nullptr) keeper_->set_totals(measurements_.lock()->totals);
    if (!writer_) return;
    const Status flushed = writer_->flush();
    if (!flushed && !std::exchange(failed_, true)) notices_.add({now, "record-failed", flushed.error().message()});
  }
  // Closes the record, if there is one; what comes later is not in it. Errors: the writer's.
  Status close(TimePoint now, const os::HostFacts& host) {
    write_notices();
    if (!writer_) return Done{};
    writer_->set_totals(measurements_.lock()->totals);
    Status closed = writer_->close(now, host);
    writer_.reset();
    return closed;
  }

 private:
  template <class Event>
  void write(const Event& event) {
    if (writer_) writer_->add(event);
    if (keeper_ != nullptr) keeper_->add(event);
  }
  void write_notices() {
    for (const record::Notice& notice : notices_.take_unrecorded()) write(notice);
  }

  const graph::App& app_;
  PlanningLoop& loop_;
  Measurements<Samples>& measurements_;
  Notices& notices_;
  policy::StaleInputs stale_;
  std::unique_ptr<record::Writer> writer_;
  record::Sink* keeper_ = nullptr;
  bool failed_ = false;
};

}  // namespace ctn::driver
