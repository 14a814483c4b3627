// How several subchains take turns on one core: what the dispatcher of a shared core (shared_core_dispatcher.h) is
// given to do. A plain value, made from a plan.
//
// Units: Nanos. Thread safety: plain values and a pure function.
#pragma once

#include <optional>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::dispatch {

// No frame is shorter, whatever a plan says: subchains that cost next to nothing would otherwise keep the dispatcher,
// which outranks everything, busy without end.
constexpr Nanos kShortestFrame = std::chrono::microseconds{100};

// In elastic frames no slot ends sooner with its subchain's run under way: a timer is no more exact than that, and a
// run whose cost was taken for nothing must still come to its end. It costs no other subchain anything, as a slot ends
// with its run.
constexpr Nanos kShortestSlice = std::chrono::microseconds{50};

// What a slot is longer than its slice: in fixed frames each one, as far as the frame's idle time goes; in elastic
// frames those of subchains that run in every frame.
constexpr Nanos kSwitchAllowance = std::chrono::microseconds{200};

// A subchain's place in the frame.
struct SharedCoreSlot {
  SubchainId subchain;
  Nanos offset{0};           // from the frame's start; what fixed frames keep to
  Nanos slice{0};            // >= 0
  std::optional<int> every;  // n >= 1: a trigger every n frames; none for a queue node, which goes by its share
  int phase = 0;             // in [0, n): the first trigger comes in a frame whose number is phase modulo n
  double share = 1.0;        // f > 0: runs a frame
  int rank = 0;              // for stealing; 0 is the highest, no two are equal
  bool may_steal = true;
  Nanos min_period{0};  // elastic frames: from one trigger to the frame of the next, at least
  Nanos hang_after{0};  // a run under way for longer is taken to hang; 0: never

  friend bool operator==(const SharedCoreSlot&, const SharedCoreSlot&) = default;
};

struct SharedCoreSchedule {
  graph::FrameMode frames = graph::FrameMode::kElastic;
  Nanos frame{0};      // T; the length of fixed frames
  Nanos frame_min{0};  // of elastic ones: never shorter
  double slack = 0.0;  // in [0, 1): the part of each frame that is left to ordinary threads
  std::vector<SharedCoreSlot> slots;

  friend bool operator==(const SharedCoreSchedule&, const SharedCoreSchedule&) = default;
};

struct ScheduleOptions {
  bool stealing = true;        // false: no subchain steals, whatever the app says
  double hang_multiple = 0.0;  // of the planned execution time; 0: no run is ever taken to hang
  Nanos shortest_hang{0};      // no run is taken to hang sooner
};

// Precondition: `plan` is valid for `app` (plan::validate) and has this core. A core that no subchains share has no
// slots.
SharedCoreSchedule shared_core_schedule(const graph::App& app, const plan::Plan& plan, int core,
                                        const ScheduleOptions& options);

}  // namespace ctn::dispatch
