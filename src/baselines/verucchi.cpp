#include "baselines/verucchi.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "baselines/job_dag.h"
#include "plan/limits.h"

namespace ctn::baselines {
namespace {

constexpr int kMaxDoublings = 8;
constexpr std::size_t kMaxCombinations = 2'000'000;
constexpr std::size_t kDefaultEffort = 4'000'000;

struct Candidate {
  std::vector<int> doublings;  // by subchain: its period is the base times two to the power of this
  std::vector<int> core;
};

struct Value {
  double factor = kInfinity;
  double objective = kInfinity;

  bool better_than(const Value& other) const {
    constexpr double kClearly = 1.0 - 1e-9;
    if (factor < other.factor * kClearly) return true;
    return factor * kClearly <= other.factor && objective < other.objective * kClearly;
  }
};

// A chain, or a period, as far as it concerns tasks.
struct TermParts {
  struct Element {
    int task = 0;
    double emits = 0.0;
    int edge = -1;  // from the element before, of the same stretch; -1: it begins a stretch
  };
  bool response = true;
  double weight = 0.0;
  double constant = 0.0;    // of elements that are no tasks
  double first_wait = 0.0;  // of the first element, where it is no task
  bool begins_with_task = true;
  double bound = kInfinity;
  std::vector<Element> elements;
};

struct Found {
  Value value;
  double base = 0.0;
  std::vector<DagTask> tasks;
  std::vector<DagEdge> edges;
  DagSchedule schedule;
  std::vector<ChainBound> chains;
};

class Verucchi {
 public:
  Verucchi(const graph::App& app, const model::CostTable& costs, const RateRequest& request)
      : app_(app),
        stretched_(stretched_costs(app, costs, request.slack)),
        cores_(request.cores),
        effort_(request.effort > 0 ? request.effort : kDefaultEffort),
        count_(app.graph.subchains().size()) {
    for (std::size_t i = 0; i < count_; ++i) limits_.push_back(plan::period_limits(app.graph, SubchainId(i)));
    rank_.assign(count_, 0);
    int rank = 0;
    for (const NodeId node : app.graph.topological_order()) {
      const auto& subchain = app.graph.node(node).subchain;
      if (subchain && app.graph.subchain(*subchain).head() == node) rank_[subchain->index()] = rank++;
    }
    make_terms(costs);
    max_period_.assign(count_, kInfinity);
    for (const plan::SoftBound& bound : plan::soft_bounds(app)) {
      if (!bound.node) continue;
      double& most = max_period_[app.graph.node(*bound.node).subchain->index()];
      most = std::min(most, bound.asked.count());
    }
  }

  std::optional<Found> run() {
    descend(first());
    enumerate();
    if (best_.value.objective == kInfinity) return std::nullopt;
    return best_;
  }

  bool exhaustive() const { return exhaustive_; }

 private:
  double cost(std::size_t i, int core) const { return stretched_[app_.kind_of(core)][i]; }

  void make_terms(const model::CostTable& costs) {
    const graph::Graph& graph = app_.graph;
    weight_.assign(count_, 0.0);
    for (const graph::Term& term : app_.objective) {
      TermParts parts;
      parts.response = term.metric == graph::Metric::kResponseTime;
      parts.weight = term.weight;
      if (term.max) parts.bound = to_millis(*term.max).count();
      if (parts.response) {
        add_elements(parts, term, costs);
      } else if (const auto& subchain = graph.node(term.path.front()).subchain) {
        parts.elements.push_back({static_cast<int>(subchain->index()), 0.0, -1});
      } else {
        parts.constant = to_millis(graph.node(term.path.front()).period.value_or(Nanos{0})).count();
      }
      for (const TermParts::Element& element : parts.elements) {
        weight_[static_cast<std::size_t>(element.task)] += term.weight;
      }
      terms_.push_back(std::move(parts));
    }
  }

  void add_elements(TermParts& parts, const graph::Term& term, const model::CostTable& costs) {
    int before = -1;
    bool first = true;
    for (const graph::ChainElement& element : app_.graph.chain_elements(term.path)) {
      const double emits = output_period(app_.graph, element).count();
      if (element.subchain) {
        const auto task = static_cast<int>(element.subchain->index());
        parts.elements.push_back({task, emits, before < 0 ? -1 : edge_between(before, task)});
        before = task;
      } else {
        const NodeId node = element.nodes.front();
        const double period = std::max(to_millis(app_.graph.node(node).period.value_or(Nanos{0})).count(), emits);
        parts.constant += period + costs[node].single_thread().count();
        if (first) {
          parts.first_wait = period;
          parts.begins_with_task = false;
        }
        before = -1;
      }
      first = false;
    }
  }

