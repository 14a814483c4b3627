// What the formulas say of promises (plan/promise.h), bounded by the line.
#include <algorithm>

#include "dispatch/subchain_trigger.h"
#include "model/unscheduled.h"
#include "plan/limits.h"
#include "plan/predict.h"
#include "planner/surrogate.h"

namespace ctn::planner {

double Surrogate::promised_lateness(const plan::After& after) const {
  if (const NodeId* const node = after.node()) return arrivals_[node->index()].late;
  const std::size_t leader = after.subchain()->index();
  return std::max(timings_[leader].promised_execution, outputs_late(leader));
}

// By how much more than on average its outputs are apart, at most, for output periods (model::outputs_late()).
double Surrogate::outputs_late(std::size_t subchain) const {
  const model::LeftOut& left_out = left_out_[subchain];
  if (left_out.runs == 0.0) return 0.0;
  const Timing& timing = timings_[subchain];
  const double runs = timing.promised_period * runs_per_output_[subchain];
  const double most = left_out.most(Millis{timing.promised_execution}).count();
  return std::max(runs + most - std::max(runs, output_period_[subchain]), 0.0);
}

// What two outputs of an element may be apart beyond its runs; `followed`: beyond the period of the one that follows
// it.
double Surrogate::left_out(const Element& element, bool followed) const {
  if (element.left_out.runs == 0.0) return 0.0;
  if (element.subchain) {
    const std::size_t i = element.subchain->index();
    return followed ? outputs_late(i) : element.left_out.most(Millis{timings_[i].promised_execution}).count();
  }
  const double most = element.left_out.most(Millis{promised_run(element)}).count();
  return followed ? element.period + most - std::max(element.period, element.output_period) : most;
}

// How far apart the triggers of a follower are on average, where its leader has the period that it is promised: its own
// run is in one of that one's runs from one trigger to the next (plan/promise.cpp).
double Surrogate::promised_apart(const trial::Schedule& schedule, std::size_t subchain) {
  const trial::Place& place = schedule.subchains[subchain];
  const double runs = place.after->every * runs_per_output(*place.after);
  if (const NodeId* const node = place.after->node()) return runs * arrivals_[node->index()].apart;
  const std::size_t leader = place.after->subchain()->index();
  const Timing& timing = timings_[leader];
  const double apart = std::max(timing.promised_period, output_period_[leader]);
  const trial::Place& led_by = schedule.subchains[leader];
  const bool meets_once = led_by.pause && turns_of(schedule, subchain, led_by.priority) == 1 &&
                          planned_waits_[leader] == 0.0 && promised_blocking(schedule, leader) == 0.0 &&
                          !excludes_unscheduled_[leader] &&
                          timing.promised_execution < to_millis(plan::silence_limit(place.period)).count();
  if (!meets_once) return runs * apart;
  const double run = timing.promised_execution - timings_[subchain].planned * timing.promised_stretch;
  const double alone = std::max(to_millis(led_by.period).count(), run + to_millis(*led_by.pause).count());
  return std::max(apart + (runs - 1.0) * alone, runs * output_period_[leader]);
}

// From one trigger to the next, at most (plan/predict.cpp): a subchain that is triggered by outputs may have one that
// is late, and the next as early as runs cost nothing.
double Surrogate::promised_gap(const trial::Schedule& schedule, std::size_t subchain) const {
  double gap = timings_[subchain].promised_period;
  const std::optional<plan::After>* after = &schedule.subchains[subchain].after;
  while (*after) {
    if (const NodeId* const node = (*after)->node()) return gap + arrivals_[node->index()].late;
    const std::size_t leader = (*after)->subchain()->index();
    const trial::Place& place = schedule.subchains[leader];
    const double run = timings_[leader].promised_execution;
    const double late = outputs_late(leader);
    if (place.pause) {
      const double held = std::clamp(to_millis((*after)->every * (place.period - *place.pause)).count(), 0.0, run);
      return gap + std::max(held, late);
    }
    gap += std::max(run, late);
    after = &place.after;
  }
  return gap;
}

// Whether outputs may come so close that it is triggered by its period, later than by each of them that counts.
bool Surrogate::may_be_held_back(const trial::Schedule& schedule, std::size_t subchain) const {
  const trial::Place& place = schedule.subchains[subchain];
  const plan::After& after = *place.after;
  double apart = 0.0;
  if (const NodeId* const node = after.node()) {
    apart = arrivals_[node->index()].apart;
    const double late = arrivals_[node->index()].late;
    const double held = to_millis(plan::held_apart(place.period)).count();
    if (std::max(timings_[subchain].promised_execution, held) > after.every * apart - late) return true;
  } else {
    const std::size_t leader = after.subchain()->index();
    apart = to_millis(schedule.subchains[leader].period).count();
    for (const trial::Pipeline& pipeline : schedule.pipelines) {
      if (pipeline.subchain.index() != leader) continue;
      const bool elastic = pipeline.pacing.after_completion > Nanos{0};
      apart = elastic ? plan::period_limits(app_.graph, SubchainId(leader)).min.count() : timings_[leader].period;
    }
  }
  return to_millis(place.period).count() > after.every * apart * (1.0 + plan::kTolerance);
}

// What a run costs with as many items as it is promised to have at most (plan/batches.h).
void Surrogate::plan_batches(const trial::Place& place, std::size_t subchain) {
  if (batches_[subchain].empty()) return;
  Timing& timing = timings_[subchain];
  const std::size_t kind = kind_of(place.core);
  const double held_up = std::max(timing.promised_execution - timing.planned * usable_, 0.0);
  const Millis window{std::max(timing.promised_period, timing.period) + held_up};
  timing.planned = planned_[kind][subchain];
  for (const Batches& batches : batches_[subchain]) {
    const double items =
        model::max_items(batches.inputs, window, [&](SubchainId id) { return Millis{timings_[id.index()].spacing}; });
    timing.planned += batches.per_item[kind] * items / usable_;
  }
}

// Whether its triggers may come early by as much as its own runs make others late: where it is not below all that
// trigger it. Response time and jitter then grow with one another. Only the spacing that it keeps bounds both.
bool Surrogate::may_come_ever_earlier(const trial::Schedule& schedule, std::size_t subchain) {
  const trial::Place* place = &schedule.subchains[subchain];
  while (place->after && place->after->subchain() != nullptr) {
    const trial::Place& leader = schedule.subchains[place->after->subchain()->index()];
    if (leader.core != place->core || leader.priority < place->priority) return true;
    place = &leader;
  }
  return false;
}

// How often it may come, at most, while a run is pending that has that priority on its core, where it goes back to
// outputs of one that is not above that (plan/promise.h); 0: it does not.
int Surrogate::turns_of(const trial::Schedule& schedule, std::size_t subchain, int priority) const {
  const trial::Place* place = &schedule.subchains[subchain];
  const int core = place->core;
  for (int turns = 1; place->after && place->after->subchain() != nullptr; ++turns) {
    if (planned_waits_[subchain] > 0.0) return 0;
    subchain = place->after->subchain()->index();
    place = &schedule.subchains[subchain];
    if (place->form != trial::Form::kPriority || place->core != core) return 0;
    if (place->priority <= priority) return turns;
  }
  return 0;
}

// For how long exclusive groups may keep it from going on (plan/promise.h). None: one that it shares a group with is on
// another core, where the formulas promise nothing.
std::optional<double> Surrogate::promised_blocking(const trial::Schedule& schedule, std::size_t subchain) const {
  const trial::Place& place = schedule.subchains[subchain];
  const std::size_t kind = kind_of(place.core);
  const std::size_t nodes = app_.graph.subchain(SubchainId(subchain)).nodes.size();
  if (exclusions_.empty()) return 0.0;
  const double times = planned_waits_[subchain] > 0.0 || kept_away_[subchain] ? 1.0 + static_cast<double>(nodes) : 1.0;
  double sum = 0.0;
  for (const Exclusion& exclusion : exclusions_) {
    bool wanted = exclusion.has_unscheduled;
    bool apart = false;
    int own = 0;
    double longest = 0.0;
    for (const Exclusion::Part& part : exclusion.parts) {
      const trial::Place& other = schedule.subchains[part.subchain];
      const bool here = other.form == trial::Form::kPriority && other.core == place.core;
      if (part.subchain == subchain) ++own;
      apart = apart || !here;
      wanted = wanted || (here && other.priority >= place.priority);
      if (here && other.priority < place.priority) longest = std::max(longest, part.hold[kind]);
    }
    if (own > 0 && apart) return std::nullopt;
    if (wanted) sum += times * longest;
  }
  return sum;
}

// Where no time is left, a promise is out of reach: it is taken to be so long that no bound holds.
void Surrogate::promise_cores(const trial::Schedule& schedule) {
  promised_ = true;
  std::size_t first = 0;
  for (std::size_t at = 0; at < order_.size(); ++at) {
    if (schedule.subchains[order_[at]].core != schedule.subchains[order_[first]].core) first = at;
    promise_subchain(schedule, order_[at], first, at);
  }
}

// What those in order_[first, last), which are above it on its core, use of the core. `in_turn`: those that a run of
// it keeps from coming again (turns_of()) use it so often at once, unless the run lasts for `silence`.
Surrogate::UsedAbove Surrogate::used_above(const trial::Schedule& schedule, std::size_t subchain, std::size_t first,
                                           std::size_t last, bool in_turn) const {
  UsedAbove used;
  for (std::size_t above = first; above < last; ++above) {
    const std::size_t j = order_[above];
    const Timing& other = timings_[j];
    const int turns = in_turn ? turns_of(schedule, j, schedule.subchains[subchain].priority) : 0;
    if (turns > 0) {
      used.soon.at_once += turns * other.planned;
      used.on_average.at_once += turns * other.planned;
      used.silence = std::min(used.silence, to_millis(plan::silence_limit(schedule.subchains[j].period)).count());
      continue;
    }
    used.soon.at_once += other.promised_soon.at_once * other.planned;
    used.soon.rate += other.promised_soon.rate * other.planned;
    used.on_average.at_once += other.promised_on_average.at_once * other.planned;
    used.on_average.rate += other.promised_on_average.rate * other.planned;
    used.if_held += other.held_rate * other.planned;
  }
  return used;
}

// How often it may come at most, for those below it: early by the jitter, or as often as its period lets it.
void Surrogate::promise_triggers(const trial::Place& place, std::size_t subchain, double jitter) {
  Timing& timing = timings_[subchain];
  const double spacing = timing.spacing;
  // What a run that waits leaves undone comes close to the next one (plan/promise.h).
  const bool leaves = timing.planned_waits > 0.0 || (!kept_away_.empty() && kept_away_[subchain]);
  const double carried = leaves ? timing.promised_execution - timing.planned : 0.0;
  const plan::TriggersKnown known{
      .spacing = spacing, .sooner = jitter, .carried = carried, .held = place.after ? place.period : Nanos{0}};
  constexpr double kManyRuns = 8.0;
  timing.promised_soon = plan::trigger_line(known, spacing);
  timing.promised_on_average = plan::trigger_line(known, kManyRuns * spacing);
}

// With those above it on its core in order_[first, last).
void Surrogate::promise_subchain(const trial::Schedule& schedule, std::size_t i, std::size_t first, std::size_t last) {
  constexpr double kOutOfReach = 1e9;
  constexpr double kMinHeld = 1e-6;
  const trial::Place& place = schedule.subchains[i];
  plan_batches(place, i);
  Timing& timing = timings_[i];
  const std::optional<double> blocked = promised_blocking(schedule, i);
  promised_ = promised_ && blocked;
  const double alone = timing.planned + timing.planned_waits + blocked.value_or(0.0);
  const auto promise_execution = [&](bool in_turn) {
    UsedAbove used = used_above(schedule, i, first, last, in_turn);
    used.if_held += unscheduled_[i].rate;
    for (Line* const line : {&used.soon, &used.on_average}) {
      line->at_once += unscheduled_[i].at_once;
      line->rate += unscheduled_[i].rate;
    }
    timing.promised_stretch = 0.0;
    timing.promised_execution = kOutOfReach;
    for (const Line& line : {used.soon, used.on_average}) {
      if (line.rate >= kNothingLeft) continue;
      const double execution = (alone + line.at_once) / (1.0 - line.rate);
      if (execution >= timing.promised_execution) continue;
      timing.promised_execution = execution;
      timing.promised_stretch = 1.0 / (1.0 - line.rate);
    }
    return used;
  };
  const bool may_be_in_turn = planned_waits_[i] == 0.0 && blocked == 0.0 && !excludes_unscheduled_[i];
  UsedAbove used = promise_execution(may_be_in_turn);
  if (timing.promised_execution >= used.silence) used = promise_execution(false);
  promised_ = promised_ && used.if_held < kNothingLeft;
  double spacing = to_millis(place.period).count();
  if (place.pause) spacing = std::max(spacing, timing.planned + to_millis(*place.pause).count());
  double usual = spacing;
  double jitter = 0.0;  // where its period holds it back, one trigger comes sooner than that
  if (place.after) {
    const double apart = outputs_apart(schedule, i);
    if (spacing > apart * (1.0 + plan::kTolerance)) jitter = spacing;
    spacing = std::max(spacing, apart);
    usual = std::max(usual, promised_apart(schedule, i));
  }
  const double pause = place.pause ? to_millis(*place.pause).count() : 0.0;
  timing.promised_period = std::max(usual, timing.promised_execution + pause);
  timing.spacing = std::max(spacing, to_millis(dispatch::kShortestPeriod).count());
  if (!place.pause) jitter += std::max(0.0, timing.promised_execution - timing.spacing);
  if (place.after) jitter += promised_lateness(*place.after);
  promise_triggers(place, i, jitter);
  timing.held_rate = may_come_ever_earlier(schedule, i) ? 1.0 / std::max(to_millis(place.period).count(), kMinHeld)
                                                        : timing.promised_on_average.rate;
}

// What unscheduled nodes may wait for depends on which core those are on that may have their exclusive groups.
void Surrogate::know_unscheduled(const trial::Schedule& schedule) {
  if (tables_.empty()) return;
  std::vector<int> cores;
  cores.reserve(schedule.subchains.size());
  for (const trial::Place& place : schedule.subchains) cores.push_back(place.core);
  unscheduled_waits_ = model::unscheduled_waits(app_, tables_, cores, static_cast<std::size_t>(schedule.cores));
  for (std::size_t i = 0; i < arrivals_.size(); ++i) {
    if (!app_.graph.node(NodeId(i)).unscheduled) continue;
    arrivals_[i].late =
        model::output_lateness(app_.graph, tables_.front(), unscheduled_waits_, NodeId(i), 1.0 - usable_).count();
  }
  for (std::size_t i = 0; i < unscheduled_.size(); ++i) {
    const trial::Place& place = schedule.subchains[i];
    std::optional<NodeId> leader;  // that triggers it right away
    if (place.after && place.after->node() != nullptr) {
      const Arrivals& arrivals = arrivals_[place.after->node()->index()];
      const double closest = place.after->every * arrivals.apart - arrivals.late;
      if (to_millis(place.period).count() <= closest) leader = *place.after->node();
    }
    unscheduled_[i] = plan::line_of(model::unscheduled_loads(app_, tables_, unscheduled_waits_, SubchainId(i),
                                                             kind_of(cores[i]), 1.0 - usable_, leader));
  }
}

// Of an unscheduled node, or of an external one that ticks.
double Surrogate::promised_run(const Element& element) const {
  return element.planned + model::unscheduled_wait_of(unscheduled_waits_, element.node).count();
}

// The same, of what it does not follow: an unscheduled follower runs as late as outputs of its own leader come.
double Surrogate::promised_wait(const Element& element) const {
  const double late = element.leader ? arrivals_[element.leader->index()].late : 0.0;
  return std::max(element.period + late, promised_run(element));
}

void Surrogate::promise(const trial::Schedule& schedule, Estimate& estimate) {
  know_unscheduled(schedule);
  for (int round = 1; round < rounds_; ++round) promise_cores(schedule);
  estimate.promised = promised_;
  for (const Term& term : terms_) {
    if (term.max > 0.0) {
      estimate.relax = std::max(estimate.relax, total_of(schedule, term, Basis::kPromised) / term.max);
    }
  }
  for (const AskedRate& rate : exact_rates_) {
    // To the nanosecond, which is what schedules have.
    constexpr double kRounding = 1e-6;
    estimate.exact_missed =
        estimate.exact_missed || timings_[rate.subchain.index()].promised_period > rate.period + kRounding;
  }
  for (const AskedRate& rate : min_rates_) {
    estimate.relax = std::max(estimate.relax, timings_[rate.subchain.index()].promised_period / rate.period);
  }
}

}  // namespace ctn::planner
