// Random apps of several subchains, and the answer by brute force, for tests and benchmarks. The brute force knows
// nothing of the planner: it tries every partition of the subchains and every whole number, by the formulas of the
// model module.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/mixed.h"
#include "base/numbers.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "model/evaluate.h"
#include "model/formulas.h"
#include "plan/limits.h"
#include "plan/predict.h"

namespace ctn::planner {

struct RandomCase {
  graph::App app;
  model::CostTable costs;
  int cores = 1;
  double slack = 0.06;
};

struct RandomLimits {
  int subchains = 4;
  int chains = 4;
  double min_cost = 1.0;  // ms, of a subchain
  double max_cost = 8.0;
  double lightest = 0.01;  // weight of a term
  double heaviest = 1.0;
  bool reversed = false;  // the same app, written down the other way round
  bool all_queues = false;
  bool zeros = false;      // some cost nothing
  bool queue = false;      // the first subchain takes batches
  bool caps = false;       // some have a max_rate
  bool exact = false;      // one has an exact rate
  bool bounds = false;     // some chains have a max, some nodes a min_rate
  bool pairs = false;      // some subchains have two nodes
  bool kinds = false;      // cores differ: two or three kinds of them
  bool waits = false;      // runs of some nodes wait
  bool exclusive = false;  // runs of two subchains or more do not overlap
  bool batches = false;    // runs of the last subchain cost more with each item of a batch
};

// As if all of its subchains began with callbacks of messages.
inline void need_input(graph::App& app) {
  std::vector<NodeId> heads;
  for (const graph::Subchain& subchain : app.graph.subchains()) heads.push_back(subchain.head());
  app.graph = app.graph.needing_input(heads);
}

// Draws one case. Each step draws from what the steps before it have left.
class RandomCaseBuilder {
 public:
  RandomCaseBuilder(std::uint64_t seed, const RandomLimits& limits)
      : random_(seed), limits_(limits), subchains_(static_cast<std::size_t>(limits.subchains)) {}

  RandomCase build(int cores) {
    draw_subchains();
    draw_objective();
    draw_totals();
    set_inputs();
    draw_rates();
    draw_bounds();
    if (limits_.exclusive) draw_exclusive_group();
    if (limits_.reversed) reverse();
    if (limits_.kinds) draw_core_kinds(cores);
    Result<graph::App> built = graph::build_app(spec_);
    if (!built) throw std::logic_error(built.error().message());
    graph::App app = *std::move(built);
    model::CostTable costs = draw_costs(app);
    return {std::move(app), std::move(costs), cores, 0.06};
  }

 private:
  struct Drawn {
    std::string head;
    std::string second;  // empty: it has one node
    double cost = 0.0;   // ms, of all its nodes

    std::string nodes() const { return second.empty() ? head : head + " " + second; }
  };

  double uniform(double low, double high) { return low + (high - low) * fraction_of(random_()); }
  bool chance(double p) { return uniform(0.0, 1.0) < p; }
  double log_uniform(double low, double high) { return low * std::pow(high / low, uniform(0.0, 1.0)); }
  double weight() { return log_uniform(limits_.lightest, limits_.heaviest); }
  graph::NodeSpec& head_of(const Drawn& subchain) { return node(spec_, subchain.head); }

  void draw_subchains() {
    std::vector<std::string> names;
    std::vector<graph::SubchainSpec> specs;
    for (std::size_t i = 0; i < subchains_.size(); ++i) {
      Drawn& subchain = subchains_[i];
      subchain.head = "s" + std::to_string(i);
      names.push_back(subchain.head);
      if (!limits_.pairs || !chance(0.3)) continue;
      subchain.second = subchain.head + "b";
      names.push_back(subchain.second);
      specs.push_back(graph::subchain(subchain.head, subchain.nodes()));
    }
    names.push_back("base");
    spec_ = graph::spec_of(names, {});
    node(spec_, "base").external = true;
    spec_.subchains = std::move(specs);
  }

  // A graph in layers: node i feeds some later ones, so that there are chains through several subchains.
  void draw_objective() {
    std::vector<std::string> paths;
    for (int chain = 0; chain < std::max(1, limits_.chains); ++chain) {
      const std::string path = draw_path();
      if (std::find(paths.begin(), paths.end(), path) != paths.end()) continue;
      paths.push_back(path);
      add_edges(path);
      spec_.objective.push_back(graph::response(path, weight()));
    }
    // Every subchain counts for something.
    for (const Drawn& subchain : subchains_) spec_.objective.push_back(graph::period(subchain.head, weight()));
    for (const Drawn& subchain : subchains_) add_edges(subchain.nodes());
  }

