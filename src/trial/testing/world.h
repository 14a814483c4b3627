// For tests: small apps whose runs always cost the same, on a machine where scheduling costs nothing.
#pragma once

#include <fmt/format.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/testing/times.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "trial/trial.h"

namespace ctn::trial {

// "0-2 10-12": each node's runs, in milliseconds.
class Timeline : public Observer {
 public:
  explicit Timeline(const graph::App& app) : app_(app) {}
  void ended(const ObservedRun& run) override {
    std::string& text = of_[app_.graph.node(run.node).name];
    text += fmt::format("{}{:g}-{:g}", text.empty() ? "" : " ", to_millis(run.begin.time_since_epoch()).count(),
                        to_millis(run.end.time_since_epoch()).count());
    emitted_[app_.graph.node(run.node).name] += run.emitted ? 'x' : '.';
  }
  std::string operator[](const std::string& node) { return of_[node]; }
  std::string emitted(const std::string& node) { return emitted_[node]; }

 private:
  const graph::App& app_;
  std::map<std::string, std::string> of_;
  std::map<std::string, std::string> emitted_;
};

// An app of the spec's nodes and edges, whose runs always cost the same.
struct World {
  World(const graph::AppSpec& spec, const std::vector<std::pair<std::string, double>>& costs_ms)
      : app(graph::build_app(spec).value()), costs(app.graph, Millis{0}) {
    for (const auto& [name, cost] : costs_ms) {
      costs.set(*app.graph.find_node(name), model::CostProfile::constant(Millis{cost}));
    }
  }

  // `clocks`: by NodeId.
  Figures run(const Schedule& schedule, Nanos horizon, const std::vector<Ticks>& clocks = {}) {
    const Samples samples(app, MeasuredRuns{}, costs);
    return Trial(app, samples)
        .run(schedule, {.horizon = horizon,
                        .warm_up = Nanos{0},
                        .p95 = true,
                        .overheads = Overheads::none(),
                        .clocks = clocks,
                        .observer = &timeline});
  }
  void wait(const std::string& node, double wait_ms) { costs.set_wait(*app.graph.find_node(node), Millis{wait_ms}); }
  void runs_per_output(const std::string& node, double runs) {
    costs.set_runs_per_output(*app.graph.find_node(node), runs);
  }
  SubchainId subchain(const std::string& name) const { return *app.graph.find_subchain(name); }

  graph::App app;
  model::CostTable costs;
  Timeline timeline{app};
};

inline Schedule on_cores(int cores, std::vector<Place> places) {
  return {.cores = cores, .subchains = std::move(places), .frames = {}, .pipelines = {}};
}

inline graph::AppSpec two() {
  graph::AppSpec spec = graph::spec_of({"a", "b"}, {"a b"});
  spec.objective = {graph::response("a b", 1.0), graph::period("b", 0.5)};
  return spec;
}

}  // namespace ctn::trial
