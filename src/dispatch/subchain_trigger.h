// When to trigger the head of a subchain: the pure state machine that driver/subchain_pacer.h carries out. It is told
// the time and how far the subchain's runs have come, and answers what to do now and when to ask again. It reads no
// clock and makes no call, so the real runtime and virtual time drive the very same code.
//
// Two ways to pace:
//   gated    (Catan, a subchain that owns its cores) every period, but never while as many runs are under way as its
//            cores can overlap: then as soon as one has ended. A run that takes longer than planned delays the next one
//            instead of competing with it for the cores.
//   ungated  (hand-set rates) every period, whatever the runs do, as a sensor's own timer would.
//
// Triggers keep to a grid (a late one does not shift the next) until one is a whole period late: then the grid restarts
// from it.
//
// Elastic, a subchain is paced by its own output instead: where m runs overlap, the run that is m triggers later is due
// when, after the end of this one, m periods less one execution have passed. On one core that is the idle time after
// each run; in a pipeline the input then reaches the longest node when it is ready for it. Runs shorter than expected
// let it go faster; an input that has to wait makes it go slower until none has to.
//
// After a standstill (standstill.h) a run under way is watched for hanging again.
//
// Units: Nanos, TimePoint. Thread safety: none; one owner.
#pragma once

#include <cstdint>
#include <optional>

#include "base/time.h"
#include "dispatch/standstill.h"
#include "plan/plan.h"

namespace ctn::dispatch {

// How a subchain is to be triggered; a value that the plan gives.
struct Pacing {
  Nanos period{0};        // > 0
  int max_in_flight = 0;  // runs under way at most; 0: ungated
  Nanos hang_after{0};    // a run under way for longer is taken to hang; 0: never
  // Elastic: the next trigger comes this long after a run has ended, or a period after the last trigger where none has;
  // 0: always the latter.
  Nanos after_completion{0};
  Nanos shortest{0};  // between two triggers, at least
  // Fixed priorities.
  std::optional<Nanos> phase{};        // triggers come at phase + k periods of the clock; none: from the first one on
  std::optional<plan::After> after{};  // in place of time: each so-many-th output of another subchain
  Nanos budget{0};                     // CPU time of a run; one beyond it is demoted until the next trigger. 0: any

  friend bool operator==(const Pacing&, const Pacing&) = default;
};

// Nothing is triggered more often, whatever a plan says: nodes that cost next to nothing would otherwise keep their
// controller, which outranks everything, busy without end.
constexpr Nanos kShortestPeriod = std::chrono::microseconds{100};

// The pacing of a subchain that owns its cores: as many runs overlap as a run is periods long (rounded up), which is
// one on one core.
Pacing pacing_of_owned(Millis period, Millis execution, Nanos hang_after);

// The same, paced by its own output; `shortest` >= 0.
Pacing elastic_pacing_of_owned(Millis period, Millis execution, Nanos hang_after, Nanos shortest);

class SubchainTrigger {
 public:
  // The first trigger comes at `start`. A subchain that was triggered by others before goes on counting: `sent` of
  // them, of which the runs up to `completed` have ended.
  SubchainTrigger(TimePoint start, const Pacing& pacing, std::uint64_t sent = 0, std::uint64_t completed = 0);

  struct Decision {
    std::optional<TimePoint> trigger;  // send a trigger now; when it was due
    bool hang_began = false;           // the oldest run under way has just become one that hangs
    bool hang_ended = false;           // ... and has come to an end after all
    TimePoint ask_at{};                // ask again then,
    bool ask_on_completion = false;    // or as soon as a run ends
  };

  // `completed`: the newest trigger whose run has ended, counted from 1; triggers that were overtaken count as ended.
  // Time never goes backwards; a call may come early, late, or twice.
  Decision step(TimePoint now, std::uint64_t completed);

  // Takes effect at once: the next trigger is due one new period after the last one, or now if that has passed. Where
  // runs may overlap it waits for all that are under way, so that what piled up in front of a slow node under the old
  // pacing does not stay there under the new one.
  void change_pacing(TimePoint now, const Pacing& pacing);

  std::uint64_t sent() const { return sent_; }
  TimePoint last_trigger() const { return last_due_; }
  bool hanging() const { return hanging_; }

 private:
  bool may_overlap(std::uint64_t completed) const;
  void watch(TimePoint now, std::uint64_t completed, Decision& decision);

  Pacing pacing_;
  TimePoint due_;
  TimePoint last_due_;
  std::uint64_t sent_ = 0;
  std::uint64_t completed_ = 0;
  TimePoint progress_at_;  // when a run last ended, or the first of those under way began
  bool hanging_ = false;
  TimePoint asked_for_ = kNever;  // the next call
};

}  // namespace ctn::dispatch
