#include "planner/moves.h"

#include <algorithm>
#include <utility>

#include "dispatch/subchain_trigger.h"
#include "model/portable_math.h"
#include "plan/limits.h"

namespace ctn::planner {
namespace {

using trial::Place;
using trial::Schedule;

// Most steps are small; a few are not.
constexpr double kSmallStep = 0.12;
constexpr double kLargeStep = 0.8;
constexpr std::size_t kMostOutputs = 6;
// A follower is held apart by so much of the time between the outputs that trigger it.
constexpr double kHeldApart = 0.8;

// By a factor between exp(-size) and exp(size).
double stretched(double value, double size, Random& random) {
  return value * model::portable_exp((2.0 * random.fraction() - 1.0) * size);
}

bool has_cycle(const Schedule& schedule) {
  for (std::size_t from = 0; from < schedule.subchains.size(); ++from) {
    std::size_t at = from;
    for (std::size_t steps = 0; schedule.subchains[at].after; ++steps) {
      if (steps > schedule.subchains.size()) return true;
      at = schedule.subchains[at].after->subchain.index();
    }
  }
  return false;
}

}  // namespace

Moves::Moves(const graph::App& app, std::vector<double> cost, const Pipelines& pipelines, int cores)
    : app_(app), pipelines_(pipelines), cost_(std::move(cost)), cores_(cores) {
  for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
    const plan::PeriodLimits limits = plan::period_limits(app.graph, SubchainId(i));
    limits_.push_back({std::max(to_nanos(limits.min), dispatch::kShortestPeriod), limits.exact.has_value()});
  }
}

void Moves::change(Schedule& schedule, Random& random) const {
  const int changes = random.once_in(3) ? 2 : 1;
  for (int each = 0; each < changes; ++each) change_one(schedule, random);
}

void Moves::change_one(Schedule& schedule, Random& random) const {
  const std::size_t i = random.below(schedule.subchains.size());
  const std::size_t other = random.below(schedule.subchains.size());
  Place& place = schedule.subchains[i];
  if (place.form == trial::Form::kFrames) return;
  constexpr std::size_t kSeldom = 12;
  if (place.form == trial::Form::kPipeline ||
      (cores_ > 1 && pipelines_.most_cores(SubchainId(i)) > 1 && random.once_in(kSeldom))) {
    return change_cores(schedule, i, random);
  }
  switch (random.below(10)) {
    case 0:
    case 1:
    case 2:
    case 3:
      return change_time(place, i, random);
    case 4:
      if (schedule.subchains[other].form == trial::Form::kPriority) {
        std::swap(place.priority, schedule.subchains[other].priority);
      }
      return;
    case 5:
      return change_core(schedule, i, other, random);
    case 6:
      return change_pause(place, i, random);
    case 7:
    case 8:
      return change_trigger(schedule, i, random);
    default:
      if (!place.after && !place.pause) {
        place.phase = to_nanos(to_millis(place.period) * random.fraction());
        if (place.phase >= place.period) place.phase = Nanos{0};
      }
  }
}

void Moves::change_time(Place& place, std::size_t subchain, Random& random) const {
  if (limits_[subchain].exact) return;
  const double size = random.once_in(4) ? kLargeStep : kSmallStep;
  if (place.pause) {
    place.pause = to_nanos(Millis{stretched(to_millis(*place.pause).count(), size, random)});
    return;
  }
  const double phase = to_millis(place.phase) / to_millis(place.period);
  place.period =
      std::max(to_nanos(Millis{stretched(to_millis(place.period).count(), size, random)}), limits_[subchain].shortest);
  place.phase = std::min(to_nanos(phase * to_millis(place.period)), place.period - Nanos{1});
}

void Moves::change_core(Schedule& schedule, std::size_t subchain, std::size_t other, Random& random) const {
  if (cores_ < 2) return;
  Place& place = schedule.subchains[subchain];
  if (random.once_in(2) && schedule.subchains[other].form == trial::Form::kPriority) {
    std::swap(place.core, schedule.subchains[other].core);
  } else {
    const std::vector<int> cores = cores_for_priorities(schedule);
    place.core = cores[random.below(cores.size())];
  }
}

// Those that no pipeline has.
std::vector<int> Moves::cores_for_priorities(const Schedule& schedule) const {
  std::vector<int> cores;
  for (int core = 0; core < cores_; ++core) {
    const bool owned = std::any_of(schedule.pipelines.begin(), schedule.pipelines.end(), [&](const auto& pipeline) {
      return std::find(pipeline.cores.begin(), pipeline.cores.end(), core) != pipeline.cores.end();
    });
    if (!owned) cores.push_back(core);
  }
  return cores;
}

