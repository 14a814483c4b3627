// The policies that Catan is compared with, in the whole runtime and in virtual time, with threads that compete for
// CPUs: every figure exact. Compute times are given as they are.
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "baselines/davare.h"
#include "baselines/policies.h"
#include "baselines/verucchi.h"
#include "os/fake/fake_os.h"
#include "policy/test_app.h"
#include "runtime/engine.h"
#include "runtime/testing/planned_rates.h"

namespace ctn::api {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// A fast loop, a slow one that feeds it, and a node that takes batches.
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

class LiveBaselines : public ::testing::Test {
 protected:
  LiveBaselines() {
    fake.share_cpus(true);
    for (const auto& [name, each] : costs) {
      known.set(*app.graph.find_node(name), model::CostProfile::constant(to_millis(each)));
    }
  }

  Snapshot run_for(Nanos duration, const char* method, int cpus) {
    std::vector<int> numbers;
    for (int cpu = 0; cpu < cpus; ++cpu) numbers.push_back(cpu);
    auto engine = runtime::Engine::create(app, fake,
                                          {.policy = baselines::make_baseline(method, method, known).policy,
                                           .cpus = os::CpuSet(numbers),
                                           .record = {},
                                           .note = {},
                                           .on_notice = {}});
    EXPECT_TRUE(engine.ok());
    for (const auto& [name, each] : costs) {
      (*engine)->wiring().set_body(name, [this, each = each](ctn::Run&) { fake.burn(each); });
    }
    const Status started = (*engine)->start();
    EXPECT_TRUE(started.ok()) << started.error().message();
    fake.sleep_until(fake.now() + duration);
    Snapshot snapshot = (*engine)->snapshot();
    EXPECT_TRUE((*engine)->stop().ok());
    return snapshot;
  }

  static double rate(const Snapshot& snapshot, const std::string& node) {
    for (const NodeSnapshot& each : snapshot.nodes) {
      if (each.name == node) return each.rate_hz;
    }
    return 0.0;
  }

  os::FakeOs fake{os::fake_topology(2)};
  graph::App app = parse(kRobot);
  std::map<std::string, Nanos> costs{
      {"scan", milliseconds{2}}, {"steer", milliseconds{4}}, {"map", milliseconds{40}}, {"log", milliseconds{3}}};
  model::CostTable known{app.graph, Millis{0}};
};

// 50 Hz x 6 ms, 5 Hz x 40 ms and 20 Hz x 3 ms fit one core. The fast chain is of most weight, so nobody is before it.
TEST_F(LiveBaselines, ChainAwarePrioritiesKeepTheHeaviestChainFast) {
  const Snapshot snapshot = run_for(seconds{10}, "picas", 1);
  EXPECT_TRUE(snapshot.notices.empty());
  EXPECT_NEAR(rate(snapshot, "scan"), 50.0, 0.5);
  EXPECT_NEAR(rate(snapshot, "map"), 5.0, 0.2);
  EXPECT_LT(rate(snapshot, "log"), 20.0) << "the least of all: a run of map overtakes some of its triggers";
  EXPECT_NEAR(snapshot.chains[0].response_ms.max, 26.0, 1e-6);
}

// What is measured stays within what the method promises, and near its rates.
TEST_F(LiveBaselines, PeriodsByDavareKeepTheirBounds) {
  for (const int cpus : {1, 2}) {
    const auto plan = baselines::plan_by_davare(app, known, {cpus, 0.06, 0});
    ASSERT_TRUE(plan.ok());
    const Snapshot snapshot = run_for(seconds{20}, "davare", cpus);
    for (std::size_t chain = 0; chain < 2; ++chain) {
      EXPECT_LE(snapshot.chains[chain].response_ms.max, plan->chains[chain].response.count() + 1e-6) << cpus;
      // At least a period and what the chain's nodes cost.
      const double period = plan->subchains[chain].period.count();
      EXPECT_GE(snapshot.chains[chain].response_ms.max, period + (chain == 0 ? 2.0 + 4.0 : 40.0 + 4.0) - 1e-5) << cpus;
    }
    runtime::expect_planned_rates(app, snapshot, *plan);
  }
}

TEST_F(LiveBaselines, RatesByVerucchiAreKept) {
  const auto plan = baselines::plan_by_verucchi(app, known, {1, 0.06, 0});
  ASSERT_TRUE(plan.ok());
  const Snapshot snapshot = run_for(seconds{20}, "verucchi", 1);
  runtime::expect_planned_rates(app, snapshot, *plan);
}

}  // namespace
}  // namespace ctn::api
