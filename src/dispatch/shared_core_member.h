// One subchain among those that share a core: when a run of it is due, whether one is under way, whether it hangs. The
// part of the shared core's dispatcher (shared_core_dispatcher.h) that knows nothing of the others.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <cstdint>
#include <optional>

#include "base/time.h"
#include "dispatch/shared_core_schedule.h"

namespace ctn::dispatch {

// How far a subchain has come, as a value that moves with it from core to core. At most one run is under way: the one
// with number `sent`.
struct RunState {
  std::uint64_t sent = 0;                          // triggers
  std::uint64_t completed = 0;                     // the newest of them whose run has ended
  TimePoint triggered_at{};                        // the newest
  bool hanging = false;                            // the run under way, as has been reported
  int slots_used = 0;                              // whole slots, by the run under way
  bool due = false;                                // a trigger is owed: every n frames
  std::optional<std::int64_t> frames_since_due{};  // none: not due yet since it came
  double credit = 0.0;                             // triggers owed to a queue node
  std::optional<TimePoint> due_at{};               // when the slot came in which the next trigger was due first

  friend bool operator==(const RunState&, const RunState&) = default;
};

// Of a subchain on a shared core: each level pre-empts all before it. What they are for threads: policy/levels.h.
enum class MemberLevel { kOrdinary, kBackground, kActive };

class SharedCoreMember {
 public:
  // Absent until it is adopted.
  explicit SharedCoreMember(const SharedCoreSlot& slot);

  void adopt(const RunState& state);
  bool present() const { return present_; }
  const RunState& state() const { return state_; }
  // A new plan: the state stays, but that no more credit is kept than the new share allows.
  void change_slot(const SharedCoreSlot& slot);

  const SharedCoreSlot& slot() const { return slot_; }
  bool is_queue() const { return !slot_.every; }
  bool under_way() const { return state_.sent > state_.completed; }
  bool wants_trigger() const;
  bool has_work() const { return present_ && (under_way() || wants_trigger()); }
  // Something to do before the slot's end: an n-frame subchain's next trigger waits for the next slot.
  bool has_work_in_slot() const { return under_way() || (is_queue() && wants_trigger()); }
  bool hanging() const { return state_.hanging; }
  // Real-time work that would starve ordinary threads.
  bool competes() const { return present_ && under_way() && !state_.hanging; }
  // The run under way has used all the slots in which it was planned to end.
  bool unfinished() const { return under_way() && state_.slots_used >= planned_slots(); }
  // Unfinished, but not by more than a run that cost more than most; one that has used many more slots than planned may
  // no longer take those of others.
  bool may_still_steal() const { return unfinished() && state_.slots_used < kStealingEnds * planned_slots(); }

  void begin_frame(std::uint64_t number, TimePoint start);
  void begin_slot(TimePoint planned);
  // Precondition: wants_trigger() and no run is under way. When the trigger was due.
  TimePoint trigger(TimePoint now, bool at_slot_begin);

  enum class HangChange { kNone, kBegan, kEnded };
  // `completed` may claim anything: what was never sent has not ended, and what has ended stays so.
  HangChange take_progress(TimePoint now, std::uint64_t completed);
  // The thread that watches was stopped until now: the run under way has all its time once more before it hangs.
  void restart_watch(TimePoint now) { watched_since_ = now; }
  TimePoint hang_at() const;  // when the run under way will be taken to hang; kNever: not to be watched for

  MemberLevel level = MemberLevel::kOrdinary;

 private:
  static constexpr int kStealingEnds = 4;

  int planned_slots() const;
  double max_credit() const;

  SharedCoreSlot slot_;
  bool present_ = false;
  bool deferred_ = false;  // in this frame: its rate cap allows no trigger yet
  TimePoint watched_since_{};
  RunState state_;
};

}  // namespace ctn::dispatch
