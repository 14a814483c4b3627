#include "planner/surrogate.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "model/unscheduled.h"
#include "plan/limits.h"
#include "planner/clock_phases.h"

namespace ctn::planner {
namespace {

// Periods follow from one another (pauses from executions, triggers by outputs from periods, batches from periods of
// others): so often until they are good enough for a guess, or sooner if they change by less than this part.
constexpr int kRounds = 3;
constexpr int kRoundsWithBatches = 12;
constexpr double kSettled = 1e-3;

// Of a node that no subchain has; 0: it has none.
double own_period(const graph::Graph& graph, NodeId node) {
  const auto& period = graph.node(node).period;
  return period ? to_millis(*period).count() : 0.0;
}

// How far apart outputs of the subchain's nodes up to `last` are at least, since one of them gives none where it finds
// nothing new, and finds but ticks of external clocks; 0: they may be as close as runs are.
double apart_by_clocks(const graph::Graph& graph, const model::CostTable& costs, const graph::Subchain& subchain,
                       NodeId last) {
  constexpr double kMostlyIdle = 0.5;
  double apart = 0.0;
  for (const NodeId node : subchain.nodes) {
    const std::vector<NodeId>& inputs = graph.node(node).predecessors;
    if (costs.idle(node).part > kMostlyIdle && !inputs.empty()) {
      double ticks = kInfinity;
      for (const NodeId from : inputs) {
        ticks = std::min(ticks, graph.node(from).is_external_clock() ? own_period(graph, from) : 0.0);
      }
      apart = std::max(apart, ticks);
    }
    if (node == last) break;
  }
  return apart;
}

// What part of its time on one thread a run takes on so many, from 1 to as many as are of use.
std::vector<double> parts_by_threads(const graph::Graph& graph, const model::CostTable& costs, SubchainId id) {
  const std::vector<NodeId>& nodes = graph.subchain(id).nodes;
  const int max = costs.max_useful_threads(graph, id);
  const Millis alone = costs.subchain_total(graph, id);
  std::vector<double> parts;
  for (int threads = 1; threads <= max; ++threads) {
    Millis elapsed{0};
    for (const NodeId node : nodes) elapsed += costs[node].with_threads(threads, graph.node(node).max_threads);
    parts.push_back(alone > Millis{0} ? elapsed / alone : 1.0);
  }
  return parts;
}

}  // namespace

Surrogate::Surrogate(const graph::App& app, const trial::Samples& samples, const model::CostTable& planned,
                     double slack, const trial::Overheads& machine)
    : app_(app),
      usable_(1.0 - slack),
      in_time_(to_millis(kBeforeTicks + machine.timer_latency + machine.timer_jitter).count()),
      batches_(app.graph.subchains().size()),
      rounds_(planned.has_batches() ? kRoundsWithBatches : kRounds),
      timings_(app.graph.subchains().size()) {
  const std::vector<model::CostTable> tables = model::costs_by_kind(app, planned);
  know_costs(samples, tables, machine);
  know_outputs_and_waits(samples, planned, tables);
  know_arrivals(planned, tables.front(), slack);
  const double run = to_millis(machine.run + machine.context_switch).count();
  for (const graph::Term& term : app.objective) know_term(term, samples, planned, run);
  know_asked_rates();
  know_inputs(planned);
  const auto& nodes = app.graph.nodes();
  unscheduled_.resize(timings_.size());
  excludes_unscheduled_.resize(timings_.size());
  if (std::any_of(nodes.begin(), nodes.end(), [](const auto& node) { return node.unscheduled; })) tables_ = tables;
  if (!app.exclusive.empty()) know_exclusions(tables);
}

void Surrogate::know_exclusions(const std::vector<model::CostTable>& tables) {
  kept_away_.resize(timings_.size());
  for (std::size_t i = 0; i < timings_.size(); ++i) {
    for (const NodeId node : app_.graph.subchain(SubchainId(i)).nodes) {
      const std::optional<std::size_t> group = app_.graph.node(node).exclusive;
      if (!group) continue;
      const std::vector<NodeId>& others = app_.exclusive[*group].nodes;
      kept_away_[i] = kept_away_[i] || std::any_of(others.begin(), others.end(), [&](NodeId other) {
                        const std::optional<SubchainId> of = app_.graph.node(other).subchain;
                        return of != SubchainId(i) && (!of || tables.front().wait(other) > Millis{0});
                      });
    }
  }
  for (const graph::ExclusiveGroup& group : app_.exclusive) {
    Exclusion& exclusion = exclusions_.emplace_back();
    for (const NodeId node : group.nodes) {
      std::vector<double> holds;
      for (const model::CostTable& table : tables) {
        holds.push_back(table[node].single_thread().count() / usable_ + table.wait(node).count());
      }
      if (const std::optional<SubchainId> of = app_.graph.node(node).subchain) {
        exclusion.parts.push_back({of->index(), std::move(holds)});
        continue;
      }
      exclusion.has_unscheduled = true;
    }
    if (!exclusion.has_unscheduled) continue;
    for (const Exclusion::Part& part : exclusion.parts) excludes_unscheduled_[part.subchain] = true;
  }
}

void Surrogate::know_costs(const trial::Samples& samples, const std::vector<model::CostTable>& tables,
                           const trial::Overheads& machine) {
  const double run = to_millis(machine.run + machine.context_switch).count();
  const double trigger = to_millis(machine.dispatch_timer + machine.context_switch).count();
  for (std::size_t kind = 0; kind < app_.kinds(); ++kind) {
    std::vector<double>& means = mean_.emplace_back();
    std::vector<double>& squares = square_.emplace_back();
    std::vector<double>& percentiles = planned_.emplace_back();
    std::vector<std::vector<double>>& parts = parts_on_threads_.emplace_back();
    std::vector<RunSpread>& spreads = spread_.emplace_back();
    for (std::size_t i = 0; i < app_.graph.subchains().size(); ++i) {
      double mean = trigger;
      double variance = 0.0;
      for (const NodeId node : app_.graph.subchain(SubchainId(i)).nodes) {
        const trial::Samples::Moments moments = samples.moments(node, kind);
        mean += run + moments.mean;
        variance += moments.variance;
      }
      means.push_back(mean);
      squares.push_back(mean * mean + variance);
      spreads.push_back(RunSpread::of(app_.graph.subchain(SubchainId(i)), samples, kind));
      percentiles.push_back(tables[kind].subchain_total(app_.graph, SubchainId(i)).count() / usable_);
      parts.push_back(parts_by_threads(app_.graph, tables[kind], SubchainId(i)));
    }
  }
}

void Surrogate::know_outputs_and_waits(const trial::Samples& samples, const model::CostTable& planned,
                                       const std::vector<model::CostTable>& tables) {
  for (const graph::Subchain& subchain : app_.graph.subchains()) {
    output_period_.push_back(std::max(to_millis(app_.graph.output_period_up_to(subchain.tail())).count(),
                                      apart_by_clocks(app_.graph, planned, subchain, subchain.tail())));
    runs_per_output_.push_back(planned.runs_per_output(subchain, subchain.tail()));
    left_out_.push_back(model::left_out(app_.graph, planned, subchain, subchain.tail()));
    double& waits = waits_.emplace_back(0.0);
    double& parts = parts_.emplace_back(1.0);
    double& planned_waits = planned_waits_.emplace_back(0.0);
    for (const NodeId node : subchain.nodes) {
      if (planned.has_batches(node)) {
        Batches& batches = batches_[waits_.size() - 1].emplace_back();
        batches.inputs = model::batch_inputs(app_.graph, planned, node);
        for (const model::CostTable& table : tables) batches.per_item.push_back(table[node].per_item().count());
      }
      const trial::Samples::Waits found = samples.mean_wait(node);
      waits += found.mean;
      parts += found.part;
      planned_waits += planned.wait(node).count();
    }
  }
}

void Surrogate::know_arrivals(const model::CostTable& planned, const model::CostTable& costs, double slack) {
  for (std::size_t i = 0; i < app_.graph.nodes().size(); ++i) {
    Arrivals& arrivals = arrivals_.emplace_back();
    const graph::Node& node = app_.graph.nodes()[i];
    if (!node.unscheduled) continue;
    arrivals.apart = to_millis(node.outputs_apart()).count();
    arrivals.late = model::output_lateness(app_.graph, costs, {}, NodeId(i), slack).count();
    arrivals.runs_per_output = planned.runs_per_output(NodeId(i));
  }
}

// `run`: what the machine adds to one.
void Surrogate::know_term(const graph::Term& term, const trial::Samples& samples, const model::CostTable& planned,
                          double run) {
  Term& known = terms_.emplace_back();
  known.weight = term.weight;
  if (term.metric == graph::Metric::kPeriod) {
    known.of = app_.graph.node(term.path.front()).subchain;
    if (!known.of) known.fixed_period = own_period(app_.graph, term.path.front());
    const NodeId node = term.path.front();
    known.output_period = to_millis(app_.graph.output_period_before(node)).count();
    if (known.of && app_.graph.may_run_empty(node)) known.inputs = model::batch_inputs(app_.graph, planned, node);
    return;
  }
  if (term.max) known.max = to_millis(*term.max).count();
  for (const graph::ChainElement& element : app_.graph.chain_elements(term.path)) {
    Element& added = known.elements.emplace_back();
    added.subchain = element.subchain;
    const NodeId node = element.nodes.back();
    added.output_period = to_millis(app_.graph.output_period_up_to(node)).count();
    added.runs_per_output = element.subchain ? planned.runs_per_output(app_.graph.subchain(*element.subchain), node)
                                             : planned.runs_per_output(node);
    if (element.subchain) {
      const graph::Subchain& subchain = app_.graph.subchain(*element.subchain);
      added.output_period = std::max(added.output_period, apart_by_clocks(app_.graph, planned, subchain, node));
      added.left_out = model::left_out(app_.graph, planned, subchain, node);
      continue;
    }
    added.left_out = model::left_out(app_.graph.node(node));
    added.node = node;
    added.period = own_period(app_.graph, node);
    added.follows = element.follows;
    added.leader = app_.graph.node(node).follows;
    if (!app_.graph.node(node).external) {
      added.cost = run + samples.moments(node, 0).mean + samples.mean_wait(node).mean;
      added.planned = (planned[node].single_thread() + planned.wait(node)).count();
    }
  }
}

void Surrogate::know_asked_rates() {
  for (std::size_t i = 0; i < app_.graph.subchains().size(); ++i) {
    const plan::PeriodLimits limits = plan::period_limits(app_.graph, SubchainId(i));
    if (limits.exact) exact_rates_.push_back({SubchainId(i), limits.exact->count()});
  }
  for (const plan::SoftBound& bound : plan::soft_bounds(app_)) {
    if (bound.node) min_rates_.push_back({*app_.graph.node(*bound.node).subchain, bound.asked.count()});
  }
}

void Surrogate::know_inputs(const model::CostTable& planned) {
  const graph::Graph& graph = app_.graph;
  const auto awaits = [&](const graph::Subchain& subchain) { return graph.awaits_input(subchain.head()); };
  if (std::none_of(graph.subchains().begin(), graph.subchains().end(), awaits)) return;
  for (const graph::Subchain& subchain : graph.subchains()) {
    std::optional<Fed>& fed = fed_.emplace_back();
    if (!awaits(subchain)) continue;
    fed.emplace(Fed{.apart = kInfinity, .subchains = {}});
    for (const NodeId from : graph.node(subchain.head()).predecessors) {
      const graph::Node& node = graph.node(from);
      if (node.subchain) {
        fed->subchains.push_back(node.subchain->index());
      } else {
        const double apart = node.external ? own_period(graph, from) : arrivals_[from.index()].apart;
        fed->apart = std::min(fed->apart, apart * planned.runs_per_output(from));
      }
    }
  }
}

// What comes to a subchain is so far apart, the fastest of it; 0: its runs do not wait for it.
double Surrogate::fed_apart(std::size_t subchain) const {
  if (fed_.empty() || !fed_[subchain]) return 0.0;
  double apart = fed_[subchain]->apart;
  for (const std::size_t from : fed_[subchain]->subchains) apart = std::min(apart, timings_[from].period);
  return apart;
}

// Whether some subchain never runs, since it is triggered by what its own output would bring about, or waits for that.
bool Surrogate::waits_for_itself(const trial::Schedule& schedule) const {
  if (fed_.empty()) return false;
  std::vector<bool> runs(timings_.size(), false);
  const auto may_run = [&](std::size_t i) {
    const std::optional<plan::After>& after = schedule.subchains[i].after;
    if (after && after->subchain() != nullptr && !runs[after->subchain()->index()]) return false;
    if (!fed_[i] || fed_[i]->apart < kInfinity) return true;
    return std::any_of(fed_[i]->subchains.begin(), fed_[i]->subchains.end(),
                       [&](std::size_t from) { return runs[from]; });
  };
  bool changed = true;
  while (changed) {
    changed = false;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (runs[i] || !may_run(i)) continue;
      runs[i] = changed = true;
    }
  }
  return std::find(runs.begin(), runs.end(), false) != runs.end();
}