  std::string draw_path() {
    const std::size_t count = subchains_.size();
    std::string path;
    int length = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const bool taken = chance(std::min(1.0, 2.0 / static_cast<double>(count)));
      if (!taken && !(length == 0 && i + 1 == count)) continue;
      path += subchains_[i].nodes() + " ";
      if (++length == 3) break;
    }
    return path + "base";
  }

  // Each edge once, however many chains pass it.
  void add_edges(const std::string& path) {
    const std::vector<graph::Name> row = graph::split(path);
    for (std::size_t i = 1; i < row.size(); ++i) {
      const std::string edge = row[i - 1].value + " " + row[i].value;
      if (std::find(edges_.begin(), edges_.end(), edge) != edges_.end()) continue;
      edges_.push_back(edge);
      spec_.edges.push_back({graph::split(edge), {}});
    }
  }

  void draw_totals() {
    for (Drawn& subchain : subchains_) {
      const bool nothing = limits_.zeros && chance(0.3);
      subchain.cost = nothing ? 0.0 : log_uniform(limits_.min_cost, limits_.max_cost);
      total_ += subchain.cost;
    }
  }

  void set_inputs() {
    for (std::size_t i = 0; i < subchains_.size(); ++i) {
      const bool queue =
          limits_.all_queues || (limits_.queue && i == 0) || (limits_.batches && i + 1 == subchains_.size());
      if (queue) head_of(subchains_[i]).input = graph::InputKind::kQueue;
    }
  }

  void draw_rates() {
    for (std::size_t i = 0; i < subchains_.size(); ++i) {
      graph::NodeSpec& head = head_of(subchains_[i]);
      if (limits_.exact && i + 1 == subchains_.size()) {
        head.min_rate = head.max_rate = every(uniform(1.2, 4.0) * subchains_[i].cost);
      } else if (limits_.caps && chance(0.3)) {
        head.max_rate = every(uniform(0.3, 3.0) * total_);
      } else if (limits_.bounds && chance(0.2)) {
        head.min_rate = every(uniform(0.5, 4.0) * total_);
      }
    }
  }
  // What costs nothing may not come more often than anything is triggered.
  static graph::At<Rate> every(double milliseconds) {
    return {Rate::every(std::max(Millis{milliseconds}, Millis{graph::kShortestPeriod})), {}};
  }

  void draw_bounds() {
    if (!limits_.bounds) return;
    for (graph::TermSpec& term : spec_.objective) {
      if (term.metric == graph::Metric::kResponseTime && chance(0.4)) {
        term.max = graph::At<Nanos>{to_nanos(Millis{uniform(1.0, 8.0) * total_}), {}};
      }
    }
  }

  void draw_exclusive_group() {
    std::vector<graph::Name> nodes;
    for (std::size_t i = 0; i < subchains_.size(); ++i) {
      if (i < 2 || chance(0.5)) nodes.push_back({subchains_[i].head, {}});
    }
    spec_.exclusive.push_back({{"group", {}}, std::move(nodes)});
  }

  void reverse() {
    std::reverse(spec_.nodes.begin(), spec_.nodes.end());
    std::reverse(spec_.edges.begin(), spec_.edges.end());
    std::reverse(spec_.subchains.begin(), spec_.subchains.end());
    std::reverse(spec_.objective.begin(), spec_.objective.end());
  }

  void draw_core_kinds(int cores) {
    for (int left = cores, kind = 0; left > 0; ++kind) {
      const int count = kind == 2 ? left : 1 + static_cast<int>(uniform(0.0, 0.999) * left);
      const std::string name(1, static_cast<char>('A' + kind));
      spec_.core_kinds.push_back({{name, {}}, {count, {}}, {log_uniform(0.3, 2.0), {}}});
      left -= count;
    }
  }

  model::CostTable draw_costs(const graph::App& app) {
    model::CostTable costs(app.graph, Millis{0});
    for (const Drawn& subchain : subchains_) {
      const double part = subchain.second.empty() ? 1.0 : uniform(0.2, 0.8);
      const auto set = [&](const std::string& name, double cost) {
        costs.set(*app.graph.find_node(name), model::CostProfile::constant(Millis{cost}));
      };
      set(subchain.head, part * subchain.cost);
      if (!subchain.second.empty()) set(subchain.second, (1.0 - part) * subchain.cost);
    }
    if (limits_.batches) {
      const NodeId last = *app.graph.find_node(subchains_.back().head);
      costs.set(last, costs[last].with_per_item(uniform(0.01, 0.3) * costs[last].single_thread()));
    }
    if (limits_.kinds) draw_gains(app, costs);
    if (limits_.waits) draw_waits(app, costs);
    return costs;
  }

