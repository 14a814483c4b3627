// The simulator beside the runtime itself, which runs on a made-up machine in virtual time (os/fake): the same app, the
// same costs, a machine on which scheduling costs nothing. They should agree on how soon each chain responds.
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/cost_file.h"
#include "os/fake/fake_os.h"
#include "policy/test_app.h"
#include "runtime/engine.h"
#include "sim/simulation.h"

namespace ctn {
namespace {

using std::chrono::seconds;

const char* const kRobot = R"(
catan: 1
app: robot
nodes:
  scan: { fallback_rate: 50Hz }
  steer: {}
  map: { fallback_rate: 5Hz }
  log: { input: queue, fallback_rate: 20Hz }
edges: [ scan -> steer, scan -> map -> steer, scan -> log ]
subchains: { fast: [scan, steer] }
objective:
  - { response_time: [scan, steer], weight: 1 }
  - { response_time: [map, steer], weight: 0.05 }
  - { period: log, weight: 0.05 }
scheduler: { bootstrap: 1s }
)";
const char* const kCosts =
    "scan: { cost: 2ms, typical: 1.7ms }\nsteer: { cost: 4ms, typical: 3ms, spikes: [0.01, 3ms] }\n"
    "map: { cost: 40ms, typical: 30ms }\nlog: { cost: 3ms, typical: 2ms }\n";
constexpr std::uint64_t kSeed = 3;
constexpr Nanos kMeasured = seconds{30};

class Agreement : public ::testing::TestWithParam<std::pair<const char*, int>> {
 protected:
  const graph::App app = parse(kRobot);
  const model::Workload work = *config::parse_workload(kCosts, "costs.yaml", app);
  const std::shared_ptr<const policy::Policy> policy = *policy::make_policy(GetParam().first);
  const int cores = GetParam().second;

  Snapshot run() const {
    os::FakeOs fake{os::fake_topology(2)};
    fake.share_cpus(true);
    std::vector<int> cpus{0};
    if (cores == 2) cpus.push_back(1);
    auto engine = runtime::Engine::create(
        app, fake, {.policy = policy, .cpus = os::CpuSet(cpus), .record = {}, .note = {}, .on_notice = {}});
    EXPECT_TRUE(engine.ok());
    for (std::size_t index = 0; index < app.graph.nodes().size(); ++index) {
      (*engine)->wiring().set_body(app.graph.nodes()[index].name, [&, index](ctn::Run& run) {
        fake.burn(work.draw(kSeed, NodeId(index), run.number(), Nanos{0}).cpu);
      });
    }
    EXPECT_TRUE((*engine)->start().ok());
    fake.sleep_until(fake.now() + app.scheduler.bootstrap + policy::kSettle + kMeasured);
    Snapshot snapshot = (*engine)->snapshot();
    EXPECT_TRUE((*engine)->stop().ok());
    return snapshot;
  }

  sim::Outcome simulate() const {
    sim::Options options{.policy = policy};
    options.machine.cores = cores;
    options.machine.costs = sim::MachineCosts::none();
    options.machine.limit.reset();
    auto simulation =
        *sim::Simulation::create(app, std::make_unique<sim::DrawnCosts>(app, work, kSeed), std::move(options));
    simulation->run_for(simulation->warm_from() - TimePoint{} + kMeasured);
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
                         ::testing::Values(std::pair{"catan", 1}, std::pair{"catan", 2}, std::pair{"fifo", 1}));

}  // namespace
}  // namespace ctn