  int edge_between(int from, int to) {
    const auto same = std::find(pairs_.begin(), pairs_.end(), std::pair(from, to));
    if (same != pairs_.end()) return static_cast<int>(same - pairs_.begin());
    pairs_.emplace_back(from, to);
    return static_cast<int>(pairs_.size()) - 1;
  }

  // The shortest base period; infinite where there is none.
  double base_of(const Candidate& at) const {
    double base = 0.0;
    double exact = 0.0;
    std::vector<double> load(static_cast<std::size_t>(cores_), 0.0);
    for (std::size_t i = 0; i < count_; ++i) {
      const double by = std::ldexp(1.0, at.doublings[i]);
      load[static_cast<std::size_t>(at.core[i])] += cost(i, at.core[i]) / by;
      if (limits_[i].exact) {
        const double given = limits_[i].exact->count() / by;
        if (exact > 0.0 && std::abs(given - exact) > 1e-9 * exact) return kInfinity;
        exact = given;
      } else {
        base = std::max(base, limits_[i].min.count() / by);
      }
    }
    base = std::max(base, *std::max_element(load.begin(), load.end()));
    if (exact == 0.0) return base;
    return base <= exact * (1.0 + 1e-12) ? exact : kInfinity;
  }

  double period(const Candidate& at, double base, int task) const {
    return std::ldexp(base, at.doublings[static_cast<std::size_t>(task)]);
  }

  // No graph of runs is better than this: a chain waits for its slowest task, and each of its tasks runs.
  Value min_value(const Candidate& at, double base) const {
    if (base == kInfinity) return {};
    Value least{1.0, 0.0};
    for (std::size_t i = 0; i < count_; ++i) {
      least.factor = std::max(least.factor, period(at, base, static_cast<int>(i)) / max_period_[i]);
    }
    for (const TermParts& term : terms_) {
      double value = term.constant;
      double slowest = 0.0;
      for (const TermParts::Element& element : term.elements) {
        const double p = period(at, base, element.task);
        const auto task = static_cast<std::size_t>(element.task);
        if (element.edge < 0) {
          value += slowest;
          slowest = 0.0;
        }
        slowest = std::max(slowest, p);
        if (term.response) value += std::max(0.0, element.emits - p) + cost(task, at.core[task]);
      }
      value += slowest;
      least.objective += term.weight * value;
      least.factor = std::max(least.factor, value / term.bound);
    }
    return least;
  }

  bool hopeless(const Value& least) const {
    if (least.factor > best_.value.factor * (1.0 + 1e-9)) return true;
    return best_.value.factor <= 1.0 && least.objective >= best_.value.objective;
  }

  std::vector<DagTask> tasks_of(const Candidate& at, double base) const {
    std::vector<std::size_t> order(count_);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(at.doublings[a], rank_[a]) < std::pair(at.doublings[b], rank_[b]);
    });
    const int least = at.doublings[order.front()];
    std::vector<DagTask> tasks(count_);
    for (std::size_t place = 0; place < count_; ++place) {
      const std::size_t i = order[place];
      const double unit = std::ldexp(base, least);
      tasks[i] = {cost(i, at.core[i]) / unit, 1 << (at.doublings[i] - least), at.core[i],
                  static_cast<int>(count_ - place)};
    }
    return tasks;
  }

  // Builds the graphs of a candidate; keeps the best of them if it is the best so far.
  void look_at(const Candidate& at) {
    const double base = base_of(at);
    if (hopeless(min_value(at, base))) return;
    const int least = *std::min_element(at.doublings.begin(), at.doublings.end());
    const double unit = std::ldexp(base, least);
    const std::vector<DagTask> tasks = tasks_of(at, base);
    const std::vector<std::vector<int>> delays = delays_of(tasks);
    std::vector<DagEdge> edges;
    for (std::size_t e = 0; e < pairs_.size(); ++e) edges.push_back({pairs_[e].first, pairs_[e].second, delays[e][0]});
    std::optional<Found> here = build(tasks, edges, unit);
    if (!here) return;
    for (std::size_t e = 0; e < pairs_.size(); ++e) {
      for (std::size_t way = 1; way < delays[e].size(); ++way) {
        std::vector<DagEdge> other = here->edges;
        other[e].delay = delays[e][way];
        std::optional<Found> found = build(tasks, other, unit);
        if (found && found->value.better_than(here->value)) here = std::move(found);
      }
    }
    if (!here->value.better_than(best_.value)) return;
    best_ = *std::move(here);
    best_at_ = at;
  }

