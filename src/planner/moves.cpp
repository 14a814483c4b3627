#include "planner/moves.h"

#include <algorithm>
#include <cmath>
#include <set>
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
constexpr std::size_t kMaxOutputs = 6;
// A follower is held apart by so much of the time between the outputs that trigger it.
constexpr double kHeldApart = 0.8;
// A phase against a clock is moved by so much of the period, or less; and a period is so many ticks more, or fewer.
constexpr double kPhaseStep = 0.1;
constexpr double kSmallPhaseStep = 0.01;
// Than a run takes on average: what is set aside for one that is to be done before something else.
constexpr double kLonger = 0.5;
constexpr std::size_t kMaxTicks = 8;

// By a factor between exp(-size) and exp(size).
double stretched(double value, double size, Random& random) {
  return value * model::portable_exp((2.0 * random.fraction() - 1.0) * size);
}

bool has_cycle(const Schedule& schedule) {
  for (std::size_t from = 0; from < schedule.subchains.size(); ++from) {
    std::size_t at = from;
    for (std::size_t steps = 0; schedule.subchains[at].after; ++steps) {
      const SubchainId* const leader = schedule.subchains[at].after->subchain();
      if (leader == nullptr) break;
      if (steps > schedule.subchains.size()) return true;
      at = leader->index();
    }
  }
  return false;
}

std::vector<std::size_t> predecessors_of(const graph::Graph& graph, SubchainId id) {
  std::set<std::size_t> found;
  for (const NodeId node : graph.subchain(id).nodes) {
    for (const NodeId from : graph.node(node).predecessors) {
      const std::optional<SubchainId> before = graph.node(from).subchain;
      if (before && before != id) found.insert(before->index());
    }
  }
  return {found.begin(), found.end()};
}

// Of each response time, the one that weighs most first.
std::vector<std::vector<std::size_t>> chains_of(const graph::App& app) {
  std::vector<const graph::Term*> terms;
  for (const graph::Term& term : app.objective) {
    if (term.metric == graph::Metric::kResponseTime) terms.push_back(&term);
  }
  std::stable_sort(terms.begin(), terms.end(),
                   [](const graph::Term* a, const graph::Term* b) { return a->weight > b->weight; });
  std::vector<std::vector<std::size_t>> chains;
  for (const graph::Term* term : terms) {
    std::vector<std::size_t> chain;
    for (const graph::ChainElement& element : app.graph.chain_elements(term->path)) {
      if (element.subchain) chain.push_back(element.subchain->index());
    }
    chains.push_back(std::move(chain));
  }
  return chains;
}

std::vector<std::size_t> neighbours_of(const graph::Graph& graph, SubchainId id) {
  std::set<std::size_t> found;
  for (std::size_t node = 0; node < graph.nodes().size(); ++node) {
    const std::optional<SubchainId> to = graph.nodes()[node].subchain;
    for (const NodeId from : graph.nodes()[node].predecessors) {
      const std::optional<SubchainId> before = graph.node(from).subchain;
      if (!to || !before || to == before) continue;
      if (*to == id) found.insert(before->index());
      if (*before == id) found.insert(to->index());
    }
  }
  return {found.begin(), found.end()};
}

}  // namespace

std::vector<Arrival> arrivals_of(const graph::Graph& graph, SubchainId subchain) {
  std::vector<Arrival> arrivals;
  for (const NodeId id : graph.node(graph.subchain(subchain).head()).predecessors) {
    const graph::Node& node = graph.node(id);
    if (node.unscheduled) arrivals.push_back({id, to_millis(node.outputs_apart())});
  }
  return arrivals;
}

Moves::Moves(const graph::App& app, std::vector<double> cost, const Pipelines& pipelines, int cores, Freedom freedom)
    : app_(app),
      pipelines_(pipelines),
      cost_(std::move(cost)),
      cores_(cores),
      freedom_(freedom),
      joined_(app.joined_by_exclusion()),
      chains_(chains_of(app)),
      clocks_(app.graph.subchains().size()) {
  const std::vector<plan::UsefulPeriod> useful = plan::useful_periods(app.graph);
  for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
    const plan::PeriodLimits limits = plan::period_limits(app.graph, SubchainId(i));
    const Millis shortest = limits.exact ? limits.min : std::max(limits.min, useful[i].min);
    const graph::Node& head = app.graph.node(app.graph.subchain(SubchainId(i)).head());
    const bool free = freedom.outputs || head.trigger == graph::TriggerBy::kArrival;
    const graph::TriggerBy trigger = free ? head.trigger : graph::TriggerBy::kTime;
    limits_.push_back({std::max(to_nanos(shortest), dispatch::kShortestPeriod),
                       std::max(to_nanos(limits.min), dispatch::kShortestPeriod), limits.exact.has_value(), trigger});
    neighbours_.push_back(neighbours_of(app.graph, SubchainId(i)));
    predecessors_.push_back(predecessors_of(app.graph, SubchainId(i)));
    arrivals_.push_back(trigger == graph::TriggerBy::kTime ? std::vector<Arrival>()
                                                           : arrivals_of(app.graph, SubchainId(i)));
  }
}

