// Nodes within a subchain at rates of their own, worked by hand, on a machine where scheduling costs nothing. The
// runtime has the same test (runtime/fallback_rates_test.cpp).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "sim/testing/outcomes.h"

namespace ctn::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;

using Begins = std::map<std::string, std::vector<double>>;  // ms, by node

Begins begins_of(const std::string& policy, int cores, Nanos duration) {
  const graph::App app = own_rates_app();
  auto simulation = simulation_of(app, kOwnRatesCosts, policy, cores);
  Begins begins;
  for (std::size_t index = 0; index < app.graph.nodes().size(); ++index) {
    simulation->set_body(NodeId(index), [&, index](ctn::Run&) {
      const TimePoint now = simulation->now();
      begins[app.graph.nodes()[index].name].push_back(to_millis(now.time_since_epoch()).count());
    });
  }
  simulation->run_for(duration);
  return begins;
}

TEST(FallbackRates, OfNodesWithinASubchainAreKeptByTime) {
  const Begins begins = begins_of("default", 4, milliseconds{299});
  EXPECT_THAT(begins.at("scan"), ElementsAre(0, 50, 100, 150, 200, 250));
  EXPECT_THAT(begins.at("LM"), ElementsAre(0, 200));
  EXPECT_THAT(begins.at("LP"), ElementsAre(0, 100, 200));
  EXPECT_THAT(begins.at("push"), ElementsAre(3, 103, 203)) << "it has none: LP triggers it";
}

// LM takes, at 400 ms, the scan of 350 ms, which LP takes at 500: push is done with it at 504. The scan before that
// came so far was that of 150 ms.
TEST(FallbackRates, MakeRunsTakeTheNewestOfTheirPredecessors) {
  const Outcome outcome = simulate(own_rates_app(), kOwnRatesCosts, "default", 4);
  EXPECT_DOUBLE_EQ(outcome.chains.front().response_ms.mean, 354.0);
  EXPECT_DOUBLE_EQ(outcome.chains.front().response_ms.max, 354.0);
  EXPECT_DOUBLE_EQ(outcome.chains.front().period_ms.mean, 200.0);
  EXPECT_NEAR(node(outcome, "scan").rate_hz, 20.0, 0.06);
  EXPECT_NEAR(node(outcome, "LM").rate_hz, 5.0, 0.06);
  EXPECT_NEAR(node(outcome, "LP").rate_hz, 10.0, 0.06);
  EXPECT_NEAR(node(outcome, "push").rate_hz, 10.0, 0.06);
}

// On one core, in this order: scan, LM, LP and push. So all of 400 ms is done by 410; what came before was that of 200.
TEST(FallbackRates, AreKeptAtFixedPrioritiesToo) {
  const Begins begins = begins_of("fifo", 1, milliseconds{299});
  EXPECT_THAT(begins.at("LM"), ElementsAre(2, 202));
  EXPECT_THAT(begins.at("LP"), ElementsAre(6, 102, 206));
  EXPECT_THAT(begins.at("push"), ElementsAre(9, 105, 209));
  const Outcome outcome = simulate(own_rates_app(), kOwnRatesCosts, "fifo", 1);
  EXPECT_DOUBLE_EQ(outcome.chains.front().response_ms.mean, 210.0);
  EXPECT_DOUBLE_EQ(outcome.chains.front().response_ms.max, 210.0);
}

// One subchain, whatever rates are set by hand: run after run.
TEST(FallbackRates, AreNothingToCatan) {
  const Outcome outcome = simulate(in_frames(own_rates_app()), kOwnRatesCosts, "catan", 1);
  for (const char* const name : {"scan", "LM", "LP", "push"}) EXPECT_NEAR(node(outcome, name).rate_hz, 100.0, 0.06);
  EXPECT_NEAR(outcome.chains.front().response_ms.mean, 20.0, 0.001);
}

}  // namespace
}  // namespace ctn::sim
