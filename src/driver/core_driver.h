// Takes turns among the subchains that share one core: the state machine of shared cores
// (dispatch/shared_core_dispatcher.h), carried out. While no subchains share the core it has nothing to do.
//
// A subchain that is to share the core by an assignment, but is still held by another controller, is absent: its slot
// is skipped until that hands it over. Those that an assignment leaves out are handed over at the end of the frame.
//
// Thread safety: as controller.h says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "dispatch/shared_core_dispatcher.h"
#include "driver/actuator.h"
#include "driver/controller.h"

namespace ctn::driver {

class CoreDriver final : public Controller {
 public:
  // `core`: as numbered in plans. `subchains`: how many the app has. `actuator` outlives it.
  CoreDriver(Actuator& actuator, int core, std::size_t subchains);

  TimePoint step(TimePoint now) override;

 private:
  struct Held {
    os::Level level = os::Level::kOrdinary;
    os::CpuSet cpus;
  };

  void follow();
  void find_absent(const dispatch::SharedCoreSchedule& schedule);
  void adopt_waiting(const policy::Assignment& assignment);
  void raise_joined_threads();
  void collect_progress();
  void carry_out(const dispatch::SharedCoreDispatcher::Decision& decision);
  void hand_over(SubchainId subchain, const dispatch::RunState& state);
  void report(const dispatch::SharedCoreDispatcher::Decision& decision, TimePoint now);
  void await_completion_of(std::optional<SubchainId> subchain);

  Actuator* actuator_;
  int core_;
  std::uint64_t following_ = 0;  // the assignment's number
  dispatch::SharedCoreDispatcher dispatcher_;
  std::vector<std::optional<Held>> held_;  // by SubchainId; none: not held
  std::vector<SubchainId> absent_;         // have a slot by the assignment that is followed, and have not come yet
  std::vector<SubchainId> members_;        // in the order of the slots of the schedule in force
  std::vector<std::uint64_t> progress_;    // theirs
  std::optional<SubchainId> awaited_;      // whose completion is asked for
};

}  // namespace ctn::driver