  // Some nodes gain more by a faster core than others.
  void draw_gains(const graph::App& app, model::CostTable& costs) {
    for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
      const NodeId id(i);
      if (app.graph.node(id).external || chance(0.5)) continue;
      for (std::size_t kind = 0; kind < app.kinds(); ++kind) {
        costs.set_on(id, kind, costs[id].times(uniform(0.7, 1.4) / app.core_kinds[kind].speed));
      }
    }
  }

  void draw_waits(const graph::App& app, model::CostTable& costs) {
    for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
      if (app.graph.nodes()[i].external || chance(0.5)) continue;
      costs.set_wait(NodeId(i), Millis{log_uniform(limits_.min_cost, limits_.max_cost)});
    }
  }

  std::mt19937_64 random_;
  const RandomLimits limits_;
  std::vector<Drawn> subchains_;
  double total_ = 0.0;  // ms, of all of them
  graph::AppSpec spec_;
  std::vector<std::string> edges_;  // that the app has so far
};

inline RandomCase random_case(std::uint64_t seed, const RandomLimits& limits, int cores) {
  return RandomCaseBuilder(seed, limits).build(cores);
}

// Four subchains of which, as the seed has it, some are all that an app may have, on equal cores.
inline RandomCase random_case_of_all_sorts(std::uint64_t seed, int cores) {
  return random_case(seed,
                     {.subchains = 4,
                      .queue = true,
                      .caps = true,
                      .exact = seed % 5 == 0,
                      .bounds = true,
                      .pairs = true,
                      .batches = seed % 2 == 0},
                     cores);
}

class BruteForce {
 public:
  struct Best {
    bool found = false;
    double factor = kInfinity;
    double objective = kInfinity;
  };

  explicit BruteForce(const RandomCase& any)
      : any_(any),
        count_(any.app.graph.subchains().size()),
        costs_(model::costs_by_kind(any.app, any.costs)),
        free_(any.app.cores_by_kind(any.cores)) {
    timings_.resize(count_);
    group_.resize(count_);
    kind_.resize(static_cast<std::size_t>(any.cores));
  }

  Best run() {
    // First the least factor, then the least objective among those that have it.
    for (factor_only_ = true;; factor_only_ = false) {
      partition(0, 0);
      if (!factor_only_) return best_;
      if (!best_.found) return best_;
    }
  }

 private:
  struct Timing {
    double period = 0.0;
    double execution = 0.0;
  };
  static constexpr double kRounding = 1e-9;

  SubchainId id(std::size_t i) const { return SubchainId(i); }
  std::size_t kind(std::size_t i) const { return kind_[static_cast<std::size_t>(group_[i])]; }
  double cost(std::size_t i) const { return costs_[kind(i)].subchain_total(any_.app.graph, id(i)).count(); }

  void partition(std::size_t i, int groups) {
    if (i == count_) return own(0);
    for (int g = 0; g < groups; ++g) {
      group_[i] = g;
      partition(i + 1, groups);
    }
    for (std::size_t kind = 0; groups < any_.cores && kind < free_.size(); ++kind) {
      if (free_[kind] == 0) continue;
      group_[i] = groups;
      kind_[static_cast<std::size_t>(groups)] = kind;
      --free_[kind];
      partition(i + 1, groups + 1);
      ++free_[kind];
    }
  }

  // Gives the spare cores to those that are alone, in every way.
  void own(std::size_t i) {
    if (i == count_) return share(0);
    const bool alone = std::count(group_.begin(), group_.end(), group_[i]) == 1;
    if (!alone) return own(i + 1);
    int& free = free_[kind(i)];
    const int before = free;
    for (int k = 1; k - 1 <= before; ++k) {
      free = before - (k - 1);
      const model::OwnedCores owned = model::owned_cores(any_.app.graph, id(i), costs_[kind(i)], k, any_.slack);
      const plan::PeriodLimits limits = plan::period_limits(any_.app.graph, id(i));
      double period = std::max(owned.period.count(), limits.min.count());
      if (limits.exact) {
        if (period > limits.exact->count() * (1.0 + kRounding)) continue;
        period = limits.exact->count();
      }
      timings_[i] = {period, owned.execution.count()};
      own(i + 1);
    }
    free = before;
  }