  // By edge, the ways to connect: first the one that always works.
  std::vector<std::vector<int>> delays_of(const std::vector<DagTask>& tasks) {
    spent_ += runs_of(tasks);
    const std::optional<DagSchedule> alone = schedule_dag(tasks, {});
    std::vector<std::vector<int>> delays;
    for (const auto& [from, to] : pairs_) {
      const DagTask& producer = tasks[static_cast<std::size_t>(from)];
      const int step = std::min(producer.every, tasks[static_cast<std::size_t>(to)].every);
      std::vector<int> ways{producer.every};
      if (alone) {
        double latest = 0.0;  // end of a run after its trigger
        const auto& runs = alone->runs[static_cast<std::size_t>(from)];
        for (std::size_t k = 0; k < runs.size(); ++k) {
          latest = std::max(latest, runs[k].end - static_cast<double>(k) * producer.every);
        }
        const int by_then = static_cast<int>(std::ceil(latest / step - 1e-9)) * step;
        if (by_then < producer.every) ways.push_back(by_then);
      }
      ways.push_back(0);
      delays.push_back(std::move(ways));
    }
    return delays;
  }

  std::optional<Found> build(const std::vector<DagTask>& tasks, const std::vector<DagEdge>& edges, double unit) {
    spent_ += runs_of(tasks);
    std::optional<DagSchedule> schedule = schedule_dag(tasks, edges);
    if (!schedule) return std::nullopt;
    Found found;
    found.base = unit;
    found.tasks = tasks;
    found.edges = edges;
    found.schedule = *std::move(schedule);
    found.value = {1.0, 0.0};
    const auto period_of = [&](int task) { return unit * tasks[static_cast<std::size_t>(task)].every; };
    for (std::size_t i = 0; i < count_; ++i) {
      found.value.factor = std::max(found.value.factor, period_of(static_cast<int>(i)) / max_period_[i]);
    }
    for (const TermParts& term : terms_) {
      double value = term.constant;
      if (term.response) {
        found.chains.push_back(chain_bound(term, found));
        value = found.chains.back().response.count();
      } else if (!term.elements.empty()) {
        value = period_of(term.elements.front().task);
      }
      found.value.objective += term.weight * value;
      found.value.factor = std::max(found.value.factor, value / term.bound);
    }
    return found;
  }

  static ChainBound chain_bound(const TermParts& term, const Found& found) {
    double response = term.constant;
    double wait = term.first_wait;
    for (std::size_t i = 0; i < term.elements.size();) {
      const bool first = i == 0 && term.begins_with_task;
      std::vector<DagEdge> row;
      const int begin = term.elements[i].task;
      double emits = 0.0;
      do {
        const auto task = static_cast<std::size_t>(term.elements[i].task);
        emits += std::max(0.0, term.elements[i].emits - found.base * found.tasks[task].every);
        ++i;
        if (i == term.elements.size() || term.elements[i].edge < 0) break;
        row.push_back(found.edges[static_cast<std::size_t>(term.elements[i].edge)]);
      } while (true);
      const DagLatency latency = chain_latency(found.tasks, found.schedule, begin, row);
      response += found.base * latency.reaction + emits;
      if (first) wait = found.base * (latency.reaction - latency.age);
    }
    return {Millis{response}, Millis{response - wait}};
  }

