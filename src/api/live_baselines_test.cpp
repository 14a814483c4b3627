// The policies that Catan is compared with, in the whole runtime and in virtual time, with threads that compete for
// CPUs: every figure exact. Compute times are given as they are.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>

#include "baselines/davare.h"
#include "baselines/policies.h"
#include "baselines/verucchi.h"
#include "config/testing/apps.h"
#include "policy/hand_set.h"
#include "policy/planned.h"
#include "runtime/testing/planned_rates.h"
#include "runtime/testing/virtual_session.h"

namespace ctn::api {
namespace {

using std::chrono::seconds;

class LiveBaselines : public runtime::VirtualSession {
 protected:
  LiveBaselines() { costs = runtime::robot_costs(); }

  Snapshot run_method(Nanos duration, const char* method, int cpus) {
    open(app, baselines::make_baseline(method, method, known_costs(app)).policy, cpus);
    return run_for(duration);
  }

  graph::App app = robot_app();
};

// 50 Hz x 6 ms, 5 Hz x 40 ms and 20 Hz x 3 ms fit one core. The fast chain is of most weight, so nobody is before it.
TEST_F(LiveBaselines, ChainAwarePrioritiesKeepTheHeaviestChainFast) {
  const Snapshot snapshot = run_method(seconds{10}, "picas", 1);
  EXPECT_TRUE(snapshot.notices.empty());
  EXPECT_NEAR(rate(snapshot, "scan"), 50.0, 0.5);
  EXPECT_NEAR(rate(snapshot, "map"), 5.0, 0.2);
  EXPECT_LT(rate(snapshot, "log"), 20.0) << "the least of all: a run of map overtakes some of its triggers";
  EXPECT_NEAR(snapshot.chains[0].response_ms.max, 26.0, 1e-6);
}

// What is measured stays within what the method promises, and near its rates.
TEST_F(LiveBaselines, PeriodsByDavareKeepTheirBounds) {
  for (const int cpus : {1, 2}) {
    const auto plan = baselines::plan_by_davare(app, known_costs(app), {cpus, 0.06, 0});
    ASSERT_TRUE(plan.ok());
    const Snapshot snapshot = run_method(seconds{20}, "davare", cpus);
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
  const auto plan = baselines::plan_by_verucchi(app, known_costs(app), {1, 0.06, 0});
  ASSERT_TRUE(plan.ok());
  const Snapshot snapshot = run_method(seconds{20}, "verucchi", 1);
  runtime::expect_planned_rates(app, snapshot, *plan);
}

// On one core planned, on two set by hand.
TEST_F(LiveBaselines, APlansRatesAreKeptUnderOrdinaryScheduling) {
  const os::CpuSet one{0};
  const model::CostTable known = known_costs(app);
  const auto decision =
      policy::FormulaPolicy().decide({.app = app, .cpus = one, .costs = known, .typical = known, .slack = 0.06});
  ASSERT_TRUE(decision.ok()) << decision.error().message();
  const plan::Plan& plan = *decision->plan;
  open(app, std::make_shared<policy::PlannedRatesPolicy>("rates-of:plan.json", plan), 2);
  const Snapshot snapshot = run_for(seconds{20});
  EXPECT_EQ(snapshot.policy, "rates-of:plan.json");
  EXPECT_FALSE(snapshot.chains[0].predicted_response_ms) << "nothing is promised";
  for (std::size_t index = 0; index < plan.subchains.size(); ++index) {
    const graph::Subchain& subchain = app.graph.subchain(SubchainId(index));
    const double planned = 1000.0 / plan::usual_timing(plan, SubchainId(index)).period.count();
    EXPECT_NEAR(rate(snapshot, app.graph.node(subchain.head()).name), planned, 0.02 * planned) << subchain.name;
  }
}

}  // namespace
}  // namespace ctn::api
