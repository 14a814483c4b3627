#include "plan/plan.h"

#include <algorithm>

namespace ctn::plan {

const char* to_string(Form form) { return form == Form::kFrames ? "frames" : "priorities"; }

Millis usual_period(const Plan& plan, SubchainId subchain) {
  return plan.expected ? plan.expected->subchains[subchain.index()].period : plan.subchains[subchain.index()].period;
}

const Member* member_of(const Plan& plan, SubchainId subchain) {
  const int core = plan.subchains[subchain.index()].cores.front();
  const std::vector<Member>& members = plan.cores[static_cast<std::size_t>(core)].members;
  const auto found =
      std::find_if(members.begin(), members.end(), [&](const Member& member) { return member.subchain == subchain; });
  return found != members.end() ? &*found : nullptr;
}

}  // namespace ctn::plan
