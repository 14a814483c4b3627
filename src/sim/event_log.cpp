#include "sim/event_log.h"

#include <utility>

#include "plan/json.h"

namespace ctn::sim {

Status EventLog::close(TimePoint now, const record::Totals& totals, const os::HostFacts& host) {
  if (!writer_) return Done{};
  writer_->set_totals(totals);
  Status closed = writer_->close(now, host);
  writer_.reset();
  return closed;
}

void EventLog::ended(const record::Run& run) {
  collector_.add(run);
  if (writer_) {
    writer_->add(run);
    for (const record::Notice& told : stale_.ran(run)) writer_->add(told);
  }
  if (!loop_.adapts()) return;
  const std::optional<record::CostChange> change = loop_.ran(run);
  if (change && writer_) writer_->add(*change);
}

void EventLog::triggered(const record::Trigger& trigger) {
  collector_.triggered(trigger.sent);
  if (writer_) writer_->add(trigger);
}

void EventLog::slot_over(const record::SlotUse& slot) {
  if (writer_) writer_->add(slot);
}

void EventLog::stole(const record::Steal& steal) {
  collector_.stole(steal.begin);
  if (writer_) writer_->add(steal);
}

void EventLog::hang_changed(SubchainId subchain, bool began, TimePoint at) {
  if (began) {
    ++hangs_;
    loop_.hang_began(subchain, at);
  }
  if (writer_) writer_->add(policy::notice_of_hang(app_.graph.subchain(subchain).name, began, at));
}

void EventLog::over_budget(const record::Overrun& overrun) {
  collector_.over_budget(overrun.at);
  if (writer_) writer_->add(overrun);
}

void EventLog::clock_read(const record::ClockReading& reading) {
  collector_.clock_read(reading);
  if (writer_) writer_->add(reading);
}

void EventLog::plan_in_force(TimePoint at, const plan::Plan& plan, const char* reason) {
  collector_.plan_in_force(at, plan);
  if (writer_) writer_->add(record::PlanChange{at, reason, plan::to_json(plan, app_)});
}

void EventLog::notice(const record::Notice& notice) {
  notices_.push_back(notice.kind + ": " + notice.detail);
  if (writer_) writer_->add(notice);
}

}  // namespace ctn::sim