// How far apart the triggers are of a subchain that follows another, where each run of that one gives an output.
double Surrogate::outputs_apart(const trial::Schedule& schedule, std::size_t subchain) const {
  const plan::After& after = *schedule.subchains[subchain].after;
  if (const NodeId* const node = after.node()) return after.every * arrivals_[node->index()].apart;
  const std::size_t leader = after.subchain()->index();
  return after.every * std::max(timings_[leader].period, output_period_[leader]);
}

double Surrogate::runs_per_output(const plan::After& after) const {
  if (const NodeId* const node = after.node()) return arrivals_[node->index()].runs_per_output;
  return runs_per_output_[after.subchain()->index()];
}

double Surrogate::mean_cost(SubchainId subchain, int core) const {
  double cost = mean_[kind_of(core)][subchain.index()];
  for (const Batches& batches : batches_[subchain.index()]) {
    cost += batches.per_item[kind_of(core)] * static_cast<double>(batches.inputs.size());
  }
  return cost;
}

// What a run costs with the items that come in its period, as known so far. Between two whole numbers of items it has
// now the one, now the other.
void Surrogate::take_batches(const trial::Place& place, std::size_t subchain) {
  if (batches_[subchain].empty()) return;
  Timing& timing = timings_[subchain];
  const std::size_t kind = kind_of(place.core);
  const auto period_of = [&](SubchainId id) { return Millis{timings_[id.index()].period}; };
  timing.cost = mean_[kind][subchain];
  double variance = square_[kind][subchain] - timing.cost * timing.cost;
  for (const Batches& batches : batches_[subchain]) {
    const double per_item = batches.per_item[kind];
    const double items = model::mean_items(batches.inputs, Millis{timing.period}, period_of);
    const double part = items - std::floor(items);
    timing.cost += per_item * items;
    variance += per_item * per_item * part * (1.0 - part);
  }
  timing.square = timing.cost * timing.cost + variance;
}

