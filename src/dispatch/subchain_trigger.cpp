#include "dispatch/subchain_trigger.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace ctn::dispatch {

Pacing pacing_of_owned(Millis period, Millis execution, Nanos hang_after) {
  const Millis paced = std::max(period, Millis{kShortestPeriod});
  // A run that is a hair longer than its period (rounding) does not need a second one at the same time.
  const double overlap = std::ceil(execution / paced - 1e-9);
  return {.period = to_nanos(paced), .max_in_flight = std::max(1, static_cast<int>(overlap)), .hang_after = hang_after};
}

Pacing elastic_pacing_of_owned(Millis period, Millis execution, Nanos hang_after, Nanos shortest) {
  Pacing pacing = pacing_of_owned(period, execution, hang_after);
  pacing.after_completion = std::max(pacing.period * pacing.max_in_flight - to_nanos(execution), Nanos{1});
  pacing.shortest = std::max(shortest, kShortestPeriod);
  return pacing;
}

SubchainTrigger::SubchainTrigger(TimePoint start, const Pacing& pacing, std::uint64_t sent, std::uint64_t completed)
    : pacing_(pacing), due_(start), last_due_(start), sent_(sent), completed_(completed), progress_at_(start) {
  assert(pacing.period > Nanos{0} && completed <= sent);
}

bool SubchainTrigger::may_overlap(std::uint64_t completed) const {
  if (pacing_.max_in_flight == 0) return true;
  return sent_ - completed < static_cast<std::uint64_t>(pacing_.max_in_flight);
}

void SubchainTrigger::watch(TimePoint now, std::uint64_t completed, Decision& decision) {
  if (completed > completed_) {
    completed_ = completed;
    progress_at_ = now;
    decision.hang_ended = hanging_;
    hanging_ = false;
  }
  const bool under_way = sent_ > completed_;
  if (!under_way) progress_at_ = now;
  if (pacing_.hang_after == Nanos{0} || !under_way || hanging_) return;
  if (now - progress_at_ >= pacing_.hang_after) {
    hanging_ = true;
    decision.hang_began = true;
  } else {
    decision.ask_at = std::min(decision.ask_at, progress_at_ + pacing_.hang_after);
  }
}

SubchainTrigger::Decision SubchainTrigger::step(TimePoint now, std::uint64_t completed) {
  assert(completed <= sent_);
  if (stood_still(asked_for_, now)) progress_at_ = now;
  Decision decision;
  decision.ask_at = kNever;
  completed = std::max(completed, completed_);
  const bool paced_by_output = pacing_.after_completion > Nanos{0};
  if (paced_by_output && completed > completed_) {
    due_ = std::max(now + pacing_.after_completion, last_due_ + pacing_.shortest);
  }

  if (now >= due_ && may_overlap(completed)) {
    decision.trigger = due_;
    if (sent_ == completed) progress_at_ = now;
    ++sent_;
    const bool off_grid = now - due_ >= pacing_.period;
    last_due_ = off_grid || paced_by_output ? now : due_;
    due_ = last_due_ + pacing_.period;
  }
  if (may_overlap(completed)) {
    decision.ask_at = std::max(due_, now);
  } else {
    decision.ask_on_completion = now >= due_;
    decision.ask_at = decision.ask_on_completion ? kNever : due_;
  }
  watch(now, completed, decision);
  if (paced_by_output) decision.ask_on_completion = true;
  // A run that hangs is watched for its end, to restore its level.
  if (hanging_) decision.ask_on_completion = true;
  asked_for_ = decision.ask_at;
  return decision;
}

void SubchainTrigger::change_pacing(TimePoint now, const Pacing& pacing) {
  assert(pacing.period > Nanos{0});
  pacing_ = pacing;
  due_ = sent_ == 0 ? due_ : std::max(last_due_ + pacing.period, now);
}

}  // namespace ctn::dispatch
