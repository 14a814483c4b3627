// Paces one subchain while it has its CPUs to itself, or a fixed priority on one: the state machine of
// dispatch/subchain_trigger.h, carried out. While the subchain takes turns on a core, or one of its nodes is missing,
// it has nothing to do.
//
// It is also the watchdog of its subchain: a run that exceeds its budget of CPU time is demoted to the background,
// below all fixed priorities, until the next trigger; a run that hangs at a real-time level is lowered to the ordinary
// one until it ends.
//
// Thread safety: as controller.h says.
#pragma once

#include <cstdint>
#include <optional>

#include "dispatch/subchain_trigger.h"
#include "driver/actuator.h"
#include "driver/controller.h"

namespace ctn::driver {

class SubchainPacer final : public Controller {
 public:
  // `actuator` outlives it.
  SubchainPacer(Actuator& actuator, SubchainId subchain) : actuator_(&actuator), subchain_(subchain) {}

  TimePoint step(TimePoint now) override;

 private:
  void follow(TimePoint now);
  void adopt(TimePoint now, const policy::SubchainPlace& place, const dispatch::RunState& state);
  void change(TimePoint now, const policy::SubchainPlace& place);
  void raise_joined_threads();
  void hand_over();
  void set_leader(std::optional<plan::Leader> leader);
  TimePoint hear(TimePoint now);
  void measure(TimePoint now, std::uint64_t completed);
  void act(const dispatch::SubchainTrigger::Decision& decision, TimePoint now);

  Actuator* actuator_;
  SubchainId subchain_;
  std::uint64_t following_ = 0;  // the assignment's number
  policy::SubchainPlace place_;
  std::optional<dispatch::SubchainTrigger> trigger_;  // none: it does not hold the subchain
  bool suspended_ = false;                            // a run of it hangs
  bool awaits_ = false;                               // the end of a run
  std::optional<plan::Leader> leader_;                // that it follows, and whose outputs it awaits
  Nanos cpu_time_{0};                                 // of the run under way, as measured last
  std::uint64_t told_over_budget_ = 0;                // the run of which this was told last
};

}  // namespace ctn::driver