void Surrogate::time_pipelines(const trial::Schedule& schedule) {
  for (const trial::Pipeline& pipeline : schedule.pipelines) {
    const std::size_t i = pipeline.subchain.index();
    Timing& timing = timings_[i];
    timing.period = std::max(to_millis(pipeline.pacing.period).count(), fed_apart(i));
    timing.promised_period = timing.period;
    // Paced by its own outputs, it is as much slower at worst as its runs are longer.
    if (pipeline.pacing.after_completion > Nanos{0}) timing.promised_period *= timing.planned * usable_ / timing.cost;
    timing.spacing = timing.promised_period;
    timing.wait = timing.period / 2.0;
    const double part = parallel_part(kind_of(pipeline.cores.front()), i, pipeline.threads);
    timing.execution = timing.from_begin = timing.cost * part + timing.waits;
    timing.promised_execution = timing.planned * part + timing.planned_waits;
  }
}

double Surrogate::parallel_part(std::size_t kind, std::size_t subchain, int threads) const {
  const std::vector<double>& parts = parts_on_threads_[kind][subchain];
  return parts[std::min(static_cast<std::size_t>(threads), parts.size()) - 1];
}

bool Surrogate::is_led_by(const trial::Schedule& schedule, std::size_t subchain, std::size_t leader) {
  const std::optional<plan::After>* after = &schedule.subchains[subchain].after;
  while (*after && (*after)->subchain() != nullptr) {
    const std::size_t led_by = (*after)->subchain()->index();
    if (led_by == leader) return true;
    after = &schedule.subchains[led_by].after;
  }
  return false;
}

