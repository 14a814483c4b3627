// The public simulation: an app file, a cost file and the simulator (sim/simulation.h).
#include "catan/simulation.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "api/policies.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "runtime/connections.h"
#include "sim/simulation.h"

namespace ctn {
namespace {

sim::Options simulator_options(const SimulationOptions& options, const graph::App& app, api::SimulatedPolicy policy) {
  sim::Options chosen;
  chosen.policy = std::move(policy.policy);
  chosen.reserve = std::move(policy.reserve);
  chosen.machine.cores = options.cores != 0 ? options.cores : app.core_count().value_or(1);
  chosen.machine.real_time = options.real_time;
  if (options.ideal) {
    chosen.machine.costs = sim::MachineCosts::none();
    chosen.machine.limit.reset();
  }
  chosen.stealing = options.stealing;
  chosen.replan = options.replan;
  if (options.fixed_frames) {
    chosen.frames = *options.fixed_frames ? graph::FrameMode::kFixed : graph::FrameMode::kElastic;
  }
  if (!options.record.empty()) chosen.recording = {options.record, options.note};
  return chosen;
}

// By NodeId; without a period where nothing is said.
Result<std::vector<Ticks>> ticks_of(const std::vector<SimulatedClock>& clocks, const graph::Graph& graph) {
  std::vector<Ticks> ticks(graph.nodes().size());
  std::vector<Problem> problems;
  for (const SimulatedClock& clock : clocks) {
    const std::optional<NodeId> node = graph.find_node(clock.node);
    if (!node || !graph.node(*node).has_clock()) {
      problems.push_back({{},
                          {},
                          fmt::format("a clock of '{}', which {}", clock.node, node ? "has none" : "is no node"),
                          "name an external node with a period, or an unscheduled one that follows no other"});
    } else if (ticks[node->index()].period > Nanos{0}) {
      problems.push_back({{}, {}, fmt::format("two clocks of node {}", clock.node), "leave one out"});
    } else if (clock.first < Nanos{0} || clock.period <= Nanos{0}) {
      problems.push_back({{},
                          {},
                          fmt::format("the clock of node {} ticks first at {} ns, then each {} ns", clock.node,
                                      clock.first.count(), clock.period.count()),
                          "give a first tick from 0 on, and a period above 0"});
    } else {
      ticks[node->index()] = {TimePoint{} + clock.first, clock.period};
    }
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return ticks;
}

// By NodeId.
Result<std::vector<double>> slowdowns_of(const SimulationOptions& options, const graph::Graph& graph) {
  std::vector<Problem> problems;
  const auto check = [&problems](double slowdown, const std::string& of) {
    if (slowdown > 0.0 && std::isfinite(slowdown)) return;
    problems.push_back({{}, {}, fmt::format("a slowdown of {}{}", slowdown, of), "give a number above 0"});
  };
  check(options.slowdown, "");
  std::vector<double> slowdowns(graph.nodes().size(), options.slowdown);
  for (const auto& [name, slowdown] : options.slowdowns) {
    check(slowdown, " of node " + name);
    const std::optional<NodeId> node = graph.find_node(name);
    if (node) {
      slowdowns[node->index()] *= slowdown;
    } else {
      problems.push_back({{}, {}, fmt::format("a slowdown of '{}', which is no node", name), "leave it out"});
    }
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return slowdowns;
}

// Of a cost file, if there is one.
Result<config::PartialWorkload> load_costs(const std::string& file, const graph::App& app) {
  if (!file.empty()) return config::load_partial_workload(file, app);
  return config::PartialWorkload{model::Workload(app.graph), std::vector<bool>(app.graph.nodes().size(), false)};
}

}  // namespace

class Simulation::Impl {
 public:
  // `costs_given`: by NodeId, for which nodes a cost file says something.
  Impl(graph::App app, std::unique_ptr<sim::Simulation> simulation, std::vector<bool> costs_given)
      : app_(std::move(app)),
        costs_given_(std::move(costs_given)),
        simulation_(std::move(simulation)),
        connections_(app_, [this](NodeId consumer, std::size_t input, ChannelBase& channel) {
          simulation_->use_channel(consumer, input, channel);
        }) {}

  void set_body(std::string_view name, std::function<void(Run&)> body) { connections_.set_body(name, std::move(body)); }
  void set_effect(std::string_view name, std::function<void(Run&)> effect) {
    connections_.set_effect(name, std::move(effect));
  }
  ChannelBase& open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                            MakeChannel make) {
    return connections_.open_channel(from, to, queue, type, make);
  }

  const sim::Simulation& simulation() const { return *simulation_; }

  Status run_for(Nanos duration) {
    if (running_)
      return Error::caller("run_for() was called from a node's function", "return from it, time then goes on");
    if (duration < Nanos{0}) {
      return Error::caller(fmt::format("time cannot go back ({} ns)", duration.count()), "give a duration from 0 on");
    }
    if (Status checked = connections_.check(false); !checked) return checked;
    if (!started_) {
      if (Status known = check_costs(); !known) return known;
      hand_over();
      connections_.close("time has begun to pass", "call it before run_for()");
      started_ = true;
    }
    running_ = true;
    simulation_->run_for(duration);
    running_ = false;
    for (std::string& misuse : connections_.take_misuses()) {
      connections_.add_problem(std::move(misuse), "pass values along the app's edges");
    }
    if (Status used = connections_.check(false); !used) return used;
    return simulation_->status();
  }

  Status finish() { return simulation_->finish(); }

  Snapshot snapshot() const {
    Snapshot snapshot = simulation_->snapshot();
    for (const auto& [edge, count] : connections_.dropped()) {
      snapshot.notices.push_back(fmt::format("lost: {} values on {}: their reader did not keep up", count, edge));
    }
    return snapshot;
  }

 private:
  // A node without a function cannot charge its runs.
  Status check_costs() const {
    std::vector<Problem> problems;
    for (std::size_t index = 0; index < app_.graph.nodes().size(); ++index) {
      const graph::Node& node = app_.graph.nodes()[index];
      if (node.external || node.unscheduled || costs_given_[index] || connections_.body(NodeId(index))) continue;
      problems.push_back({{},
                          {},
                          fmt::format("node {} has neither a cost nor a function that could charge one", node.name),
                          fmt::format("say in a cost file what its runs cost, as in {}: 1.2ms", node.name)});
    }
    if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
    return Done{};
  }

  void hand_over() {
    for (std::size_t index = 0; index < app_.graph.nodes().size(); ++index) {
      const NodeId node(index);
      if (connections_.body(node)) simulation_->set_body(node, connections_.body(node));
      if (connections_.effect(node)) simulation_->set_effect(node, connections_.effect(node));
    }
  }

  graph::App app_;
  std::vector<bool> costs_given_;
  std::unique_ptr<sim::Simulation> simulation_;
  runtime::Connections connections_;
  bool started_ = false;
  bool running_ = false;
};

Result<Simulation> Simulation::open(const std::string& app_file, const SimulationOptions& options) {
  Result<graph::App> app = config::load_app(app_file, config::RunBy::kFunctions);
  if (!app) return app.error();
  Result<config::PartialWorkload> costs = load_costs(options.costs, *app);
  if (!costs) return costs.error();
  Result<api::SimulatedPolicy> policy = api::simulated_policy(options.policy, *app);
  if (!policy) return policy.error();
  Result<std::vector<double>> slowdowns = slowdowns_of(options, app->graph);
  if (!slowdowns) return slowdowns.error();
  Result<std::vector<Ticks>> clocks = ticks_of(options.clocks, app->graph);
  if (!clocks) return clocks.error();
  sim::Options chosen = simulator_options(options, *app, std::move(*policy));
  chosen.phases.clocks = std::move(*clocks);
  auto simulation = sim::Simulation::create(
      *app, std::make_unique<sim::DrawnCosts>(*app, costs->work, options.seed, std::move(*slowdowns), costs->given),
      chosen);
  if (!simulation) return simulation.error();
  return Simulation(std::make_unique<Impl>(std::move(*app), std::move(*simulation), std::move(costs->given)));
}

Simulation::Simulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

void Simulation::node(std::string_view name, std::function<void(Run&)> body) { impl_->set_body(name, std::move(body)); }

void Simulation::on_effect(std::string_view name, std::function<void(Run&)> effect) {
  impl_->set_effect(name, std::move(effect));
}

ChannelBase& Simulation::open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                                      MakeChannel make) {
  return impl_->open_channel(from, to, queue, type, make);
}

std::chrono::nanoseconds Simulation::now() const { return impl_->simulation().now() - TimePoint{}; }
std::chrono::nanoseconds Simulation::warm_from() const { return impl_->simulation().warm_from() - TimePoint{}; }

Status Simulation::run_for(std::chrono::nanoseconds duration) { return impl_->run_for(duration); }

Status Simulation::finish() { return impl_->finish(); }

Snapshot Simulation::snapshot() const { return impl_->snapshot(); }

}  // namespace ctn
