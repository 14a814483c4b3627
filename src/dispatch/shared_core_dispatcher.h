// Takes turns among the subchains that share one core: the pure state machine that driver/core_driver.h carries out.
// It is told the time and how far each subchain's runs have come, and answers what to do now and when to ask again. It
// reads no clock and makes no call, so the real runtime and virtual time drive the very same code.
//
// A frame is a row of slots, in order, and the slack last. In its slot a subchain is active, and its head is triggered
// if that is due and no run of it is under way; otherwise it is in the background, where it may use what the active one
// leaves idle. A run that is not done at its slot's end goes on in its subchain's next slots.
//   fixed     Slots begin at their planned offsets, frames on a grid of T, at least kShortestFrame. What a slot's
//             subchain leaves is the background's. A late call finds later slots where they were planned; a slot that
//             is over by then still has its trigger sent. Once a call is a whole frame late, the grid restarts.
//   elastic   A slot begins when the dispatcher comes to it, so that being late costs no slice. It ends with its
//             slice, or as soon as its subchain has nothing left to do, and is left out if it has nothing to do at all.
//             The next frame follows at once, but not sooner than frame_min and kShortestFrame, and not without what is
//             owed to ordinary threads (slack_account.h).
// Due: a subchain with n every n frames, the first time in a frame whose number is its phase modulo n. If the run
// before is still under way then, it waits for the first slot that finds it ended. Queue nodes earn f runs a frame and
// spend one on each trigger, several in one slot if they can; what they may save is bounded, so that a pause makes no
// burst. A subchain with a `min_period` is deferred to the first frame that begins so long after its last trigger: a
// rate cap that is to hold up no other subchain.
//
// Slack: no thread with a run under way is above the ordinary level, or such runs would starve ordinary threads. Time
// that has to be waited anyway (frame_min, planned idle time) is the background's, and goes before the slack; with no
// run under way it is all the same, and counts as slack.
//
// Stealing: a run that has had all its planned slots and is not done may go on, active, in the slots that follow until
// it is done, across the frame's end too, as long as each is of a lower rank; the first one that is not ends it. Never
// in the slack or in time that no subchain was planned to use. The slot's owner gets what is left of it; if nothing is
// left, its trigger waits for its next slot. Slots that have no work, no length, or are over before they were looked
// at, are not stolen. A run that has had four times its planned slots steals no more: what it takes beyond all plans is
// its own subchain's loss.
//
// Hang: a run under way for longer than `hang_after` is suspended: it is active in its slots, at the ordinary level
// otherwise, and does not steal.
//
// After a standstill (standstill.h) ordinary threads are owed no slack for it, and runs under way are watched for
// hanging again.
//
// A new schedule takes effect between two frames, in a decision by itself: `swapped`, after which the order of progress
// is the new one. Members that stay keep runs, credit and rhythm. Those that are in it no more are handed over, with
// the state of their runs; those that are new to it are absent until they are adopted, so that of two cores only one
// ever holds a subchain. A subchain is handed over at the ordinary level, and expected there when it is adopted.
//
// Units: Nanos, TimePoint. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "dispatch/shared_core_member.h"
#include "dispatch/shared_core_schedule.h"
#include "dispatch/slack_account.h"
#include "dispatch/slot_use.h"

namespace ctn::dispatch {

class SharedCoreDispatcher {
 public:
  // The first frame begins at `start`, or as soon as a member has been adopted. `core`: what it tells is of that one.
  SharedCoreDispatcher(TimePoint start, SharedCoreSchedule schedule, int core = 0);

  struct LevelChange {
    SubchainId subchain;
    MemberLevel level = MemberLevel::kOrdinary;
  };
  struct Trigger {
    SubchainId subchain;
    std::uint64_t number = 0;  // counted from 1
    TimePoint due{};           // when the slot came in which it was due first
  };
  struct Hang {
    SubchainId subchain;
    bool began = false;  // else: ended
  };
  struct HandOver {
    SubchainId subchain;
    RunState state;
  };

