#include "dispatch/shared_core_member.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace ctn::dispatch {
namespace {

// Many additions of a share may fall short of a whole run by this much.
constexpr double kRounding = 1e-6;

}  // namespace

SharedCoreMember::SharedCoreMember(const SharedCoreSlot& slot) : slot_(slot) {
  assert(slot.slice >= Nanos{0} && slot.share > 0.0);
  assert(!slot.every || (*slot.every >= 1 && slot.phase >= 0 && slot.phase < *slot.every));
}

void SharedCoreMember::adopt(const RunState& state) {
  assert(!present_);
  present_ = true;
  state_ = state;
  // A queue node that never ran is due in the first frame, however small its share.
  if (is_queue() && state.sent == 0 && state.credit == 0.0) state_.credit = std::max(0.0, 1.0 - slot_.share);
}

void SharedCoreMember::change_slot(const SharedCoreSlot& slot) {
  assert(slot.subchain == slot_.subchain);
  slot_ = slot;
  state_.credit = std::min(state_.credit, max_credit());
}

bool SharedCoreMember::wants_trigger() const {
  return !deferred_ && (is_queue() ? state_.credit >= 1.0 - kRounding : state_.due);
}

int SharedCoreMember::planned_slots() const {
  if (slot_.every) return *slot_.every;
  return std::max(1, static_cast<int>(std::ceil(1.0 / slot_.share - kRounding)));
}

double SharedCoreMember::max_credit() const {
  return std::max(1.0, std::ceil(slot_.share)) + (slot_.share - std::floor(slot_.share));
}

void SharedCoreMember::begin_frame(std::uint64_t number, TimePoint start) {
  if (!present_) return;
  deferred_ = state_.sent > 0 && start < state_.triggered_at + slot_.min_period;
  if (is_queue()) {
    state_.credit = std::min(state_.credit + slot_.share, max_credit());
    return;
  }
  // Once begun, the rhythm is its own: it outlives swaps and moves, which may number frames and phases otherwise.
  const auto every = static_cast<std::uint64_t>(*slot_.every);
  const bool due = state_.frames_since_due ? ++*state_.frames_since_due >= *slot_.every
                                           : number % every == static_cast<std::uint64_t>(slot_.phase);
  if (!due) return;
  state_.frames_since_due = 0;
  state_.due = true;
}

void SharedCoreMember::begin_slot(TimePoint planned) {
  if (under_way()) ++state_.slots_used;
  if (wants_trigger() && !state_.due_at) state_.due_at = planned;
}

TimePoint SharedCoreMember::trigger(TimePoint now, bool at_slot_begin) {
  assert(wants_trigger() && !under_way());
  const TimePoint due_at = state_.due_at.value_or(now);
  ++state_.sent;
  state_.triggered_at = now;
  state_.slots_used = at_slot_begin ? 1 : 0;  // only whole slots count
  state_.due = false;
  state_.due_at.reset();
  if (is_queue()) {
    state_.credit -= 1.0;
    if (wants_trigger()) state_.due_at = now;
  }
  return due_at;
}

SharedCoreMember::HangChange SharedCoreMember::take_progress(TimePoint now, std::uint64_t completed) {
  if (!present_) return HangChange::kNone;
  state_.completed = std::clamp(completed, state_.completed, state_.sent);
  if (!under_way()) {
    const bool ended = state_.hanging;
    state_.hanging = false;
    return ended ? HangChange::kEnded : HangChange::kNone;
  }
  if (now < hang_at()) return HangChange::kNone;
  state_.hanging = true;
  return HangChange::kBegan;
}

TimePoint SharedCoreMember::hang_at() const {
  if (!present_ || !under_way() || state_.hanging || slot_.hang_after == Nanos{0}) return kNever;
  return std::max(state_.triggered_at, watched_since_) + slot_.hang_after;
}

}  // namespace ctn::dispatch
