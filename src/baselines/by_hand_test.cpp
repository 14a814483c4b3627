// What is done with rates that are set by hand: chain-aware priorities, reservations.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "baselines/picas.h"
#include "baselines/reservations.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "planner/testing/random_apps.h"

namespace ctn::baselines {
namespace {

using testing::ElementsAre;

// Two chains that end in the same node: a b d, and c d.
graph::AppSpec fork() {
  graph::AppSpec spec = graph::spec_of({"a", "b", "c", "d", "e", "out"}, {"a b d out", "c d", "e d"});
  node(spec, "out").external = true;
  spec.subchains = {graph::subchain("ab", "a b")};
  spec.objective = {graph::response("c d out", 0.1), graph::response("a b d out", 1.0)};
  return spec;
}

TEST(Picas, LaterNodesOfHeavierChainsComeFirst) {
  const graph::App app = graph::build_app(fork()).value();
  const model::CostTable costs(app.graph, Millis{1});
  const std::vector<Rate> rates(app.graph.subchains().size(), Rate{10.0});
  const ChainAware found = assign_by_chains(app, costs, rates, 2);
  // a, b, c, d, e, out
  EXPECT_THAT(found.rank, ElementsAre(2, 3, 1, 4, 0, -1));
  const auto core = [&](const char* name) { return found.core[app.graph.find_subchain(name)->index()]; };
  EXPECT_EQ(core("ab"), core("d"));
  EXPECT_EQ(core("c"), core("d")) << "where the rest of its chain is, as there is room";
}

TEST(Picas, WhatDoesNotFitTogetherIsSpread) {
  const graph::App app = graph::build_app(fork()).value();
  const model::CostTable costs(app.graph, Millis{40});
  const std::vector<Rate> rates(app.graph.subchains().size(), Rate{10.0});
  const ChainAware found = assign_by_chains(app, costs, rates, 2);
  EXPECT_NEAR(found.utilisations[0] + found.utilisations[1], 2.0, 1e-9);
  const auto core = [&](const char* name) { return found.core[app.graph.find_subchain(name)->index()]; };
  EXPECT_NE(core("ab"), core("d")) << "0.8 and 0.4 of a core";
}

TEST(Picas, EveryNodeHasARankWhateverTheApp) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    planner::RandomLimits limits;
    limits.pairs = true;
    limits.kinds = seed % 2 == 0;
    const planner::RandomCase any = planner::random_case(seed, limits, 1 + static_cast<int>(seed % 4));
    const std::vector<Rate> rates(any.app.graph.subchains().size(), Rate{25.0});
    const ChainAware found = assign_by_chains(any.app, any.costs, rates, any.cores);
    std::vector<bool> taken(any.app.graph.nodes().size(), false);
    for (std::size_t i = 0; i < taken.size(); ++i) {
      EXPECT_EQ(found.rank[i] >= 0, any.app.graph.nodes()[i].subchain.has_value());
      if (found.rank[i] < 0) continue;
      EXPECT_FALSE(taken[static_cast<std::size_t>(found.rank[i])]);
      taken[static_cast<std::size_t>(found.rank[i])] = true;
    }
    for (const int core : found.core) EXPECT_TRUE(core >= 0 && core < any.cores);
  }
}

TEST(Reservations, AreTheCostWithAMarginInEveryPeriod) {
  const graph::App app = graph::build_app(fork()).value();
  const model::CostTable costs(app.graph, Millis{4});
  const std::vector<Rate> rates(app.graph.subchains().size(), Rate{10.0});
  const Reservations found = reserve(app, costs, rates, 1);
  EXPECT_TRUE(found.admitted);
  EXPECT_NEAR(found.asked, 5 * 0.044, 1e-9);
  EXPECT_EQ(found.nodes[0].runtime, std::chrono::microseconds{4400});
  EXPECT_EQ(found.nodes[0].period, std::chrono::milliseconds{100});
  EXPECT_EQ(found.nodes[5], sim::Reservation{}) << "external";
}

TEST(Reservations, RatesAreLoweredUntilTheyFit) {
  const graph::App app = graph::build_app(fork()).value();
  const model::CostTable costs(app.graph, Millis{40});
  const std::vector<Rate> rates(app.graph.subchains().size(), Rate{10.0});
  const Reservations found = reserve(app, costs, rates, 1);
  EXPECT_FALSE(found.admitted);
  EXPECT_NEAR(found.factor, 2.2 / 0.95, 1e-9);
  double used = 0.0;
  for (const sim::Reservation& node : found.nodes) {
    if (node.period > Nanos{0}) used += to_millis(node.runtime) / to_millis(node.period);
  }
  EXPECT_LE(used, 0.95);
  EXPECT_NEAR(used, 0.95, 1e-6);
}

// No thread can have more than a core.
TEST(Reservations, ARunFitsItsPeriod) {
  const graph::App app = graph::build_app(fork()).value();
  const model::CostTable costs(app.graph, Millis{200});
  const std::vector<Rate> rates(app.graph.subchains().size(), Rate{10.0});
  const Reservations found = reserve(app, costs, rates, 64);
  EXPECT_NEAR(found.factor, 2.2, 1e-9);
  for (const sim::Reservation& node : found.nodes) EXPECT_LE(node.runtime, node.period);
}

}  // namespace
}  // namespace ctn::baselines
