#include "policy/batch_sizes.h"

#include <gtest/gtest.h>

#include "config/testing/apps.h"

namespace ctn::policy {
namespace {

graph::App batches() {
  return parse(R"(
catan: 1
app: batches
nodes: { a: {}, b: { unscheduled: true, period: 5ms }, map: { input: queue }, show: {} }
edges: [ a -> map -> show, b -> map ]
objective: [ { response_time: [a, map, show], weight: 1 } ]
)");
}

class BatchSizesTest : public ::testing::Test {
 protected:
  NodeId node(const char* name) const { return *app.graph.find_node(name); }
  void give(const char* name, std::uint64_t number, bool emitted = true) {
    record::Run run;
    run.node = node(name);
    run.number = number;
    run.emitted = emitted;
    sizes.ended(run);
  }
  std::size_t take(const char* name, std::vector<record::Consumed> consumed) {
    record::Run run;
    run.node = node(name);
    run.consumed = std::move(consumed);
    return sizes.taken_by(run);
  }

  const graph::App app = batches();
  BatchSizes sizes{app.graph};
};

TEST_F(BatchSizesTest, ItemsAreOutputsOfAllPredecessors) {
  EXPECT_EQ(take("map", {}), 0U);
  for (std::uint64_t run = 1; run <= 3; ++run) give("a", run);
  give("b", 1);
  EXPECT_EQ(take("map", {{node("a"), 1, 2}, {node("b"), 1, 1}}), 3U);
  EXPECT_EQ(take("map", {{node("a"), 3, 3}}), 1U);
  EXPECT_EQ(take("map", {}), 0U);
}

TEST_F(BatchSizesTest, RunsWithoutOutputAreNoItems) {
  for (std::uint64_t run = 1; run <= 10; ++run) give("a", run, run % 5 == 0);
  EXPECT_EQ(take("map", {{node("a"), 1, 10}}), 2U);
}

TEST_F(BatchSizesTest, WhoTakesTheNewestHasNoBatch) {
  give("map", 1);
  give("map", 2);
  EXPECT_EQ(take("show", {{node("map"), 2, 2}}), 0U);
}

TEST_F(BatchSizesTest, WhatComesWhileARunIsUnderWayIsOfTheNext) {
  give("a", 1);
  give("a", 2);
  EXPECT_EQ(take("map", {{node("a"), 1, 1}}), 1U);
  EXPECT_EQ(take("map", {{node("a"), 2, 2}}), 1U);
}

}  // namespace
}  // namespace ctn::policy