  // Rates as the weights suggest, cores by load.
  Candidate first() const {
    std::vector<double> wish(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      wish[i] = limits_[i].exact
                    ? limits_[i].exact->count()
                    : std::max(limits_[i].min.count(), std::sqrt(stretched_[0][i] / std::max(weight_[i], 1e-9)));
    }
    // Exact rates are what the others are measured by.
    double unit = *std::min_element(wish.begin(), wish.end());
    for (std::size_t i = count_; i-- > 0;) {
      if (limits_[i].exact) unit = wish[i];
    }
    Candidate made;
    for (std::size_t i = 0; i < count_; ++i) {
      made.doublings.push_back(static_cast<int>(std::clamp(std::lround(std::log2(wish[i] / unit)), -8L, 8L)));
    }
    normalise(made);
    std::vector<std::size_t> order(count_);
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto load = [&](std::size_t i) { return stretched_[0][i] / std::ldexp(1.0, made.doublings[i]); };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return load(a) > load(b); });
    std::vector<double> loads(static_cast<std::size_t>(cores_), 0.0);
    made.core.assign(count_, 0);
    for (const std::size_t i : order) {
      const auto least = std::min_element(loads.begin(), loads.end());
      made.core[i] = static_cast<int>(least - loads.begin());
      *least += load(i);
    }
    return made;
  }

  // The fastest has no doublings, the slowest no more than there may be.
  static void normalise(Candidate& at) {
    const int least = *std::min_element(at.doublings.begin(), at.doublings.end());
    for (int& doublings : at.doublings) doublings = std::min(doublings - least, kMaxDoublings);
  }

  // How good a candidate is to climb from, where none has been found that can be scheduled.
  double excess(const Candidate& at) const {
    double exact = kInfinity;
    double base = 0.0;
    std::vector<double> load(static_cast<std::size_t>(cores_), 0.0);
    for (std::size_t i = 0; i < count_; ++i) {
      const double by = std::ldexp(1.0, at.doublings[i]);
      load[static_cast<std::size_t>(at.core[i])] += cost(i, at.core[i]) / by;
      if (limits_[i].exact)
        exact = std::min(exact, limits_[i].exact->count() / by);
      else
        base = std::max(base, limits_[i].min.count() / by);
    }
    return std::max(base, *std::max_element(load.begin(), load.end())) / exact;
  }

  void descend(Candidate from) {
    const std::size_t until = effort_ / 2;
    // Slow down what is not exact until exact rates can be met.
    for (int tries = 0; base_of(from) == kInfinity && tries < 4 * kMaxDoublings * static_cast<int>(count_); ++tries) {
      Candidate next = from;
      for (const Candidate& other : neighbours(from)) {
        if (excess(other) < excess(next)) next = other;
      }
      if (excess(next) >= excess(from)) break;
      from = next;
    }
    best_at_ = from;
    look_at(from);
    for (bool better = true; better && spent_ < until;) {
      better = false;
      const double before = best_.value.objective;
      const double factor = best_.value.factor;
      for (const Candidate& other : neighbours(best_at_)) {
        if (spent_ >= until) break;
        look_at(other);
      }
      better = best_.value.objective < before || best_.value.factor < factor;
    }
    exhaustive_ = false;
  }

  // One task faster or slower by two, or all faster than it; one on another core; two that swap.
  std::vector<Candidate> neighbours(const Candidate& at) const {
    std::vector<Candidate> made;
    for (std::size_t i = 0; i < count_; ++i) {
      for (const int by : {-1, 1}) {
        Candidate other = at;
        other.doublings[i] += by;
        normalise(other);
        if (other.doublings != at.doublings) made.push_back(other);
        other = at;
        for (std::size_t j = 0; j < count_; ++j) {
          if (at.doublings[j] <= at.doublings[i]) other.doublings[j] += by;
        }
        normalise(other);
        if (other.doublings != at.doublings) made.push_back(other);
      }
    }
    const std::vector<bool> used = used_cores(at);
    for (std::size_t i = 0; i < count_; ++i) {
      bool free_seen = false;
      for (int core = 0; core < cores_; ++core) {
        const bool free = !used[static_cast<std::size_t>(core)];
        if (core == at.core[i] || (free && free_seen && app_.kinds() == 1)) continue;
        free_seen = free_seen || free;
        Candidate other = at;
        other.core[i] = core;
        made.push_back(std::move(other));
      }
      for (std::size_t j = i + 1; j < count_; ++j) {
        if (at.core[i] == at.core[j]) continue;
        Candidate other = at;
        std::swap(other.core[i], other.core[j]);
        made.push_back(std::move(other));
      }
    }
    return made;
  }

  std::vector<bool> used_cores(const Candidate& at) const {
    std::vector<bool> used(static_cast<std::size_t>(cores_), false);
    for (const int core : at.core) used[static_cast<std::size_t>(core)] = true;
    return used;
  }

  // All combinations, those with the best lower bounds first; none where there are too many.
  void enumerate() {
    double combinations = std::pow(kMaxDoublings + 1.0, static_cast<double>(count_));
    const auto as_many = static_cast<double>(kMaxCombinations);
    if (combinations > as_many) return;
    std::vector<std::vector<int>> placements;
    std::vector<int> core(count_, 0);
    place(core, 0, static_cast<std::size_t>(as_many / combinations), placements);
    if (static_cast<double>(placements.size()) * combinations > as_many) return;
    struct Entry {
      Value least;
      std::uint32_t placement;
      std::uint32_t rates;
    };
    std::vector<Entry> entries;
    Candidate at;
    at.doublings.assign(count_, 0);
    for (std::uint32_t placement = 0; placement < placements.size(); ++placement) {
      at.core = placements[placement];
      for (std::uint32_t rates = 0; rates < static_cast<std::uint32_t>(combinations); ++rates) {
        if (!unpack(rates, at.doublings)) continue;
        const Value least = min_value(at, base_of(at));
        if (least.objective < kInfinity && !hopeless(least)) entries.push_back({least, placement, rates});
      }
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
      return std::tuple(a.least.factor, a.least.objective, a.placement, a.rates) <
             std::tuple(b.least.factor, b.least.objective, b.placement, b.rates);
    });
    exhaustive_ = true;
    for (const Entry& entry : entries) {
      if (hopeless(entry.least)) continue;
      if (spent_ >= effort_) {
        exhaustive_ = false;
        return;
      }
      at.core = placements[entry.placement];
      unpack(entry.rates, at.doublings);
      look_at(at);
    }
  }

  // False where no task has the base period: another combination is the same.
  bool unpack(std::uint32_t rates, std::vector<int>& doublings) const {
    for (int& of : doublings) {
      of = static_cast<int>(rates % (kMaxDoublings + 1));
      rates /= kMaxDoublings + 1;
    }
    return *std::min_element(doublings.begin(), doublings.end()) == 0;
  }

  // Every way to put subchains on cores, where cores of a kind are told apart only by who has them; stops beyond
  // `most`.
  void place(std::vector<int>& core, std::size_t i, std::size_t most, std::vector<std::vector<int>>& placements) const {
    if (placements.size() > most) return;
    if (i == count_) {
      placements.push_back(core);
      return;
    }
    std::set<std::size_t> empty_of_kind;
    for (int candidate = 0; candidate < cores_; ++candidate) {
      const auto end = core.begin() + static_cast<std::ptrdiff_t>(i);
      const bool empty = std::find(core.begin(), end, candidate) == end;
      if (empty && !empty_of_kind.insert(app_.kind_of(candidate)).second) continue;
      core[i] = candidate;
      place(core, i + 1, most, placements);
    }
  }

  const graph::App& app_;
  const std::vector<std::vector<double>> stretched_;  // [kind][subchain]
  const int cores_;
  const std::size_t effort_;
  std::size_t spent_ = 0;
  const std::size_t count_;
  std::vector<plan::PeriodLimits> limits_;
  std::vector<double> max_period_;  // by min_rate
  std::vector<int> rank_;           // of heads in the order of the data
  std::vector<double> weight_;
  std::vector<TermParts> terms_;
  std::vector<std::pair<int, int>> pairs_;  // tasks that follow each other in a chain
  Candidate best_at_;
  Found best_;
  bool exhaustive_ = false;
};

}  // namespace

