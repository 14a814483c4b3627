// The thread that triggers a subchain while it has its CPUs to itself: the pure state machine of owned cores
// (dispatch/subchain_trigger.h), driven by the clock and by completions. While the subchain shares a core it sleeps.
//
// It is also the watchdog of its subchain: a run that hangs at a real-time level is lowered to the ordinary one until
// it ends.
//
// Thread safety: as controller.h says.
#pragma once

#include <cstdint>
#include <optional>

#include "dispatch/subchain_trigger.h"
#include "runtime/controller.h"

namespace ctn::runtime {

class TriggerThread : public Controller {
 public:
  // All references outlive the thread.
  TriggerThread(Controls& controls, const std::vector<SubchainLinks>& subchains, SubchainId subchain);

  void run() override;

 private:
  void follow();
  void begin(const policy::SubchainPlace& place, const dispatch::RunState& state);
  void change(const policy::SubchainPlace& place);
  void give_up();
  void act(const dispatch::SubchainTrigger::Decision& decision, TimePoint at);

  Controls& controls_;
  SubchainId subchain_;
  std::uint64_t following_ = 0;  // the assignment's number
  policy::SubchainPlace place_;
  std::optional<dispatch::SubchainTrigger> trigger_;  // none: the subchain is not in its hands
  bool contained_ = false;
};

}  // namespace ctn::runtime