void Moves::know_clocks(const std::vector<NodeId>& clocks) {
  clocks_.assign(limits_.size(), {});
  if (!freedom_.phases) return;
  for (const graph::Term& term : app_.objective) {
    for (const NodeId end : {term.path.front(), term.path.back()}) {
      if (!app_.graph.node(end).has_clock() || std::find(clocks.begin(), clocks.end(), end) == clocks.end()) continue;
      for (const NodeId node : term.path) {
        if (!app_.graph.node(node).subchain) continue;
        std::vector<Clock>& known = clocks_[app_.graph.node(node).subchain->index()];
        const bool fresh =
            std::none_of(known.begin(), known.end(), [&](const Clock& each) { return each.node == end; });
        if (fresh) known.push_back({end, *app_.graph.node(end).period, end == term.path.front()});
      }
    }
  }
}

// Its phase is somewhere else in the clock's period, or a little elsewhere than it was; or it has none any more.
void Moves::change_clock(Place& place, std::size_t subchain, Random& random) const {
  const Limits& limits = limits_[subchain];
  if (limits.trigger == graph::TriggerBy::kArrival) return;
  if (place.clock && random.once_in(2)) {
    const double step = random.once_in(2) ? kPhaseStep : kSmallPhaseStep;
    const Nanos moved = to_nanos(to_millis(place.period) * (random.fraction() - 0.5) * step);
    place.phase = (place.phase + moved + place.period) % place.period;
    return;
  }
  if (place.clock && random.once_in(8)) return place.clock.reset();
  const Clock& clock = clocks_[subchain][random.below(clocks_[subchain].size())];
  // As often as it may, or each so-many-th tick.
  const bool can_be_shortest = plan::ticks_of(to_millis(limits.shortest), to_millis(clock.period)).has_value();
  if (limits.exact && !can_be_shortest) return;
  const bool shortest = can_be_shortest && (limits.exact || random.once_in(2));
  const Nanos::rep min_every = std::max<Nanos::rep>((limits.shortest + clock.period - Nanos{1}) / clock.period, 1);
  const auto more = random.once_in(2) ? Nanos::rep{0} : static_cast<Nanos::rep>(random.below(kMaxTicks));
  place.pause.reset();
  place.after.reset();
  place.clock = clock.node;
  place.period = shortest ? limits.shortest : (min_every + more) * clock.period;
  place.phase = some_phase(place.period, clock, cost_[subchain], random);
}

// Anywhere, or where one would look first: soon after the tick with which a chain begins, or so that a run is done just
// before the tick that ends one.
Nanos Moves::some_phase(Nanos period, const Clock& clock, double cost, Random& random) {
  if (random.once_in(2)) {
    constexpr double kSoon = 0.1;  // of a run
    const double after = clock.begins ? cost * kSoon * random.fraction() : -cost * (1.0 + kLonger * random.fraction());
    return (to_nanos(Millis{after}) % period + period) % period;
  }
  return std::min(to_nanos(to_millis(period) * random.fraction()), period - Nanos{1});
}

void Moves::set_asked_trigger(Place& place, std::size_t subchain) const {
  if (limits_[subchain].trigger != graph::TriggerBy::kArrival) return;
  follow_arrivals(place, subchain, arrivals_[subchain].front(), 1);
}

void Moves::take_turns(Schedule& schedule) const {
  for (int core = 0; core < cores_; ++core) {
    std::optional<std::size_t> leader;
    for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
      const bool shorter = !leader || schedule.subchains[i].period < schedule.subchains[*leader].period;
      if (may_lead(schedule, i, core) && shorter) leader = i;
    }
    if (leader) lead(schedule, *leader);
  }
}

bool Moves::may_lead(const Schedule& schedule, std::size_t subchain, int core) const {
  const Place& place = schedule.subchains[subchain];
  return place.form == trial::Form::kPriority && place.core == core && !place.after && !limits_[subchain].exact &&
         limits_[subchain].trigger == graph::TriggerBy::kAny;
}