// A leader from below has, to begin with, the period that those above leave it if they run after all of its outputs:
// the rounds would not find it, since the more they take of a period that is too short, the longer its run seems.
void Surrogate::begin_leaders(const trial::Schedule& schedule) {
  for (const std::size_t i : order_) {
    const trial::Place& place = schedule.subchains[i];
    double runs = 1.0;  // of the leader's, to one of i's
    for (const trial::Place* led = &place; led->after && led->after->subchain() != nullptr;) {
      runs *= led->after->every * runs_per_output(*led->after);
      const std::size_t leader = led->after->subchain()->index();
      led = &schedule.subchains[leader];
      if (led->form != trial::Form::kPriority || led->core != place.core || led->priority > place.priority) continue;
      timings_[leader].leads = true;
      timings_[leader].led_work += timings_[i].cost / runs;
    }
  }
  for (const std::size_t i : order_) {
    const std::optional<Nanos>& pause = schedule.subchains[i].pause;
    Timing& timing = timings_[i];
    if (!pause || !timing.leads) continue;
    const double rest = std::max(to_millis(*pause).count(), timing.led_work);
    timing.period = std::max(timing.period, timing.cost + timing.waits + rest);
  }
}

Surrogate::Led Surrogate::led_above(const trial::Schedule& schedule, std::size_t leader, const Above& above) const {
  Led led;
  const Timing& timing = timings_[leader];
  if (!timing.leads) return led;
  for (std::size_t at = above.first; at < above.last; ++at) {
    if (!is_led_by(schedule, order_[at], leader)) continue;
    led.load += timings_[order_[at]].load;
    led.anytime += timings_[order_[at]].anytime;
  }
  const std::optional<Nanos>& pause = schedule.subchains[leader].pause;
  if (!pause) return led;
  const double rest = to_millis(*pause).count();
  const double stretch = 1.0 / (1.0 - above.load + led.load);
  // All of them after each run; or each now and then, by itself.
  double apart = 0.0;
  for (std::size_t at = above.first; at < above.last; ++at) {
    const Timing& other = timings_[order_[at]];
    const double beyond = other.cost * stretch - rest;
    if (beyond > 0.0 && is_led_by(schedule, order_[at], leader)) apart += other.rate * timing.period * beyond;
  }
  led.late = std::max({0.0, led.load * timing.period * stretch - rest, apart});
  return led;
}

