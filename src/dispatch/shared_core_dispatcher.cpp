#include "dispatch/shared_core_dispatcher.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "dispatch/standstill.h"

namespace ctn::dispatch {
namespace {

bool holds(const SharedCoreSchedule& schedule, SubchainId subchain) {
  return std::any_of(schedule.slots.begin(), schedule.slots.end(),
                     [&](const SharedCoreSlot& slot) { return slot.subchain == subchain; });
}

}  // namespace

SharedCoreDispatcher::SharedCoreDispatcher(TimePoint start, SharedCoreSchedule schedule, int core)
    : core_(core), schedule_(std::move(schedule)), now_(start), frame_due_(start), frame_start_(start) {
  decision_.ask_at = kNever;
  slack_.set_slack(schedule_.slack);
  for (const SharedCoreSlot& slot : schedule_.slots) members_.emplace_back(slot);
}

const SharedCoreDispatcher::Decision& SharedCoreDispatcher::step(TimePoint now,
                                                                 std::span<const std::uint64_t> completed) {
  begin_decision(now);
  take_progress(completed);
  while (advance()) {
  }
  update_levels();
  plan_next_call();
  return decision_;
}

void SharedCoreDispatcher::change_schedule(SharedCoreSchedule schedule) { next_schedule_ = std::move(schedule); }

void SharedCoreDispatcher::adopt(SubchainId subchain, const RunState& state) {
  const auto member = std::find_if(members_.begin(), members_.end(),
                                   [&](const SharedCoreMember& each) { return each.slot().subchain == subchain; });
  if (member != members_.end()) {
    member->adopt(state);
  } else {
    waiting_.emplace_back(subchain, state);
  }
}

// --- What is known ---

Nanos SharedCoreDispatcher::frame_length() const {
  return std::max(fixed() ? schedule_.frame : schedule_.frame_min, kShortestFrame);
}

bool SharedCoreDispatcher::anyone_present() const {
  return std::any_of(members_.begin(), members_.end(), [](const auto& member) { return member.present(); });
}

bool SharedCoreDispatcher::anyone_competes() const {
  return std::any_of(members_.begin(), members_.end(), [](const auto& member) { return member.competes(); });
}

void SharedCoreDispatcher::begin_decision(TimePoint now) {
  now_ = std::max(now_, now);
  pass_over_standstill();
  decision_.levels.clear();
  decision_.triggers.clear();
  decision_.handed_over.clear();
  decision_.swapped = false;
  decision_.slots.clear();
  decision_.steals.clear();
  decision_.hangs.clear();
}

void SharedCoreDispatcher::pass_over_standstill() {
  if (!stood_still(decision_.ask_at, now_)) return;
  busy_since_ = std::min(busy_since_ + (now_ - decision_.ask_at), now_);
  for (SharedCoreMember& member : members_) member.restart_watch(now_);
}

void SharedCoreDispatcher::take_progress(std::span<const std::uint64_t> completed) {
  for (std::size_t index = 0; index < members_.size(); ++index) {
    using Change = SharedCoreMember::HangChange;
    const Change change = members_[index].take_progress(now_, index < completed.size() ? completed[index] : 0);
    if (change == Change::kNone) continue;
    decision_.hangs.push_back({members_[index].slot().subchain, change == Change::kBegan});
  }
}

// --- The frame ---

// One transition that is due by now; false if there is none.
bool SharedCoreDispatcher::advance() {
  switch (phase_) {
    case Phase::kBoundary:
      return cross_boundary();
    case Phase::kSlots:
      return slot_ ? work_on_slot() : enter_next_slot();
    case Phase::kIdle:
      return end_idle();
    case Phase::kSlack:
      return end_slack();
  }
  return false;
}

bool SharedCoreDispatcher::cross_boundary() {
  const bool anyone = anyone_present();
  if (decision_.swapped || (anyone && now_ < frame_due_)) return false;
  if (next_schedule_) {
    SharedCoreSchedule schedule = std::move(*next_schedule_);
    next_schedule_.reset();
    swap_schedule(std::move(schedule));
    return false;
  }
  if (!anyone || now_ < frame_due_) return false;
  begin_frame();
  return true;
}

void SharedCoreDispatcher::begin_frame() {
  const bool on_grid = fixed() && now_ - frame_due_ < frame_length();
  frame_start_ = on_grid ? frame_due_ : now_;
  for (SharedCoreMember& member : members_) member.begin_frame(frame_number_, frame_start_);
  ++frame_number_;
  next_slot_ = 0;
  busy_since_ = now_;
  phase_ = Phase::kSlots;
}

// Slots without work are passed by at once: they get none before the next frame.
bool SharedCoreDispatcher::enter_next_slot() {
  while (next_slot_ < members_.size() && !members_[next_slot_].has_work()) ++next_slot_;
  if (next_slot_ == members_.size()) {
    finish_slots();
    return true;
  }
  SharedCoreMember& owner = members_[next_slot_];
  const TimePoint planned = fixed() ? frame_start_ + owner.slot().offset : now_;
  if (now_ < planned) return false;
  slot_ = OpenSlot{next_slot_++, planned, planned + owner.slot().slice, false, {}, {}};
  owner.begin_slot(planned);
  check_thief();
  return true;
}

bool SharedCoreDispatcher::work_on_slot() {
  if (slot_->steal_begin && !thief_can_go_on()) end_steal();
  const bool over = now_ >= slot_->end;
  if (!slot_->steal_begin && !(slot_->stolen && over)) serve_owner();
  const bool nothing_left = !slot_->steal_begin && !members_[slot_->index].has_work_in_slot();
  if (!over && (fixed() || !nothing_left)) return false;
  leave_slot();
  return true;
}

void SharedCoreDispatcher::serve_owner() {
  SharedCoreMember& owner = members_[slot_->index];
  const bool at_begin = !slot_->begin;
  if (at_begin) slot_->begin = now_;
  const bool may_trigger = at_begin || (owner.is_queue() && now_ < slot_->end);
  if (!may_trigger || owner.under_way() || !owner.wants_trigger()) return;
  const TimePoint due = owner.trigger(now_, at_begin);
  decision_.triggers.push_back({owner.slot().subchain, owner.state().sent, due});
}

void SharedCoreDispatcher::leave_slot() {
  const SharedCoreMember& owner = members_[slot_->index];
  if (slot_->steal_begin) end_steal();
  decision_.slots.push_back({core_, owner.slot().subchain, slot_->planned, slot_->begin.value_or(now_), now_});
  if (!thief_ && owner.unfinished()) thief_ = slot_->index;
  slot_.reset();
}

// What is left of the frame: idle time, then slack.
void SharedCoreDispatcher::finish_slots() {
  frame_due_ = frame_start_ + frame_length();
  Nanos idle{0};
  if (fixed()) {
    const double slack = schedule_.slack * static_cast<double>(frame_length().count());
    idle = frame_due_ - now_ - Nanos{std::llround(slack)};
  } else {
    slack_.charge(now_ - busy_since_);
    busy_since_ = now_;
    idle = slack_.busy_part(std::max(frame_due_ - now_, Nanos{0}));
  }
  idle_end_ = anyone_competes() ? now_ + idle : now_;
  phase_ = Phase::kIdle;
}

bool SharedCoreDispatcher::end_idle() {
  if (now_ < idle_end_) return false;
  if (!fixed()) {
    slack_.charge(now_ - busy_since_);
    frame_due_ = std::max(frame_due_, now_ + slack_.debt_due());
  }
  slack_since_ = now_;
  phase_ = Phase::kSlack;
  return true;
}

bool SharedCoreDispatcher::end_slack() {
  if (now_ < frame_due_) return false;
  if (!fixed()) slack_.pay(now_ - slack_since_);
  phase_ = Phase::kBoundary;
  return true;
}

// --- Stealing ---

bool SharedCoreDispatcher::thief_can_go_on() const {
  const SharedCoreMember& thief = members_[*thief_];
  return thief.slot().may_steal && thief.may_still_steal() && !thief.hanging();
}

// A slot has come that an unfinished subchain may go on in.
void SharedCoreDispatcher::check_thief() {
  if (!thief_) return;
  if (slot_->end <= now_) return;  // nothing to steal here
  const SharedCoreMember& thief = members_[*thief_];
  const SharedCoreMember& victim = members_[slot_->index];
  // In its own slot, too: a subchain does not outrank itself.
  if (!thief_can_go_on() || thief.slot().rank >= victim.slot().rank) {
    thief_.reset();
    return;
  }
  slot_->stolen = true;
  slot_->steal_begin = now_;
}

// In this slot; the thief may go on in the next.
void SharedCoreDispatcher::end_steal() {
  decision_.steals.push_back(
      {core_, members_[*thief_].slot().subchain, members_[slot_->index].slot().subchain, *slot_->steal_begin, now_});
  slot_->steal_begin.reset();
  if (!thief_can_go_on()) thief_.reset();
}

std::optional<std::size_t> SharedCoreDispatcher::active() const {
  if (!slot_) return std::nullopt;
  return slot_->steal_begin ? *thief_ : slot_->index;
}

// --- Which subchains belong to this core ---

void SharedCoreDispatcher::swap_schedule(SharedCoreSchedule&& schedule) {
  std::optional<SubchainId> thief;
  if (thief_) thief = members_[*thief_].slot().subchain;
  thief_.reset();
  std::vector<SharedCoreMember> old = std::exchange(members_, {});
  schedule_ = std::move(schedule);
  slack_.set_slack(schedule_.slack);
  for (const SharedCoreSlot& slot : schedule_.slots) {
    const auto stays = std::find_if(old.begin(), old.end(),
                                    [&](const auto& member) { return member.slot().subchain == slot.subchain; });
    members_.push_back(stays != old.end() ? *stays : SharedCoreMember(slot));
    members_.back().change_slot(slot);
    if (const std::optional<RunState> state = take_waiting(slot.subchain)) members_.back().adopt(*state);
    if (thief == slot.subchain) thief_ = members_.size() - 1;
  }
  for (const SharedCoreMember& member : old) {
    if (!holds(schedule_, member.slot().subchain)) hand_over(member);
  }
  hand_over_waiting();
  decision_.swapped = true;
}

void SharedCoreDispatcher::hand_over(const SharedCoreMember& member) {
  if (!member.present()) return;
  if (member.level != MemberLevel::kOrdinary)
    decision_.levels.push_back({member.slot().subchain, MemberLevel::kOrdinary});
  decision_.handed_over.push_back({member.slot().subchain, member.state()});
}

// Those that were adopted for a schedule that then left them out.
void SharedCoreDispatcher::hand_over_waiting() {
  for (const auto& [subchain, state] : waiting_) decision_.handed_over.push_back({subchain, state});
  waiting_.clear();
}

std::optional<RunState> SharedCoreDispatcher::take_waiting(SubchainId subchain) {
  const auto found =
      std::find_if(waiting_.begin(), waiting_.end(), [&](const auto& each) { return each.first == subchain; });
  if (found == waiting_.end()) return std::nullopt;
  const RunState state = found->second;
  waiting_.erase(found);
  return state;
}

// --- What the driver is told ---

MemberLevel SharedCoreDispatcher::target_level(const SharedCoreMember& member, bool active) const {
  if (active) return MemberLevel::kActive;
  if (member.hanging()) return MemberLevel::kOrdinary;
  // In the slack only runs under way have to be lowered; members without one may stay lowered.
  const bool lowered = phase_ == Phase::kSlack && (member.under_way() || member.level == MemberLevel::kOrdinary);
  return lowered ? MemberLevel::kOrdinary : MemberLevel::kBackground;
}

void SharedCoreDispatcher::update_levels() {
  const std::size_t active = this->active().value_or(members_.size());
  bool any_rises = false;
  for (std::size_t index = 0; index < members_.size(); ++index) {
    SharedCoreMember& member = members_[index];
    if (!member.present()) continue;
    const MemberLevel level = target_level(member, index == active);
    if (level < member.level) change_level(member, level);
    any_rises = any_rises || level > member.level;
  }
  for (std::size_t index = 0; any_rises && index < members_.size(); ++index) {
    SharedCoreMember& member = members_[index];
    if (!member.present()) continue;
    const MemberLevel level = target_level(member, index == active);
    if (level > member.level) change_level(member, level);
  }
}

void SharedCoreDispatcher::change_level(SharedCoreMember& member, MemberLevel level) {
  member.level = level;
  decision_.levels.push_back({member.slot().subchain, level});
}

TimePoint SharedCoreDispatcher::next_event() const {
  switch (phase_) {
    case Phase::kBoundary:
      if (decision_.swapped) return now_;
      return anyone_present() ? frame_due_ : kNever;
    case Phase::kSlots:
      return slot_ ? slot_->end : frame_start_ + members_[next_slot_].slot().offset;
    case Phase::kIdle:
      return idle_end_;
    case Phase::kSlack:
      return frame_due_;
  }
  return kNever;
}

void SharedCoreDispatcher::plan_next_call() {
  decision_.ask_at = next_event();
  for (const SharedCoreMember& member : members_) decision_.ask_at = std::min(decision_.ask_at, member.hang_at());
  decision_.wake_on_completion.reset();
  const std::optional<std::size_t> index = active();
  if (!index) return;
  const SharedCoreMember& member = members_[*index];
  const bool next_run_waits = member.is_queue() && member.wants_trigger();
  if (!fixed() || slot_->steal_begin || next_run_waits) decision_.wake_on_completion = member.slot().subchain;
}

}  // namespace ctn::dispatch