Result<RatePlan> plan_by_verucchi(const graph::App& app, const model::CostTable& costs, const RateRequest& request) {
  if (const Status fine = check_request(app, request); !fine) return fine.error();
  Verucchi search(app, costs, request);
  const std::optional<Found> found = search.run();
  if (!found) {
    return Error(
        ErrorKind::kCaller,
        {Problem{{},
                 "nodes",
                 fmt::format("no rates found that are powers of two apart, keep the exact rates, and leave all "
                             "runs on {} cores time to end within their periods",
                             request.cores),
                 "give it more cores, lower the exact rates, or make them powers of two apart"}});
  }
  RatePlan plan;
  plan.planner = "verucchi";
  plan.exhaustive = search.exhaustive();
  plan.slack = request.slack;
  plan.hyperperiod = Millis{found->base * found->schedule.hyperperiod};
  for (std::size_t i = 0; i < found->tasks.size(); ++i) {
    const DagTask& task = found->tasks[i];
    double response = 0.0;
    for (std::size_t k = 0; k < found->schedule.runs[i].size(); ++k) {
      response = std::max(response, found->schedule.runs[i][k].end - static_cast<double>(k) * task.every);
    }
    plan.subchains.push_back(
        {task.core, Millis{found->base * task.every}, Millis{found->base * response}, task.priority});
  }
  for (const DagEdge& edge : found->edges) {
    plan.precedences.push_back({SubchainId(static_cast<std::size_t>(edge.from)),
                                SubchainId(static_cast<std::size_t>(edge.to)), Millis{found->base * edge.delay}});
  }
  fill_figures(plan, app, costs, request.cores, found->chains);
  return plan;
}

}  // namespace ctn::baselines