// What a run finds of the runs under way of those above it, on average: which ones it can meet is told by what it is
// triggered by.
double Surrogate::found_under_way(const trial::Schedule& schedule, std::size_t i, const Above& above,
                                  const Led& led) const {
  const trial::Place& place = schedule.subchains[i];
  if (place.pause) {
    // Nothing was above it when its run before ended.
    const double pause = to_millis(*place.pause).count();
    double found = 0.0;
    for (std::size_t at = above.first; at < above.last; ++at) {
      const Timing& other = timings_[order_[at]];
      if (timings_[i].leads && is_led_by(schedule, order_[at], i)) continue;
      found += pause < other.execution ? other.anytime * pause / other.execution : other.anytime;
    }
    return found;
  }
  double found = above.anytime - led.anytime;
  if (!place.after || place.after->subchain() == nullptr) return found;
  // Nor above its leader when that ended.
  const trial::Place& leader = schedule.subchains[place.after->subchain()->index()];
  if (leader.form != trial::Form::kPriority || leader.core != place.core) return found;
  for (std::size_t at = above.first; at < above.last; ++at) {
    if (schedule.subchains[order_[at]].priority >= leader.priority) found -= timings_[order_[at]].anytime;
  }
  return std::max(found, 0.0);
}

// A run takes
//   L = late + (c + W) / (1 - U),  W = sum of r_j E[c_j^2] / 2 over those above that it may meet
// (what is left of a run that is met at any time). Those that it triggers itself are in neither; they may make it begin
// late. A run that waits takes that much longer, and may then meet any subchain above it. One above it that runs longer
// than its period makes it miss triggers: so many as fit into that run, but one.
void Surrogate::time_subchain(const trial::Schedule& schedule, std::size_t i, const Above& above) {
  const trial::Place& place = schedule.subchains[i];
  take_batches(place, i);
  Timing& timing = timings_[i];
  const Led led = led_above(schedule, i, above);
  const double used = above.load - led.load;
  const double stretch = 1.0 / (1.0 - used);
  const double met_after_waits = (timing.parts - 1.0) * (above.anytime - led.anytime);
  const double found = found_under_way(schedule, i, above, led) + met_after_waits;
  timing.execution = led.late + (timing.cost + found) * stretch + timing.waits;
  timing.from_begin = (timing.cost + met_after_waits) * stretch + timing.waits;
  timing.late = led.late;
  timing.stretch = stretch;
  const double min = std::max(to_millis(place.period).count(), fed_apart(i));
  const double variance = timing.square - timing.cost * timing.cost;
  if (place.pause) {
    timing.period = std::max(min, timing.execution + to_millis(*place.pause).count());
    timing.wait = (timing.period + variance * stretch * stretch / timing.period) / 2.0;
    return;
  }
  const double apart = place.after ? std::max(min, outputs_apart(schedule, i) * runs_per_output(*place.after)) : min;
  const double alone = timing.cost * stretch + timing.waits;
  double missed = 0.0;  // triggers, of each
  double squares = 0.0;
  double long_gaps = 0.0;
  for (std::size_t at = above.first; at < above.last && above.longest > (apart - alone) * (1.0 - above.load); ++at) {
    const Timing& other = timings_[order_[at]];
    // What it triggers itself is not in `used`.
    const bool led_by_it = timing.leads && is_led_by(schedule, order_[at], i);
    const double left = 1.0 - used + (led_by_it ? 0.0 : other.load);
    if (other.cost <= (apart - alone) * left) continue;
    const double blocked = other.cost / left + alone;
    missed += (blocked - apart) * other.rate;
    squares += blocked * blocked * other.rate;
    long_gaps += other.rate;
  }
  constexpr double kMinKept = 0.02;
  const double kept = std::max(1.0 - missed, kMinKept);
  const double own = spread_[kind_of(place.core)][i].lost_triggers({timing.cost, stretch, timing.waits}, apart);
  timing.period = std::max(apart * (1.0 + own) / kept, alone);
  const double even = std::max(1.0 / timing.period - long_gaps, 0.0);
  timing.wait = std::max((even * apart * apart + squares) / 2.0, timing.period / 2.0);
  if (place.after && place.after->every == 1 && place.after->subchain() != nullptr) {
    timing.wait = std::max(timing.wait, timings_[place.after->subchain()->index()].wait);
  }
}

