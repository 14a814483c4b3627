#include "contest_apps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>

#include "base/mixed.h"
#include "config/cost_file.h"

namespace ctn::bench {
namespace {

constexpr std::uint64_t kApps = 300;

double utilisation_by_hand(const Case& of) {
  const model::CostTable costs = of.work.costs(of.app.graph);
  double sum = 0.0;
  for (std::size_t i = 0; i < of.app.graph.subchains().size(); ++i) {
    const SubchainId id(i);
    sum += costs.subchain_total(of.app.graph, id) /
           of.app.graph.node(of.app.graph.subchain(id).head()).fallback_rate->period();
  }
  return sum;
}

// Results name apps by their seeds, so these must stay what they are, here and on other machines. Where a change is
// meant, the figures of docs/benchmarks.md are of other apps.
TEST(ContestApps, OfASeedAreTheSameForEver) {
  std::uint64_t print = 0;
  for (std::uint64_t seed = 1; seed <= kApps; ++seed) {
    const AppFiles files = random_app(seed);
    for (const char letter : files.app + files.costs + files.load) print = mixed_of(print, letter);
  }
  EXPECT_EQ(print, 12704505207355943784U);
}

TEST(ContestApps, AreAcceptedAndWithinTheirRanges) {
  std::set<std::size_t> sizes;
  std::set<std::size_t> chains;
  double min = 1e9;
  double max = 0.0;
  for (std::uint64_t seed = 1; seed <= kApps; ++seed) {
    SCOPED_TRACE(seed);
    const Case of = case_of(random_app(seed));
    const graph::Graph& graph = of.app.graph;
    sizes.insert(graph.subchains().size());
    for (const graph::Subchain& subchain : graph.subchains()) {
      EXPECT_LE(subchain.nodes.size(), 3U);
      EXPECT_TRUE(graph.node(subchain.head()).fallback_rate.has_value());
    }
    for (std::size_t i = 0; i < graph.nodes().size(); ++i) {
      const model::NodeWork& work = of.work[NodeId(i)];
      const double cost = work.cost.single_thread().count();
      min = std::min(min, cost);
      max = std::max(max, cost);
      EXPECT_LE(work.spikes.extra.count(), 150.0);
    }
    std::size_t responses = 0;
    for (const graph::Term& term : of.app.objective) {
      responses += term.metric == graph::Metric::kResponseTime ? 1 : 0;
      EXPECT_GE(term.weight, 0.005);
      EXPECT_LE(term.weight, 1.0);
    }
    chains.insert(responses);
    const double busy = utilisation_by_hand(of);
    EXPECT_LE(busy, 0.7);
    EXPECT_GE(busy, 0.5);
  }
  EXPECT_EQ(*sizes.begin(), 2U);
  EXPECT_EQ(*sizes.rbegin(), 12U);
  EXPECT_EQ(*chains.begin(), 2U);
  EXPECT_EQ(*chains.rbegin(), 5U);
  EXPECT_GE(min, 0.3);
  EXPECT_LE(min, 0.33);
  EXPECT_LE(max, 150.0);
  EXPECT_GE(max, 140.0);
}

TEST(ContestApps, CountWithEveryNodesSubchain) {
  for (std::uint64_t seed = 1; seed <= kApps; ++seed) {
    const Case of = case_of(random_app(seed));
    std::set<SubchainId> counted;
    for (const graph::Term& term : of.app.objective) {
      if (term.metric != graph::Metric::kResponseTime) continue;
      for (const NodeId node : term.path) counted.insert(*of.app.graph.node(node).subchain);
    }
    EXPECT_EQ(counted.size(), of.app.graph.subchains().size()) << "seed " << seed;
  }
}

TEST(ContestApps, PlanWithTheCostsOfTheirLoad) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const AppFiles files = random_app(seed);
    const Case of = case_of(files);
    const auto costs = config::parse_costs(files.costs, "costs.yaml", of.app);
    ASSERT_TRUE(costs.ok()) << costs.error().message();
    const model::CostTable known = of.work.costs(of.app.graph);
    for (std::size_t i = 0; i < of.app.graph.nodes().size(); ++i) {
      EXPECT_EQ((*costs)[NodeId(i)].single_thread().count(), known[NodeId(i)].single_thread().count());
    }
  }
}

}  // namespace
}  // namespace ctn::bench
