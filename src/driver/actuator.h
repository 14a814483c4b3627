// What a controller (controller.h) needs from outside. In the runtime threads provide it (runtime/controller_thread.h),
// in the simulator events (sim/controllers.h), in tests a fake that remembers the calls (testing/fake_world.h).
//
// An actuator acts for one controller at a time. It carries out each call at once, and never waits. Time is an
// argument of Controller::step(); an actuator has a clock of its own where it must say when something was done.
//
// Units: in the types. Thread safety: none; one owner, the controller's thread.
#pragma once

#include <cstdint>
#include <optional>

#include "base/ids.h"
#include "base/ticks.h"
#include "base/time.h"
#include "dispatch/overrun.h"
#include "dispatch/shared_core_member.h"
#include "dispatch/slot_use.h"
#include "os/os.h"
#include "policy/assignment.h"

namespace ctn::driver {

class Actuator {
 public:
  virtual ~Actuator() = default;

  // --- Which controller holds which subchain ---
  // The newest; good until the next call of this or of hand_over().
  virtual const policy::Assignment& assignment() = 0;
  // A subchain that no controller holds, with the state of its runs; from now on this controller holds it. None:
  // another still does. Its threads are at the ordinary level, or, where it has just been set up, at whatever
  // level they came.
  virtual std::optional<dispatch::RunState> take(SubchainId subchain) = 0;
  // Gives up it and its completions, and wakes the controller that is to have it by the newest assignment.
  virtual void hand_over(SubchainId subchain, const dispatch::RunState& state) = 0;

  // --- The threads of a subchain that is held ---
  virtual void move(SubchainId subchain, const os::CpuSet& cpus) = 0;
  virtual void set_level(SubchainId subchain, os::Level level) = 0;
  virtual void set_levels(SubchainId subchain, const policy::SubchainPlace& place) = 0;  // as the place says
  // Whether any have joined a subchain that is held, since it was taken or this was last asked. They come at the
  // ordinary level, and may run anywhere.
  virtual bool threads_joined() = 0;

  // --- Its runs ---
  // Triggers its head, and reports that; `due`: when that should have been.
  virtual void trigger(SubchainId subchain, std::uint64_t number, TimePoint due) = 0;
  // The newest trigger whose run has ended. It may be any number: nodes write it, and are not trusted.
  virtual std::uint64_t completed(SubchainId subchain) const = 0;
  // Whether the controller is to step as soon as a run has ended. `known`: what completed() was when the controller
  // decided; if it is something else by now, the next step follows at once.
  virtual void await_completion(SubchainId subchain, bool wanted, std::uint64_t known) = 0;
  // From now on CPU time is counted for its run.
  virtual void begin_run(SubchainId subchain) = 0;
  // CPU time that its threads have used since then. One that has ended counts with what it had used when it was looked
  // at last, one that has joined from when it was seen first.
  virtual Nanos cpu_time(SubchainId subchain) = 0;

  // --- The outputs of a leader that this controller's subchain follows, whichever controller holds it ---
  struct Outputs {
    std::uint64_t count = 0;
    TimePoint newest{};  // when that came
  };
  // Of a subchain's tail, or of an unscheduled node. They may be anything, as completed().
  virtual Outputs outputs(const plan::Leader& leader) const = 0;
  // The controller is to step as soon as so many outputs have been given, and at each one beyond; at once where that is
  // so already. False: there is no room for another that follows it, so the controller has to look by itself.
  virtual bool await_outputs(const plan::Leader& leader, std::uint64_t count) = 0;
  virtual void ignore_outputs(const plan::Leader& leader) = 0;

  // --- Clocks of others ---
  // What is known of a node's clock (graph::Node::has_clock()); none: nothing yet.
  virtual std::optional<Ticks> clock(NodeId node) const = 0;

  // --- Reports ---
  virtual void slot_over(const dispatch::SlotUse& slot) = 0;
  virtual void stole(const dispatch::Steal& steal) = 0;
  virtual void hang_changed(SubchainId subchain, bool began, TimePoint at) = 0;
  virtual void over_budget(const dispatch::Overrun& overrun) = 0;
};

}  // namespace ctn::driver