// False: a subchain gets nothing.
bool Surrogate::time_cores(const trial::Schedule& schedule) {
  load_ = 0.0;
  settled_ = true;
  int core = -1;
  Above above;
  for (std::size_t at = 0; at < order_.size(); ++at) {
    const std::size_t i = order_[at];
    if (schedule.subchains[i].core != core) above = {.first = at};
    core = schedule.subchains[i].core;
    if (above.load >= kNothingLeft) return false;
    above.last = at;
    Timing& timing = timings_[i];
    const double before = timing.period;
    time_subchain(schedule, i, above);
    settled_ = settled_ && std::abs(timing.period - before) <= kSettled * before;
    timing.rate = 1.0 / timing.period;
    timing.load = timing.cost * timing.rate;
    timing.anytime = timing.square * timing.rate / (2.0 * timing.parts);
    above.load += timing.load;
    above.anytime += timing.anytime;
    above.longest = std::max(above.longest, timing.cost);
    load_ = std::max(load_, above.load / usable_);
  }
  return true;
}

// Whether periods depend on nothing that comes later in the order.
bool Surrogate::settles_at_once(const trial::Schedule& schedule) const {
  for (std::size_t at = 0; at < order_.size(); ++at) {
    const std::size_t i = order_[at];
    if (!batches_[i].empty() || (!fed_.empty() && fed_[i] && !fed_[i]->subchains.empty())) return false;
    const std::optional<plan::After>& after = schedule.subchains[i].after;
    if (!after || after->subchain() == nullptr) continue;
    const std::size_t leader = after->subchain()->index();
    if (schedule.subchains[leader].form != trial::Form::kPriority) continue;
    const auto end = order_.begin() + static_cast<std::ptrdiff_t>(at);
    if (std::find(order_.begin(), end, leader) == end) return false;
  }
  return true;
}