void Moves::fall_in_line(Schedule& schedule, bool by_chance, Random& random) const {
  std::vector<std::size_t> order;
  const auto append = [&](std::size_t subchain) {
    if (std::find(order.begin(), order.end(), subchain) == order.end()) order.push_back(subchain);
  };
  const std::size_t first = by_chance && !chains_.empty() ? random.below(chains_.size()) : 0;
  for (std::size_t chain = 0; chain < chains_.size(); ++chain) {
    for (const std::size_t subchain : chains_[(first + chain) % chains_.size()]) append(subchain);
  }
  for (std::size_t i = 0; i < schedule.subchains.size(); ++i) append(i);
  for (int core = 0; core < cores_; ++core) {
    std::vector<std::size_t> line;
    for (const std::size_t i : order) {
      if (may_lead(schedule, i, core)) line.push_back(i);
    }
    if (line.size() > 1) line_up(schedule, line);
  }
}

// Subchains in a chain with the first one run as often as that one.
void Moves::line_up(Schedule& schedule, const std::vector<std::size_t>& line) const {
  const std::size_t leader = line.front();
  const auto together = std::find_if(chains_.begin(), chains_.end(), [&](const std::vector<std::size_t>& chain) {
    return std::find(chain.begin(), chain.end(), leader) != chain.end();
  });
  std::vector<int> priorities;
  double round = 0.0;  // how long all take, one after the other
  for (const std::size_t i : line) {
    priorities.push_back(schedule.subchains[i].priority);
    round += cost_[i];
  }
  std::sort(priorities.rbegin(), priorities.rend());
  std::vector<double> rounds(schedule.subchains.size(), 1.0);  // of the first one's runs, to one of its own
  for (std::size_t at = 1; at < line.size(); ++at) {
    const std::size_t i = line[at];
    Place& place = schedule.subchains[i];
    std::size_t followed = leader;
    for (std::size_t before = 1; before < at; ++before) {
      const auto& predecessors = predecessors_[i];
      if (std::find(predecessors.begin(), predecessors.end(), line[before]) != predecessors.end())
        followed = line[before];
    }
    const bool with_first =
        together != chains_.end() && std::find(together->begin(), together->end(), i) != together->end();
    const double asked = with_first ? 1.0 : to_millis(place.period).count() / round;
    const int every = std::max(1, static_cast<int>(std::lround(asked / rounds[followed])));
    rounds[i] = every * rounds[followed];
    place.after = plan::After{SubchainId(followed), every};
    place.pause.reset();
    place.clock.reset();
    place.phase = Nanos{0};
    place.priority = priorities[at - 1];
    place.period = std::max(to_nanos(Millis{kHeldApart * rounds[i] * round}), limits_[i].held_apart);
  }
  constexpr double kRest = 0.07;  // of a round: the slack
  Place& first = schedule.subchains[leader];
  first.priority = priorities.back();
  first.period = limits_[leader].shortest;
  first.phase = Nanos{0};
  first.clock.reset();
  first.pause = to_nanos(Millis{kRest * round});
}

std::size_t Moves::some_predecessor(std::size_t subchain, Random& random) const {
  const std::vector<std::size_t>& predecessors = predecessors_[subchain];
  if (!predecessors.empty() && random.once_in(2)) return predecessors[random.below(predecessors.size())];
  return random.below(limits_.size());
}

void Moves::keep_to_useful(Schedule& schedule) const {
  for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
    Place& place = schedule.subchains[i];
    if (place.form != trial::Form::kPriority || place.after || place.clock) continue;
    place.period = std::max(place.period, limits_[i].shortest);
  }
}

bool Moves::may_come_less_often(const Place& place, std::size_t subchain) const {
  return place.form == trial::Form::kPriority && !limits_[subchain].exact && !place.clock && !place.after;
}

void Moves::come_less_often(Place& place, std::size_t subchain, double factor, Millis period_now) const {
  if (factor <= 1.0 || place.form != trial::Form::kPriority || limits_[subchain].exact) return;
  if (place.clock) return skip_ticks(place, factor);
  if (place.pause) *place.pause += to_nanos((factor - 1.0) * period_now);
  const bool by_time = !place.pause && !place.after;
  const Millis period = to_millis(place.period);
  place.period = to_nanos(factor * (by_time ? std::max(period, period_now) : period));
  place.phase = to_nanos(factor * to_millis(place.phase));
}

