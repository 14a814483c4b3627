// Policies of others in virtual time, on a machine where scheduling costs nothing.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "baselines/policies.h"
#include "config/testing/apps.h"
#include "sim/simulation.h"
#include "sim/testing/outcomes.h"
#include "sim/whatif.h"

namespace ctn::baselines {
namespace {

using std::chrono::seconds;

const char* const kReserved = "a: 3ms\nb: 4ms\n";

using sim::node;

sim::Options options_for(const Baseline& baseline) {
  sim::Options options = sim::on_ideal_machine(baseline.policy);
  options.reserve = baseline.reserve;
  return options;
}

// Runs cost as `costs` says; reservations are for what kReserved says.
sim::Outcome simulate(const std::string& costs) {
  const graph::App app = two_rates_app();
  const model::Workload work = parse_costs(app, costs);
  const model::CostTable known = parse_costs(app, kReserved).costs(app.graph);
  return *sim::simulate(app, std::make_unique<sim::DrawnCosts>(app, work, 1),
                        options_for(make_baseline("deadline", "deadline", known)), seconds{20});
}

// a is done by the end of its period, whatever b does; so a response takes two periods at most.
TEST(SimulatedReservations, BoundResponses) {
  const sim::Outcome outcome = simulate("a: 3ms\nb: 4ms\n");
  EXPECT_LE(outcome.chains[0].response_ms.max, 20.0);
  EXPECT_LE(outcome.chains[1].response_ms.max, 40.0);
  EXPECT_NEAR(node(outcome, "a").rate_hz, 100.0, 0.1);
  EXPECT_NEAR(node(outcome, "b").rate_hz, 50.0, 0.1);
}

// b costs four times what its reservation (4.4 of 20 ms) was made for.
TEST(SimulatedReservations, KeepAnOverrunToItself) {
  const sim::Outcome outcome = simulate("a: 3ms\nb: 16ms\n");
  EXPECT_LE(outcome.chains[0].response_ms.max, 20.0);
  EXPECT_NEAR(node(outcome, "a").rate_hz, 100.0, 0.1);
  EXPECT_LE(node(outcome, "b").rate_hz, 0.22 * 1000.0 / 16.0 + 0.1);
  EXPECT_LE(outcome.cores.front().real_time, 0.3 + 0.22 + 0.001);
}

TEST(SimulatedReservations, NeedCosts) {
  sim::Options options = options_for(make_baseline("deadline", "deadline", {}));
  const graph::App app = two_rates_app();
  const model::Workload work = parse_costs(app, kReserved);
  const auto run = [&] {
    return sim::simulate(app, std::make_unique<sim::DrawnCosts>(app, work, 1), options, seconds{5});
  };
  const auto refused = run();
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message().find("deadline:COSTS.yaml"), std::string::npos);
  options.costs = work.costs(app.graph);
  const auto outcome = run();
  ASSERT_TRUE(outcome.ok());
  EXPECT_NEAR(node(*outcome, "a").rate_hz, 100.0, 0.3);
}

TEST(WhatIf, GivesPoliciesThatDecideByCostsThoseOfTheHypothesis) {
  const graph::App app = two_rates_app();
  const model::Workload work = parse_costs(app, kReserved);
  sim::WhatIfOptions options;
  options.policy = make_baseline("davare", "davare", {}).policy;
  options.seconds = 5.0;
  const auto answers = sim::answer(app, work, {{.cores = 1}, {.cores = 1, .speed = 2.0}}, options);
  ASSERT_TRUE(answers.ok());
  ASSERT_TRUE(answers->front().simulated) << answers->front().why_not;
  ASSERT_TRUE(answers->back().simulated) << answers->back().why_not;
  EXPECT_LT(answers->back().simulated->chains.front().period_ms.mean,
            answers->front().simulated->chains.front().period_ms.mean);
}

}  // namespace
}  // namespace ctn::baselines