  // To be carried out in this order: levels, then triggers. The rest is for the record.
  struct Decision {
    std::vector<LevelChange> levels;  // only changes; those that lower a level first
    std::vector<Trigger> triggers;
    std::vector<HandOver> handed_over;
    bool swapped = false;  // the new schedule is in force
    std::vector<SlotUse> slots;
    std::vector<Steal> steals;  // that are over
    std::vector<Hang> hangs;
    TimePoint ask_at{};                            // ask again then,
    std::optional<SubchainId> wake_on_completion;  // or as soon as a run of this one ends
  };

  // `completed`: for each slot of the schedule in force the newest trigger whose run has ended, counted from 1. It is
  // not trusted: what is missing, goes backwards or was never sent counts as no progress. Time that goes backwards
  // stands still. A call may come early, late, or twice. The decision is good until the next call.
  const Decision& step(TimePoint now, std::span<const std::uint64_t> completed);

  // At the end of the frame; of several the last. An empty one hands over all members. To be followed by a call of
  // step().
  void change_schedule(SharedCoreSchedule schedule);

  // Takes a subchain that no other core holds: RunState{} at first, then as it was handed over. It may come before
  // its schedule does. A run that is under way goes on in its next slot, frames count for it from the next one. To be
  // followed by a call of step().
  void adopt(SubchainId subchain, const RunState& state);

  const SharedCoreSchedule& schedule() const { return schedule_; }
  // That have begun, across changes of the schedule.
  std::uint64_t frames() const { return frame_number_; }

 private:
  enum class Phase { kBoundary, kSlots, kIdle, kSlack };
  struct OpenSlot {
    std::size_t index = 0;
    TimePoint planned{};
    TimePoint end{};
    bool stolen = false;
    std::optional<TimePoint> steal_begin;  // while it is being stolen
    std::optional<TimePoint> begin;        // once its owner has begun
  };

  bool fixed() const { return schedule_.frames == graph::FrameMode::kFixed; }
  Nanos frame_length() const;
  bool anyone_present() const;
  bool anyone_competes() const;

  void begin_decision(TimePoint now);
  void pass_over_standstill();
  void take_progress(std::span<const std::uint64_t> completed);
  bool advance();
  bool cross_boundary();
  void begin_frame();
  bool enter_next_slot();
  bool work_on_slot();
  void serve_owner();
  void leave_slot();
  void finish_slots();
  bool end_idle();
  bool end_slack();

  bool thief_can_go_on() const;
  void check_thief();
  void end_steal();
  std::optional<std::size_t> active() const;

  void swap_schedule(SharedCoreSchedule&& schedule);
  void hand_over(const SharedCoreMember& member);
  void hand_over_waiting();
  std::optional<RunState> take_waiting(SubchainId subchain);

  MemberLevel target_level(const SharedCoreMember& member, bool active) const;
  void update_levels();
  void change_level(SharedCoreMember& member, MemberLevel level);
  TimePoint next_event() const;
  void plan_next_call();

  int core_;
  SharedCoreSchedule schedule_;
  std::vector<SharedCoreMember> members_;  // in the order of slots
  std::optional<SharedCoreSchedule> next_schedule_;
  std::vector<std::pair<SubchainId, RunState>> waiting_;  // adopted, with no slot in force

  Phase phase_ = Phase::kBoundary;
  TimePoint now_;
  TimePoint frame_due_;    // the next frame's start
  TimePoint frame_start_;  // this one's
  std::uint64_t frame_number_ = 0;
  std::size_t next_slot_ = 0;
  std::optional<OpenSlot> slot_;
  std::optional<std::size_t> thief_;  // the unfinished one that goes on in others' slots as long as it may
  TimePoint idle_end_{};
  TimePoint busy_since_{};   // what has not been accounted for yet: real-time levels since,
  TimePoint slack_since_{};  // ordinary threads since
  SlackAccount slack_;
  Decision decision_;
};

}  // namespace ctn::dispatch
