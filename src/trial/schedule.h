// Which subchain runs where and when, as a trial (trial.h) is given it: what of a plan has an effect on how it runs, in
// a form that is cheap to copy and to change, since a search tries thousands of them.
//
// Units: Nanos. Core numbers are those of plans. Thread safety: plain values and a pure function.
#pragma once

#include <optional>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "dispatch/shared_core_schedule.h"
#include "dispatch/subchain_trigger.h"
#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::trial {

// How a subchain comes to its runs.
enum class Form {
  kPriority,  // on one core, at a fixed priority; alone there, too
  kFrames,    // on one core, in slots of a frame: Schedule::frames
  kPipeline,  // on several cores, where its runs overlap: Schedule::pipelines
};

// A subchain's place. All but `form` and `core` is of fixed priorities, and means what it does in plan::Member.
struct Place {
  Form form = Form::kPriority;
  int core = 0;      // of a pipeline the first
  int priority = 1;  // from 1
  Nanos period{0};   // > 0 where there is no `after`; with one, what comes sooner waits
  Nanos phase{0};
  std::optional<NodeId> clock{};
  std::optional<Nanos> pause{};
  std::optional<plan::After> after{};
  Nanos budget{0};  // 0: any

  friend bool operator==(const Place&, const Place&) = default;
};

// A subchain that owns several cores.
struct Pipeline {
  SubchainId subchain;
  std::vector<int> cores;
  int threads = 1;          // q: that each of its nodes works on
  dispatch::Pacing pacing;  // dispatch/subchain_trigger.h

  friend bool operator==(const Pipeline&, const Pipeline&) = default;
};

struct Schedule {
  int cores = 1;
  std::vector<Place> subchains;                      // by SubchainId
  std::vector<dispatch::SharedCoreSchedule> frames;  // by core; without slots where there are no frames. Empty: nowhere
  std::vector<Pipeline> pipelines;

  friend bool operator==(const Schedule&, const Schedule&) = default;
};

// What the plan comes to. A subchain that owns its core is paced as policies pace it: by its own output where frames
// are elastic and its rate is not exact, else by time. Precondition: the plan is valid for the app (plan/validate.h).
Schedule schedule_of(const graph::App& app, const plan::Plan& plan);

}  // namespace ctn::trial