// A pipeline ends: its subchain stays on the first of its cores, above all others, one run right after the other. Or
// one begins, or has another number of cores from then on.
void Moves::change_cores(Schedule& schedule, std::size_t subchain, Random& random) const {
  Place& place = schedule.subchains[subchain];
  if (place.form != trial::Form::kPipeline) return give_cores(schedule, subchain, random);
  std::erase_if(schedule.pipelines, [&](const auto& each) { return each.subchain.index() == subchain; });
  int highest = 0;
  for (const Place& each : schedule.subchains) highest = std::max(highest, each.priority);
  place = {.core = place.core, .priority = highest + 1, .period = limits_[subchain].shortest};
  if (!limits_[subchain].exact) place.pause = Nanos{0};
  if (random.once_in(2)) give_cores(schedule, subchain, random);
}

// Its own and some of the same kind. Whoever was there goes elsewhere; if there is no core left for them, it has none.
void Moves::give_cores(Schedule& schedule, std::size_t subchain, Random& random) const {
  Place& place = schedule.subchains[subchain];
  std::vector<int> others;
  for (const int core : cores_for_priorities(schedule)) {
    if (core != place.core && app_.kind_of(core) == app_.kind_of(place.core)) others.push_back(core);
  }
  const auto most = static_cast<std::size_t>(pipelines_.most_cores(SubchainId(subchain)) - 1);
  if (others.empty() || most == 0) return;
  std::vector<int> cores{place.core};
  for (std::size_t more = 1 + random.below(std::min(most, others.size())); more > 0; --more) {
    const auto chosen = others.begin() + static_cast<std::ptrdiff_t>(random.below(others.size()));
    cores.push_back(*chosen);
    others.erase(chosen);
  }
  std::sort(cores.begin(), cores.end());
  std::optional<trial::Pipeline> pipeline = pipelines_.on(SubchainId(subchain), std::move(cores));
  if (!pipeline) return;
  const Schedule before = schedule;
  place = {.form = trial::Form::kPipeline, .core = pipeline->cores.front()};
  schedule.pipelines.push_back(*std::move(pipeline));
  const std::vector<int>& taken = schedule.pipelines.back().cores;
  const std::vector<int> left = cores_for_priorities(schedule);
  for (Place& each : schedule.subchains) {
    if (each.form != trial::Form::kPriority || std::find(taken.begin(), taken.end(), each.core) == taken.end())
      continue;
    if (left.empty()) {
      schedule = before;
      return;
    }
    each.core = left[random.below(left.size())];
  }
}

void Moves::change_pause(Place& place, std::size_t subchain, Random& random) const {
  if (limits_[subchain].exact) return;
  place.after.reset();
  place.phase = Nanos{0};
  if (place.pause) {
    place.period = std::max(to_nanos(Millis{1.5 * cost_[subchain]}) + *place.pause, limits_[subchain].shortest);
    place.pause.reset();
  } else {
    place.period = limits_[subchain].shortest;
    place.pause = to_nanos(Millis{0.4 * cost_[subchain] * random.fraction()});
  }
}

void Moves::change_trigger(Schedule& schedule, std::size_t subchain, Random& random) const {
  if (limits_[subchain].exact || schedule.subchains.size() < 2) return;
  Place& place = schedule.subchains[subchain];
  if (place.after && random.once_in(2)) {
    place.after.reset();
    const double cost = cost_[subchain] * (2.0 + 10.0 * random.fraction());
    place.period = std::max(to_nanos(Millis{cost}), limits_[subchain].shortest);
    return;
  }
  const Place before = place;
  place.pause.reset();
  place.phase = Nanos{0};
  const int every = random.once_in(3) ? 1 + static_cast<int>(random.below(kMostOutputs)) : 1;
  const std::size_t feeder = random.below(schedule.subchains.size());
  place.after = plan::After{SubchainId(feeder), every};
  // Some less than outputs are likely to be apart.
  const double apart = every * std::max(to_millis(schedule.subchains[feeder].period).count(), 1.5 * cost_[feeder]);
  place.period = std::max(to_nanos(Millis{kHeldApart * apart}), limits_[subchain].shortest);
  if (has_cycle(schedule)) place = before;
}

}  // namespace ctn::planner