// By so many quarters of a tick as it takes, where that is not much more than was asked for: else who goes at each tick
// would come at five in six of them.
void Moves::skip_ticks(Place& place, double factor) const {
  constexpr double kParts = 4.0;
  constexpr double kMuchMore = 1.1;
  constexpr double kRounding = 1e-6;
  const Millis tick = *app_.graph.node(*place.clock).period;
  const double ticks = to_millis(place.period) / tick;
  const double slower = std::ceil(ticks * factor * kParts - kRounding) / kParts;
  if (slower <= ticks * factor * kMuchMore) place.period = to_nanos(slower * tick);
}

// Those of its core that may follow it do.
void Moves::lead(Schedule& schedule, std::size_t leader) const {
  Place& first = schedule.subchains[leader];
  int lowest = first.priority;
  bool followed = false;
  for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
    Place& place = schedule.subchains[i];
    if (i == leader || place.form != trial::Form::kPriority || place.core != first.core || place.after) continue;
    if (limits_[i].exact || limits_[i].trigger != graph::TriggerBy::kAny) continue;
    lowest = std::min(lowest, place.priority);
    const double every = to_millis(place.period) / to_millis(first.period);
    place.after = plan::After{SubchainId(leader), std::max(1, static_cast<int>(std::lround(every)))};
    place.period = std::max(to_nanos(kHeldApart * to_millis(place.period)), limits_[i].held_apart);
    followed = true;
  }
  if (!followed) return;
  constexpr double kRest = 0.07;  // of its run: the slack
  for (Place& place : schedule.subchains) place.priority += place.priority >= lowest ? 1 : 0;
  first.priority = lowest;
  first.period = limits_[leader].shortest;
  first.pause = to_nanos(Millis{kRest * cost_[leader]});
}

void Moves::follow_arrivals(Place& place, std::size_t subchain, const Arrival& arrival, int every) const {
  place.pause.reset();
  place.clock.reset();
  place.phase = Nanos{0};
  place.after = plan::After{arrival.node, every};
  place.period = std::max(to_nanos(kHeldApart * every * arrival.apart), limits_[subchain].held_apart);
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
      (cores_ > 1 && pipelines_.max_cores(SubchainId(i)) > 1 && random.once_in(kSeldom))) {
    return change_cores(schedule, i, random);
  }
  if (!clocks_[i].empty() && random.once_in(3)) return change_clock(place, i, random);
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
      if (!freedom_.phases) return change_time(place, i, random);
      if (random.once_in(2)) return align(schedule, i, random);
      if (!place.after && !place.pause) {
        place.phase = to_nanos(to_millis(place.period) * random.fraction());
        if (place.phase >= place.period) place.phase = Nanos{0};
      }
  }
}

bool Moves::knows(std::size_t subchain, NodeId clock) const {
  return std::any_of(clocks_[subchain].begin(), clocks_[subchain].end(),
                     [&](const Clock& each) { return each.node == clock; });
}

// In step with a neighbour that goes by time: done just before it begins, or beginning when it is done.
void Moves::align(Schedule& schedule, std::size_t subchain, Random& random) const {
  const Limits& limits = limits_[subchain];
  if (limits.trigger == graph::TriggerBy::kArrival || neighbours_[subchain].empty()) return;
  const std::size_t neighbour = neighbours_[subchain][random.below(neighbours_[subchain].size())];
  const Place& other = schedule.subchains[neighbour];
  if (other.form != trial::Form::kPriority || other.pause || other.after) return;
  Place& place = schedule.subchains[subchain];
  if (other.clock != place.clock && (limits.exact || (other.clock && !knows(subchain, *other.clock)))) return;
  if (!limits.exact) {
    const Nanos::rep min_every = (limits.shortest + other.period - Nanos{1}) / other.period;
    const Nanos::rep more = random.once_in(4) ? 1 + static_cast<Nanos::rep>(random.below(kMaxTicks)) : 0;
    place.period = (std::max<Nanos::rep>(min_every, 1) + more) * other.period;
    place.pause.reset();
    place.after.reset();
    place.clock = other.clock;
  }
  const double run = random.once_in(2) ? cost_[neighbour] : -cost_[subchain];
  const Nanos phase = other.phase + to_nanos(Millis{run * (1.0 + kLonger * random.fraction())});
  place.phase = (phase % place.period + place.period) % place.period;
}

