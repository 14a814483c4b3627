#include "trial/schedule.h"

#include <algorithm>

namespace ctn::trial {
namespace {

Place place_of(const plan::Member& member, int core) {
  Place place{.core = core,
              .priority = member.priority,
              .period = to_nanos(member.period),
              .phase = to_nanos(member.phase),
              .clock = member.clock,
              .after = member.after,
              .budget = to_nanos(member.budget)};
  if (member.pause) place.pause = to_nanos(*member.pause);
  return place;
}

// On one core no runs overlap: that is a core of fixed priorities with one member.
Place place_of_owner(const dispatch::Pacing& pacing, int core) {
  Place place{.core = core, .period = pacing.period};
  if (pacing.after_completion > Nanos{0}) {
    place.pause = pacing.after_completion;
    place.period = pacing.shortest;
  }
  return place;
}

}  // namespace

Schedule schedule_of(const graph::App& app, const plan::Plan& plan) {
  Schedule schedule{.cores = static_cast<int>(plan.cores.size()), .subchains = {}, .frames = {}, .pipelines = {}};
  for (std::size_t index = 0; index < plan.subchains.size(); ++index) {
    const SubchainId id(index);
    const plan::SubchainPlan& planned = plan.subchains[index];
    const int core = planned.cores.front();
    if (const plan::Member* member = plan::member_of(plan, id)) {
      schedule.subchains.push_back(place_of(*member, core));
    } else if (plan::shares_core(plan, planned)) {
      schedule.subchains.push_back({.form = Form::kFrames, .core = core});
    } else if (planned.cores.size() > 1) {
      schedule.subchains.push_back({.form = Form::kPipeline, .core = core});
      schedule.pipelines.push_back(
          {id, planned.cores, planned.threads, dispatch::pacing_of_owner(app, plan, id, Nanos{0})});
    } else {
      schedule.subchains.push_back(place_of_owner(dispatch::pacing_of_owner(app, plan, id, Nanos{0}), core));
    }
  }
  const bool frames =
      std::any_of(plan.cores.begin(), plan.cores.end(), [](const auto& core) { return !core.slots.empty(); });
  for (std::size_t core = 0; frames && core < plan.cores.size(); ++core) {
    schedule.frames.push_back(dispatch::shared_core_schedule(app, plan, static_cast<int>(core), {}));
  }
  return schedule;
}

}  // namespace ctn::trial
