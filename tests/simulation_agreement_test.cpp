// The simulator beside the runtime itself, which runs on a made-up machine in virtual time (os/fake): the same app, the
// same costs, a machine on which scheduling costs nothing. They should agree on how soon each chain responds.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "config/testing/apps.h"
#include "runtime/testing/virtual_session.h"
#include "sim/simulation.h"
#include "sim/testing/outcomes.h"

namespace ctn {
namespace {

using std::chrono::seconds;

const char* const kRobotCosts =
    "scan: { cost: 2ms, typical: 1.7ms }\nsteer: { cost: 4ms, typical: 3ms, spikes: [0.01, 3ms] }\n"
    "map: { cost: 40ms, typical: 30ms }\nlog: { cost: 3ms, typical: 2ms }\n";
// The same, where some wait.
const char* const kWaits =
    "scan: { cost: 2ms, typical: 1.7ms, wait: 3ms }\nsteer: { cost: 4ms, typical: 3ms, spikes: [0.01, 3ms] }\n"
    "map: { cost: 40ms, typical: 30ms, wait: [20ms, 15ms] }\nlog: { cost: 3ms, typical: 2ms }\n";
constexpr std::uint64_t kSimulatedSeed = 3;
constexpr Nanos kSimulated = seconds{30};

struct Setting {
  const char* policy;
  int cores;
  const char* costs;
};

class Agreement : public runtime::VirtualSession, public ::testing::WithParamInterface<Setting> {
 protected:
  const graph::App app = in_frames(robot_app());
  const model::Workload work = parse_costs(app, GetParam().costs);
  const std::shared_ptr<const policy::Policy> policy = *policy::make_policy(GetParam().policy);
  const int cores = GetParam().cores;

  Snapshot run() {
    cost = [this](const std::string& node, std::uint64_t number) {
      return work.draw(kSimulatedSeed, *app.graph.find_node(node), number, Nanos{0}).cpu;
    };
    wait = [this](const std::string& node, std::uint64_t number) {
      return work.draw(kSimulatedSeed, *app.graph.find_node(node), number, Nanos{0}).wait;
    };
    open(app, policy, cores);
    return run_for(app.scheduler.bootstrap + policy::kSettle + kSimulated);
  }

  sim::Outcome simulate() const {
    sim::Options options = sim::on_ideal_machine(policy, cores);
    options.machine.limit.reset();
    auto simulation =
        *sim::Simulation::create(app, std::make_unique<sim::DrawnCosts>(app, work, kSimulatedSeed), std::move(options));
    simulation->run_for(simulation->warm_from() - TimePoint{} + kSimulated);
    return simulation->outcome();
  }
};

TEST_P(Agreement, OnResponseTimesAndRates) {
  const Snapshot ran = run();
  const sim::Outcome simulated = simulate();
  ASSERT_EQ(ran.chains.size(), simulated.chains.size());
  for (std::size_t i = 0; i < ran.chains.size(); ++i) {
    const Summary& real = ran.chains[i].response_ms;
    const Summary& virtual_one = simulated.chains[i].response_ms;
    EXPECT_NEAR(virtual_one.mean, real.mean, 0.05 * real.mean) << simulated.chains[i].path;
    EXPECT_NEAR(virtual_one.p50, real.p50, 0.05 * real.p50) << simulated.chains[i].path;
    EXPECT_NEAR(virtual_one.p95, real.p95, 0.08 * real.p95) << simulated.chains[i].path;
  }
  for (const NodeSnapshot& real : ran.nodes) {
    for (const sim::NodeOutcome& node : simulated.nodes) {
      if (node.name != real.name) continue;
      EXPECT_NEAR(node.rate_hz, real.rate_hz, 0.04 * real.rate_hz) << node.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, Agreement,
                         ::testing::Values(Setting{"catan", 1, kRobotCosts}, Setting{"catan", 2, kRobotCosts},
                                           Setting{"fifo", 1, kRobotCosts}));
INSTANTIATE_TEST_SUITE_P(WithWaits, Agreement,
                         ::testing::Values(Setting{"catan", 1, kWaits}, Setting{"catan", 2, kWaits},
                                           Setting{"fifo", 1, kWaits}));

}  // namespace
}  // namespace ctn
