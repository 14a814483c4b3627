// For tests: a whole session in virtual time, on a made-up machine of two CPUs for which threads compete. What a run
// costs is what the test says, to the nanosecond.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "model/cost.h"
#include "os/fake/fake_os.h"
#include "runtime/engine.h"

namespace ctn::runtime {

inline os::CpuSet first_cpus(int count) {
  std::vector<int> numbers;
  for (int cpu = 0; cpu < count; ++cpu) numbers.push_back(cpu);
  return os::CpuSet(std::move(numbers));
}

class VirtualSession : public ::testing::Test {
 protected:
  VirtualSession() { fake.share_cpus(true); }

  // On the first `cpus` CPUs; every node that is not external has a body that costs what `cost` says.
  void open(graph::App app, std::shared_ptr<const policy::Policy> policy, int cpus, const std::string& record = {}) {
    auto made = Engine::create(std::move(app), fake,
                               {.policy = std::move(policy),
                                .cpus = first_cpus(cpus),
                                .record = record,
                                .note = {},
                                .on_notice = [this](const std::string& notice) { on_notice(notice); }});
    ASSERT_TRUE(made.ok()) << made.error().message();
    engine = std::move(*made);
    for (const graph::Node& node : engine->app().graph.nodes()) {
      if (node.external) continue;
      engine->wiring().set_body(node.name, [this, name = node.name](ctn::Run& run) {
        const Nanos cpu = cost(name, run.number());
        const Nanos waits = wait(name, run.number());
        const Nanos rest = waits > Nanos{0} ? cpu / 2 : Nanos{0};
        fake.burn(cpu - rest);
        if (waits > Nanos{0}) {
          fake.sleep_until(fake.now() + waits);
          fake.burn(rest);
        }
        if (silent(name, run.number())) run.skip_output();
      });
    }
  }
  void start() {
    const Status started = engine->start();
    ASSERT_TRUE(started.ok()) << started.error().message();
  }
  void pass(Nanos duration) { fake.sleep_until(fake.now() + duration); }

  // From the start to the stop.
  Snapshot run_for(Nanos duration) {
    start();
    pass(duration);
    Snapshot snapshot = engine->snapshot();
    EXPECT_TRUE(engine->stop().ok());
    return snapshot;
  }

  static double rate(const Snapshot& snapshot, const std::string& node) {
    for (const NodeSnapshot& each : snapshot.nodes) {
      if (each.name == node) return each.rate_hz;
    }
    return 0.0;
  }

  // `costs`, as planning knows them.
  model::CostTable known_costs(const graph::App& app) const {
    model::CostTable table(app.graph, Millis{0});
    for (const auto& [name, each] : costs) {
      table.set(*app.graph.find_node(name), model::CostProfile::constant(to_millis(each)));
    }
    return table;
  }

  os::FakeOs fake{os::fake_topology(2)};
  std::map<std::string, Nanos> costs;  // by node
  std::function<Nanos(const std::string& node, std::uint64_t run)> cost =
      [this](const std::string& node, std::uint64_t /*run*/) { return costs.at(node); };
  // What a run waits, after half of its CPU time.
  std::function<Nanos(const std::string& node, std::uint64_t run)> wait =
      [](const std::string& /*node*/, std::uint64_t /*run*/) { return Nanos{0}; };
  std::function<bool(const std::string& node, std::uint64_t run)> silent = [](const std::string& /*node*/,
                                                                              std::uint64_t /*run*/) { return false; };
  std::function<void(const std::string&)> on_notice = [](const std::string&) {};
  std::unique_ptr<Engine> engine;  // after `fake`: it goes first
};

// What runs of robot_app() cost.
inline std::map<std::string, Nanos> robot_costs() {
  using std::chrono::milliseconds;
  return {{"scan", milliseconds{2}}, {"steer", milliseconds{4}}, {"map", milliseconds{40}}, {"log", milliseconds{3}}};
}

}  // namespace ctn::runtime
