// The dispatcher thread of one core: the pure state machine of shared cores (dispatch/shared_core_dispatcher.h), driven
// by the clock and by completions. While nobody shares the core it sleeps.
//
// It is bound to its core's CPU, so that nothing of the core runs while it decides; it makes system calls only for
// threads whose level changes. Timers are absolute: what it is late by does not add up.
//
// Thread safety: as controller.h says.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "dispatch/shared_core_dispatcher.h"
#include "runtime/controller.h"

namespace ctn::runtime {

class CoreThread : public Controller {
 public:
  // All references outlive the thread.
  CoreThread(Controls& controls, const std::vector<SubchainLinks>& subchains, int core);

  void run() override;

 private:
  void follow(dispatch::SharedCoreDispatcher& dispatcher);
  void adopt_waiting(dispatch::SharedCoreDispatcher& dispatcher, const Assignment& assignment);
  void gather_progress(const dispatch::SharedCoreDispatcher& dispatcher);
  void carry_out(const dispatch::SharedCoreDispatcher::Decision& decision);
  void raise_newcomers();
  void report(const dispatch::SharedCoreDispatcher::Decision& decision, TimePoint at);
  // False: the run to be waited for has ended meanwhile.
  bool wait_for_completion_of(std::optional<SubchainId> subchain);

  Controls& controls_;
  int core_;
  std::uint64_t following_ = 0;                  // the assignment's number
  std::vector<std::optional<os::Level>> level_;  // by SubchainId; none: not held
  std::vector<std::uint64_t> progress_;          // by slot of the schedule in force
  std::vector<SubchainId> slots_;                // whose
  std::optional<SubchainId> awaited_;
};

}  // namespace ctn::runtime
