// Plans of costs that were measured, and what it is to follow their rates: whole ways from file to file.
#include "catan/planning.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "catan/simulation.h"

namespace ctn::api {
namespace {

using std::chrono::seconds;

// `work` costs 12 ms and from the 100th run on 4 ms; every second one of its runs gives an output.
constexpr const char* kShrinks = R"(
catan: 1
app: shrinks
nodes: { read: { fallback_rate: 10Hz }, work: {}, act: { fallback_rate: 10Hz } }
edges: [ read -> work -> act ]
subchains: { front: [read, work] }
objective: [ { response_time: [read, work, act], weight: 1 } ]
scheduler: { slack: 6%, bootstrap: 1s }
)";

class PlanningTest : public ::testing::Test {
 protected:
  PlanningTest() { write(app, kShrinks); }
  ~PlanningTest() override {
    for (const std::string& file : {app, costs, record, plan}) std::remove(file.c_str());
  }

  static std::string path(const std::string& name) {
    return ::testing::TempDir() + "catan_planning_" + std::to_string(getpid()) + "_" + name;
  }
  static void write(const std::string& file, const std::string& text) { std::ofstream(file) << text; }

  Snapshot simulate(const std::string& policy, int cores, const std::string& record_to = "") const {
    SimulationOptions options;
    options.policy = policy;
    options.cores = cores;
    options.record = record_to;
    options.ideal = true;
    auto simulation = Simulation::open(app, options);
    EXPECT_TRUE(simulation.ok()) << (simulation.ok() ? "" : simulation.error().message());
    if (!simulation) return {};
    using std::chrono::milliseconds;
    simulation->node("read", [](ctn::Run& run) { run.charge(milliseconds{1}); });
    simulation->node("work", [](ctn::Run& run) {
      run.charge(run.number() < 100 ? milliseconds{12} : milliseconds{4});
      if (run.number() % 2 == 0) run.skip_output();
    });
    simulation->node("act", [](ctn::Run& run) { run.charge(milliseconds{2}); });
    EXPECT_TRUE(simulation->run_for(seconds{30}).ok());
    EXPECT_TRUE(simulation->finish().ok());
    return simulation->snapshot();
  }

  nlohmann::json plan_by(const std::string& file, int cores = 1) const {
    const auto text = make_plan(app, {.costs = file, .cores = cores, .effort = 0.01});
    EXPECT_TRUE(text.ok()) << (text.ok() ? "" : text.error().message());
    return text.ok() ? nlohmann::json::parse(*text) : nlohmann::json();
  }

  std::string app = path("app.yaml");
  std::string costs = path("costs.yaml");
  std::string record = path("run.catan");
  std::string plan = path("plan.json");
};

TEST_F(PlanningTest, ByARecordAllItsRunsCount) {
  simulate("default", 1, record);  // some 300 runs of work, of which a third cost 12 ms
  const nlohmann::json by_record = plan_by(record);
  write(costs, "read: 1ms\nwork: 12ms\nact: 2ms\n");
  const nlohmann::json by_costs = plan_by(costs);
  // The 95th percentile is of all runs, not of the last; that every second one gives an output only the record says.
  EXPECT_GE(by_record["subchains"]["front"]["execution_ms"].get<double>(), 13.0);
  EXPECT_EQ(by_record["outputs"].size(), 1U);
  EXPECT_EQ(by_costs.value("outputs", nlohmann::json::array()).size(), 0U);
  EXPECT_EQ(by_record, plan_by(record)) << "the same files, the same plan";
}

TEST_F(PlanningTest, APlansRatesAreFollowedUnderOrdinaryScheduling) {
  write(costs, "read: 1ms\nwork: 20ms\nact: 2ms\n");
  const auto text = make_plan(app, {.costs = costs, .cores = 1, .effort = 0.01});
  ASSERT_TRUE(text.ok()) << text.error().message();
  write(plan, *text);
  const Snapshot followed = simulate("static:" + plan, 1);
  const Snapshot by_hand = simulate("rates-of:" + plan, 2);
  const double expected =
      1e3 / nlohmann::json::parse(*text)["expected"]["subchains"]["front"]["period_ms"].get<double>();
  EXPECT_GT(expected, 20.0);
  ASSERT_GE(by_hand.nodes.size(), 2U);
  for (std::size_t node = 0; node < 2; ++node) {
    EXPECT_NEAR(by_hand.nodes[node].rate_hz, expected, 0.02 * expected) << "whatever its runs take";
  }
  EXPECT_FALSE(by_hand.chains.front().predicted_response_ms) << "nothing is promised";
  EXPECT_TRUE(followed.chains.front().predicted_response_ms);
  EXPECT_EQ(by_hand.plans, 0U);
}

TEST_F(PlanningTest, MistakesAreTold) {
  const auto message = [&](const PlanningOptions& options) {
    const auto made = make_plan(app, options);
    EXPECT_FALSE(made.ok());
    return made.ok() ? "" : made.error().message();
  };
  EXPECT_NE(message({.costs = "/nowhere/costs.yaml", .cores = 1}).find("/nowhere/costs.yaml"), std::string::npos);
  write(costs, "read: 1ms\nwork: 1ms\nact: 1ms\n");
  EXPECT_NE(message({.costs = costs, .cores = 1, .effort = 0.0}).find("effort"), std::string::npos);
  EXPECT_NE(message({.costs = costs, .cores = 4096, .effort = 0.01}).find("4096"), std::string::npos);
  EXPECT_FALSE(make_plan("/nowhere/app.yaml", {.costs = costs}).ok());
  // A record of a run that was over before any node had run.
  SimulationOptions options;
  options.record = record;
  auto simulation = Simulation::open(app, options);
  ASSERT_TRUE(simulation.ok());
  ASSERT_TRUE(simulation->finish().ok());
  EXPECT_NE(message({.costs = record, .cores = 1}).find("no run of node work"), std::string::npos);
}

}  // namespace
}  // namespace ctn::api
