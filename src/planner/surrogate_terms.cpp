// What a term of the objective comes to, by what subchains' periods and executions come to.
#include <algorithm>
#include <cmath>

#include "model/batches.h"
#include "model/formulas.h"
#include "plan/limits.h"
#include "plan/predict.h"
#include "planner/surrogate.h"

namespace ctn::planner {

// Of one that keeps a phase to the clock: what is left until the next tick when its run ends, on average over long and
// short runs, and what part of the ticks finds something new. Of one that comes at each tick, what ends too late for
// one is overwritten by what is in time for the next, or shown in its place.
const Surrogate::AtTicks* Surrogate::at_ticks(const trial::Schedule& schedule, const Element& before,
                                              const Element& element) {
  if (element.subchain || !before.subchain) return nullptr;
  const trial::Place& place = schedule.subchains[before.subchain->index()];
  if (place.clock != element.node) return nullptr;
  Timing& timing = timings_[before.subchain->index()];
  if (timing.at_ticks) return &*timing.at_ticks;
  const RunSpread& spread = spread_[kind_of(place.core)][before.subchain->index()];
  const double end = to_millis(place.phase).count() + timing.execution + in_time_;
  const auto ticks_of = [&](double more) { return (end + more * timing.stretch) / element.period; };
  double nothing_new = 1.0;
  double of_this_tick = 0.0;  // what part of the runs
  double this_tick = std::floor(ticks_of(spread.parts().front()));
  const double wait = spread.mean_of([&](double more) {  // in ascending order
    const double ticks = ticks_of(more);
    const double tick = std::floor(ticks);
    if (tick > this_tick) {
      nothing_new *= 1.0 - of_this_tick;
      of_this_tick = 0.0;
      this_tick = tick;
    }
    of_this_tick += 1.0 / static_cast<double>(RunSpread::kParts);
    return (1.0 - (ticks - tick)) * element.period + in_time_;
  });
  nothing_new *= 1.0 - of_this_tick;
  const bool at_each_tick = timing.period <= element.period * (1.0 + plan::kTolerance);
  timing.at_ticks = AtTicks{wait, at_each_tick ? 1.0 - nothing_new : 1.0};
  return &*timing.at_ticks;
}

// Of one that keeps a phase to the clock that began its input: how old the last output is on average when a run begins.
std::optional<double> Surrogate::wait_since_tick(const trial::Schedule& schedule, const Ticked& begun,
                                                 const Element& element) const {
  if (!element.subchain) return std::nullopt;
  const trial::Place& place = schedule.subchains[element.subchain->index()];
  if (place.clock != begun.clock) return std::nullopt;
  const std::optional<TickCount> ticks = plan::ticks_of(to_millis(place.period), Millis{begun.period});
  if (!ticks) return std::nullopt;
  const double apart = begun.period * ticks->ticks / ticks->parts;
  double sum = 0.0;
  for (int run = 0; run < ticks->parts; ++run) {
    const double since = std::fmod(to_millis(place.phase).count() + run * apart - begun.passed, begun.period);
    sum += since < 0.0 ? since + begun.period : since;
  }
  return sum / ticks->parts;
}

// Arrivals come more often than it may run: it does not run right after the one that it takes. The outputs of another
// subchain do so only until the search has found periods that go together.
bool Surrogate::is_held_back(const trial::Schedule& schedule, std::size_t subchain) const {
  const trial::Place& place = schedule.subchains[subchain];
  if (place.after->node() == nullptr) return false;
  const double apart = outputs_apart(schedule, subchain) * runs_per_output(*place.after);
  return to_millis(place.period).count() > apart * (1.0 + plan::kTolerance);
}

// Any, unless both keep phases to one clock (model::InStep). What is taken is the newest, which is no older on
// average than half of what outputs are apart, if each of them brings something new.
double Surrogate::wait_between(const trial::Schedule& schedule, SubchainId one, SubchainId other, bool all_new,
                               Basis basis) const {
  const bool usual = basis == Basis::kUsual;
  const Timing& timing = timings_[one.index()];
  const Timing& next = timings_[other.index()];
  double any = usual ? next.wait : promised_gap(schedule, other.index());
  if (usual && all_new) any = std::min(any, timing.wait * runs_per_output_[one.index()]);
  const trial::Place& first = schedule.subchains[one.index()];
  const trial::Place& second = schedule.subchains[other.index()];
  const auto by_phase = [](const trial::Place& place) {
    return place.form == trial::Form::kPriority && !place.pause && !place.after;
  };
  if (!by_phase(first) || !by_phase(second) || first.clock != second.clock) return any;
  const auto misses = [&](const Timing& of, const trial::Place& place) {
    return (usual ? of.period : of.promised_period) > to_millis(place.period).count() * (1.0 + plan::kTolerance);
  };
  if (misses(timing, first) || misses(next, second)) return any;
  const bool below = first.core == second.core && second.priority < first.priority && waits_[one.index()] == 0.0;
  const auto step = model::InStep::of({first.phase, first.period}, {second.phase, second.period});
  if (!step) return any;
  const auto wait = step->wait(Millis{usual ? timing.execution : timing.promised_execution}, below);
  // Whether each run brings something new is told of the first element alone.
  const double older = all_new ? 0.0 : wait.more.count();
  if (!usual) return wait.last.count() + older;
  const RunSpread& spread = spread_[kind_of(first.core)][one.index()];
  const double last = spread.mean_of(
      [&](double more) { return step->wait(Millis{timing.execution + more * timing.stretch}, below).last.count(); });
  return last + older / 2.0;
}

// Runs that find no input do not count: fewer, the closer together they come.
double Surrogate::counted_period(const Term& term, const trial::Place& place) const {
  const Timing& timing = timings_[term.of->index()];
  if (term.inputs.empty()) return timing.period;
  const auto period_of = [&](SubchainId id) { return Millis{timings_[id.index()].period}; };
  const double usual = timing.period - timing.late;
  const auto items_in = [&](double window) { return model::mean_items(term.inputs, Millis{window}, period_of); };
  if (!place.pause) return timing.period / RunSpread::part_with_input(items_in(usual));
  const RunSpread& spread = spread_[kind_of(place.core)][term.of->index()];
  return timing.period / spread.part_with_input([&](double more) { return items_in(usual + more * timing.stretch); });
}

double Surrogate::total_of(const trial::Schedule& schedule, const Term& term, Basis basis) {
  const bool usual = basis == Basis::kUsual;
  const auto period_of = [&](const Timing& timing) { return usual ? timing.period : timing.promised_period; };
  if (term.of) {
    const double period =
        usual ? counted_period(term, schedule.subchains[term.of->index()]) : timings_[term.of->index()].promised_period;
    return std::max(period, term.output_period);
  }
  if (term.elements.empty()) return term.fixed_period;
  double latency = 0.0;
  double period = 0.0;
  const Element* before = nullptr;
  double period_before = 0.0;
  double first_late = 0.0;
  double left_out = 0.0;
  bool in_line = true;  // all since the first follow the one before
  std::optional<Ticked> begun;
  for (const Element& element : term.elements) {
    const Timing* const timing = element.subchain ? &timings_[element.subchain->index()] : nullptr;
    bool follows = element.follows;
    if (timing != nullptr && before != nullptr) {
      const auto& after = schedule.subchains[element.subchain->index()].after;
      if (after) {
        follows = before->subchain ? after->leader == plan::Leader(*before->subchain)
                                   : after->leader == plan::Leader(before->node);
        const std::size_t i = element.subchain->index();
        follows = follows && !(usual ? is_held_back(schedule, i) : may_be_held_back(schedule, i));
      }
    }
    double own = timing == nullptr ? element.period : period_of(*timing);
    if (before == nullptr && !usual) {
      first_late =
          (timing != nullptr ? promised_gap(schedule, element.subchain->index()) : promised_wait(element)) - own;
    }
    if (before != nullptr && follows && !in_line && !usual) latency += std::max(own - period_before, 0.0);
    if (before != nullptr && !follows) {
      const bool all_new = usual ? in_line : before == &term.elements.front();
      in_line = false;
      double wait = usual ? element.period / 2.0 : promised_wait(element);
      if (timing != nullptr && before->subchain) {
        wait = wait_between(schedule, *before->subchain, *element.subchain, all_new, basis);
      } else if (timing != nullptr) {
        wait = usual ? timing->wait : promised_gap(schedule, element.subchain->index());
        if (usual && all_new && before->period > 0.0) wait = std::min(wait, before->period / 2.0);
      }
      if (usual) {
        const std::optional<double> since = begun ? wait_since_tick(schedule, *begun, element) : std::nullopt;
        const AtTicks* const ticks = since ? nullptr : at_ticks(schedule, *before, element);
        if (since) wait = *since;
        if (ticks != nullptr) {
          wait = ticks->wait;
          own /= ticks->with_news;
        }
      }
      latency += wait;
    }
    if (before == nullptr && !element.subchain && app_.graph.node(element.node).has_clock()) {
      begun = Ticked{element.node, element.period, 0.0};
    } else if (element.subchain || !element.follows) {
      begun.reset();
    }
    if (begun) begun->passed += element.cost;
    if (timing == nullptr) {
      latency += usual ? element.cost : promised_run(element);
    } else if (!usual) {
      latency += timing->promised_execution;
    } else {
      latency += before == nullptr ? timing->from_begin : timing->execution;
    }
    if (!usual && before != nullptr) left_out += this->left_out(*before, follows);
    period = std::max(period, own * element.runs_per_output);
    if (usual) period = std::max(period, element.output_period);
    period_before = own;
    before = &element;
  }
  if (!usual) left_out += this->left_out(*before, false);
  return latency + first_late + left_out + period;
}

}  // namespace ctn::planner