std::optional<Estimate> Surrogate::operator()(const trial::Schedule& schedule, double limit) {
  if (waits_for_itself(schedule)) return std::nullopt;
  const std::vector<trial::Place>& places = schedule.subchains;
  order_.clear();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::size_t kind = kind_of(places[i].core);
    timings_[i] = {.cost = mean_[kind][i],
                   .square = square_[kind][i],
                   .planned = planned_[kind][i],
                   .waits = waits_[i],
                   .planned_waits = planned_waits_[i],
                   .parts = parts_[i]};
    timings_[i].period = std::max(to_millis(places[i].period).count(), timings_[i].cost + timings_[i].waits);
    timings_[i].spacing = timings_[i].period;
    timings_[i].wait = timings_[i].period / 2.0;
    if (places[i].form == trial::Form::kPriority) order_.push_back(i);
  }
  std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
    return places[a].core != places[b].core ? places[a].core < places[b].core : places[a].priority > places[b].priority;
  });
  begin_leaders(schedule);
  time_pipelines(schedule);
  const bool at_once = settles_at_once(schedule);
  for (int round = 0; round < rounds_; ++round) {
    if (!time_cores(schedule)) return std::nullopt;
    // Once more at least, for what follows others that come later in the order.
    if (at_once || (settled_ && round > 0)) break;
  }
  Estimate estimate{.promised = false, .load = load_ * load_factor_};
  values_.clear();
  for (const Term& term : terms_) {
    const double factor = factors_.empty() ? 1.0 : factors_[values_.size()];
    values_.push_back(total_of(schedule, term, Basis::kUsual));
    estimate.objective += term.weight * factor * values_.back();
  }
  if (estimate.objective <= limit) promise(schedule, estimate);
  return estimate;
}

}  // namespace ctn::planner
