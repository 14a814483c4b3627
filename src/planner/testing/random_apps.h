// Random apps of several subchains, for tests and benchmarks.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/mixed.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "model/cost.h"

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
  // Unscheduled nodes, which begin chains, and one that follows the first of them. With `exclusive` they are in the
  // group, with the first subchain alone or with all.
  int drivers = 0;
  // A period of theirs is as long as so many of the longest runs that a subchain or one of them may have, at least.
  double driver_periods = 20.0;
  bool threads = false;         // some nodes may use two or three threads
  bool output_periods = false;  // some nodes give outputs less often than they run
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
    if (limits_.drivers > 0) draw_drivers();
    draw_totals();
    set_inputs();
    draw_rates();
    draw_bounds();
    if (limits_.threads) draw_threads();
    if (limits_.output_periods) draw_output_periods();
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

  // Each begins a chain, and so does what follows the first.
  void draw_drivers() {
    for (int i = 0; i <= limits_.drivers; ++i) {
      const std::string name = "driver" + std::to_string(i);
      const bool follows = i == limits_.drivers;
      graph::NodeSpec& driver = spec_.nodes.emplace_back();
      driver.name.value = name;
      driver.unscheduled = true;
      if (follows) {
        add_edges("driver0 " + name);
      } else {
        driver.period =
            graph::At<Nanos>{to_nanos(Millis{uniform(1.0, 2.0) * limits_.driver_periods * limits_.max_cost}), {}};
      }
      const std::string path = name + " " + draw_path();
      add_edges(path);
      spec_.objective.push_back(graph::response(path, weight()));
      drivers_.push_back(name);
    }
  }

  void draw_threads() {
    for (graph::NodeSpec& any : spec_.nodes) {
      if (!any.external && !any.unscheduled)
        any.max_threads = graph::At<int>{1 + static_cast<int>(uniform(0.0, 2.99)), {}};
    }
  }

  void draw_output_periods() {
    for (graph::NodeSpec& any : spec_.nodes) {
      if (any.external || chance(0.5)) continue;
      any.output_period = graph::At<Nanos>{to_nanos(Millis{uniform(0.5, 6.0) * total_}), {}};
    }
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
    const bool one_or_all = !drivers_.empty();
    const bool one = one_or_all && chance(0.5);
    for (std::size_t i = 0; i < subchains_.size(); ++i) {
      const bool in = one_or_all ? i == 0 || !one : i < 2 || chance(0.5);
      if (in) nodes.push_back({subchains_[i].head, {}});
    }
    for (const std::string& driver : drivers_) nodes.push_back({driver, {}});
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
    for (const std::string& driver : drivers_) {
      const double cost = uniform(0.1, 1.0) * limits_.max_cost;
      costs.set(*app.graph.find_node(driver), model::CostProfile::constant(Millis{cost}));
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
  std::vector<std::string> edges_;    // that the app has so far
  std::vector<std::string> drivers_;  // unscheduled nodes
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

}  // namespace ctn::planner