  std::vector<std::size_t> members(int g) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < count_; ++i) {
      if (group_[i] == g) found.push_back(i);
    }
    return found;
  }

  void share(int g) {
    if (g == any_.cores) return judge();
    const std::vector<std::size_t> all = members(g);
    if (all.size() < 2) return share(g + 1);
    std::vector<int> every(all.size(), 1);
    choose(g, all, every, 0);
  }

  void choose(int g, const std::vector<std::size_t>& all, std::vector<int>& every, std::size_t at) {
    if (at == all.size()) return frame(g, all, every);
    const double c = cost(all[at]);
    const double min_slice = to_millis(any_.app.scheduler.min_slice).count();
    const int max = plan::takes_batches(any_.app.graph, id(all[at])) || c < min_slice
                        ? 1
                        : static_cast<int>(std::floor(c / min_slice * (1.0 + 1e-12)));
    for (every[at] = 1; every[at] <= max; ++every[at]) choose(g, all, every, at + 1);
  }

  void frame(int g, const std::vector<std::size_t>& all, const std::vector<int>& every) {
    const double usable = 1.0 - any_.slack;
    double busy = 0.0;
    double min = 0.0;
    std::optional<double> exact;
    std::optional<std::size_t> queue;
    for (std::size_t m = 0; m < all.size(); ++m) {
      if (plan::takes_batches(any_.app.graph, id(all[m]))) {
        queue = all[m];
        continue;
      }
      const plan::PeriodLimits limits = plan::period_limits(any_.app.graph, id(all[m]));
      busy += cost(all[m]) / every[m];
      min = std::max(min, limits.min.count() / every[m]);
      if (limits.exact) {
        const double given = limits.exact->count() / every[m];
        if (exact && std::abs(*exact - given) > kRounding * given) return;
        exact = given;
      }
    }
    const auto set = [&](double frame, double queue_period) {
      for (std::size_t m = 0; m < all.size(); ++m) {
        const double period = queue == all[m] ? queue_period : frame * every[m];
        const double share = frame > 0.0 ? frame / period : 1.0;
        const model::SharedTiming timing = model::shared_core(
            {Millis{frame}, share, Millis{share * cost(all[m])}, any_.costs.subchain_wait(any_.app.graph, id(all[m]))},
            plan::period_limits(any_.app.graph, id(all[m])).exact.has_value());
        timings_[all[m]] = {timing.period.count(), timing.execution.count()};
      }
    };
    if (!queue) {
      const double shortest = std::max(busy / usable, min);
      if (exact && shortest > *exact * (1.0 + kRounding)) return;
      set(exact ? *exact : shortest, 0.0);
      return share(g + 1);
    }
    // One free share: convex in the frame, which is narrowed down by thirds (the rest of the app given).
    const double c = cost(*queue);
    const double min_slice = to_millis(any_.app.scheduler.min_slice).count();
    const double max = c < min_slice ? 1.0 : c / min_slice;
    const double cap = plan::period_limits(any_.app.graph, id(*queue)).min.count();
    double low = std::max({(busy + c / max) / usable, min, cap / max});
    double high = std::max(low, 60.0 * (busy + c) / usable);
    const auto at = [&](double frame) {
      const double room = usable - busy / frame;
      set(frame, std::max(c / room, cap));
      const Best before = best_;
      best_ = {};
      share(g + 1);
      const double found = factor_only_ ? best_.factor : best_.objective;
      best_ = before;
      return found;
    };
    for (int third = 0; third < 120; ++third) {
      const double a = low + (high - low) * 0.382;
      const double b = low + (high - low) * 0.618;
      (at(a) <= at(b) ? high : low) = at(a) <= at(b) ? b : a;
    }
    const double frame_found = 0.5 * (low + high);
    set(frame_found, std::max(c / (usable - busy / frame_found), cap));
    share(g + 1);
  }

  void judge() {
    std::vector<model::SubchainTiming> timings;
    for (const Timing& timing : timings_) timings.push_back({Millis{timing.period}, Millis{timing.execution}});
    double objective = 0.0;
    double factor = 1.0;
    for (const graph::Term& term : any_.app.objective) {
      const double value = term.metric == graph::Metric::kPeriod
                               ? model::evaluate_period(any_.app.graph, term.path.front(), timings).count()
                               : model::evaluate_chain(any_.app.graph, term.path, any_.costs, timings).response.count();
      objective += term.weight * value;
      if (term.max) factor = std::max(factor, value / to_millis(*term.max).count());
    }
    for (const graph::Node& node : any_.app.graph.nodes()) {
      if (!node.subchain || !node.min_rate || (node.max_rate && *node.min_rate == *node.max_rate)) continue;
      factor = std::max(factor, timings[node.subchain->index()].period / node.min_rate->period());
    }
    if (factor_only_) {
      if (factor < best_.factor) best_ = {true, factor, kInfinity};
    } else if (factor <= best_.factor * (1.0 + kRounding) && objective < best_.objective) {
      best_.objective = objective;
    }
  }

  const RandomCase& any_;
  std::size_t count_;
  const std::vector<model::CostTable> costs_;  // by kind of cores
  std::vector<int> free_;                      // cores, by kind
  std::vector<std::size_t> kind_;              // of cores, by group
  std::vector<int> group_;
  std::vector<Timing> timings_;
  bool factor_only_ = true;
  Best best_;
};

}  // namespace ctn::planner