void Moves::change_time(Place& place, std::size_t subchain, Random& random) const {
  if (limits_[subchain].exact || place.clock) return;
  const double size = random.once_in(4) ? kLargeStep : kSmallStep;
  if (place.pause) {
    place.pause = to_nanos(Millis{stretched(to_millis(*place.pause).count(), size, random)});
    return;
  }
  if (place.after && random.once_in(2)) {
    const int before = place.after->every;
    place.after->every = std::max(1, random.once_in(2) ? before + 1 : before - 1);
    const Nanos scaled = place.period * place.after->every / before;
    place.period = std::max(scaled, limits_[subchain].held_apart);
    return;
  }
  const double phase = to_millis(place.phase) / to_millis(place.period);
  const Nanos least = place.after ? limits_[subchain].held_apart : limits_[subchain].shortest;
  place.period = std::max(to_nanos(Millis{stretched(to_millis(place.period).count(), size, random)}), least);
  place.phase = std::min(to_nanos(phase * to_millis(place.period)), place.period - Nanos{1});
}

void Moves::change_core(Schedule& schedule, std::size_t subchain, std::size_t other, Random& random) const {
  if (cores_ < 2) return;
  Place& place = schedule.subchains[subchain];
  if (random.once_in(2) && schedule.subchains[other].form == trial::Form::kPriority) {
    const int core = place.core;
    move_joined(schedule, subchain, schedule.subchains[other].core);
    move_joined(schedule, other, core);
  } else {
    const std::vector<int> cores = cores_for_priorities(schedule);
    move_joined(schedule, subchain, cores[random.below(cores.size())]);
  }
}

void Moves::move_joined(Schedule& schedule, std::size_t subchain, int core) const {
  schedule.subchains[subchain].core = core;
  for (const SubchainId other : joined_[subchain]) {
    Place& place = schedule.subchains[other.index()];
    if (place.form == trial::Form::kPriority) place.core = core;
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

// Its own and some of the same kind. Subchains that were there go elsewhere; if there is no core left for them, it has
// none.
void Moves::give_cores(Schedule& schedule, std::size_t subchain, Random& random) const {
  Place& place = schedule.subchains[subchain];
  std::vector<int> others;
  for (const int core : cores_for_priorities(schedule)) {
    if (core != place.core && app_.kind_of(core) == app_.kind_of(place.core)) others.push_back(core);
  }
  const auto max = static_cast<std::size_t>(pipelines_.max_cores(SubchainId(subchain)) - 1);
  if (others.empty() || max == 0) return;
  std::vector<int> cores{place.core};
  for (std::size_t more = 1 + random.below(std::min(max, others.size())); more > 0; --more) {
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
  for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
    const Place& each = schedule.subchains[i];
    if (each.form != trial::Form::kPriority || std::find(taken.begin(), taken.end(), each.core) == taken.end())
      continue;
    if (left.empty()) {
      schedule = before;
      return;
    }
    move_joined(schedule, i, left[random.below(left.size())]);
  }
}

void Moves::change_pause(Place& place, std::size_t subchain, Random& random) const {
  if (limits_[subchain].exact || limits_[subchain].trigger == graph::TriggerBy::kArrival) return;
  place.after.reset();
  place.clock.reset();
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
  const graph::TriggerBy asked = limits_[subchain].trigger;
  const std::vector<Arrival>& arrivals = arrivals_[subchain];
  if (limits_[subchain].exact || asked == graph::TriggerBy::kTime) return;
  Place& place = schedule.subchains[subchain];
  if (asked == graph::TriggerBy::kArrival || (!arrivals.empty() && random.once_in(2))) {
    const int every = random.once_in(2) ? 1 + static_cast<int>(random.below(kMaxOutputs)) : 1;
    return follow_arrivals(place, subchain, arrivals[random.below(arrivals.size())], every);
  }
  if (place.after && random.once_in(2)) {
    place.after.reset();
    const double cost = cost_[subchain] * (2.0 + 10.0 * random.fraction());
    place.period = std::max(to_nanos(Millis{cost}), limits_[subchain].shortest);
    return;
  }
  if (schedule.subchains.size() < 2) return;
  const Place before = place;
  place.pause.reset();
  place.clock.reset();
  place.phase = Nanos{0};
  const int every = random.once_in(3) ? 1 + static_cast<int>(random.below(kMaxOutputs)) : 1;
  const std::size_t leader = some_predecessor(subchain, random);
  place.after = plan::After{SubchainId(leader), every};
  // Some less than outputs are likely to be apart.
  const double apart = every * std::max(to_millis(schedule.subchains[leader].period).count(), 1.5 * cost_[leader]);
  place.period = std::max(to_nanos(Millis{kHeldApart * apart}), limits_[subchain].held_apart);
  if (has_cycle(schedule)) place = before;
}

}  // namespace ctn::planner
