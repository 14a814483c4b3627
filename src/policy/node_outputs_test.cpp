#include "policy/node_outputs.h"

#include <gtest/gtest.h>

#include <chrono>

#include "base/testing/times.h"
#include "config/testing/apps.h"

namespace ctn::policy {
namespace {

using std::chrono::microseconds;

class NodeOutputsTest : public testing::Test {
 protected:
  // A run of the node that took the newest of these outputs of its input; 0: none yet.
  static record::Run run_of(NodeId node, NodeId input, std::uint64_t newest, bool emitted) {
    record::Run run;
    run.node = node;
    run.emitted = emitted;
    if (newest > 0) run.consumed = {{input, newest, newest}};
    return run;
  }

  const graph::App app_ = parse(R"(
catan: 1
app: detector
nodes: { camera: {}, lidar: { external: true, period: 100ms }, detect: {}, fuse: {}, plan: {} }
edges:
  - camera -> detect
  - lidar -> fuse
  - detect -> fuse
  - { path: camera -> plan, max_age: 50ms, on_stale: skip }
objective: [ { response_time: [camera, detect], weight: 1 } ]
)");
  const NodeId camera_ = *app_.graph.find_node("camera");
  const NodeId lidar_ = *app_.graph.find_node("lidar");
  const NodeId detect_ = *app_.graph.find_node("detect");
  const NodeId fuse_ = *app_.graph.find_node("fuse");
  const NodeId plan_ = *app_.graph.find_node("plan");
};

TEST_F(NodeOutputsTest, ASourceCountsEachRun) {
  NodeOutputs outputs(app_.graph, camera_);
  for (int number = 1; number <= 100; ++number) outputs.add(run_of(camera_, camera_, 0, number % 2 == 0));
  EXPECT_EQ(outputs.runs_per_output(), 2.0);
}

// It runs three times as often as its input comes, and gives an output for every second one.
TEST_F(NodeOutputsTest, RunsThatFoundNothingNewTellNothing) {
  NodeOutputs outputs(app_.graph, detect_);
  for (std::uint64_t number = 1; number <= 300; ++number) {
    outputs.add(run_of(detect_, camera_, 1 + number / 3, number % 6 == 0));
  }
  EXPECT_EQ(outputs.runs_per_output(), 2.0);
}

TEST_F(NodeOutputsTest, OutputsWithoutAnythingNewAreOutputs) {
  NodeOutputs outputs(app_.graph, detect_);
  for (std::uint64_t number = 1; number <= 300; ++number) outputs.add(run_of(detect_, camera_, 1 + number / 3, true));
  EXPECT_EQ(outputs.runs_per_output(), 1.0);
}

TEST_F(NodeOutputsTest, WhatAnExternalNodeHasNewIsNotKnown) {
  NodeOutputs outputs(app_.graph, fuse_);
  for (std::uint64_t number = 1; number <= 300; ++number) outputs.add(run_of(fuse_, detect_, 1, number % 3 == 0));
  EXPECT_EQ(outputs.runs_per_output(), 3.0);
}

// The lidar turns ten times a second; this runs three times as often, and gives an output of each second turn.
TEST_F(NodeOutputsTest, OnceItsClockHasTickedAnExternalNodeHasSomethingNew) {
  NodeOutputs outputs(app_.graph, fuse_);
  outputs.set_clock(lidar_, {at_ms(5), ms(100)});
  outputs.set_clock(detect_, {at_ms(0), ms(1)});
  for (std::uint64_t number = 0; number < 300; ++number) {
    record::Run run = run_of(fuse_, detect_, 1, number % 6 == 1);
    run.begin = at(number * ms(100) / 3);
    run.cpu = run.emitted ? ms(5) : Nanos{microseconds{40}};
    const bool found = number == 0 || number % 3 == 1;
    EXPECT_EQ(outputs.add(run), !found) << number;
  }
  EXPECT_EQ(outputs.runs_per_output(), 2.0);
  EXPECT_EQ(outputs.idle(), (model::IdleRuns{1.0, Millis{0.04}}));
}

TEST_F(NodeOutputsTest, RunsThatFindNothingNewAreIdleIfTheyGiveNothing) {
  NodeOutputs outputs(app_.graph, detect_);
  for (std::uint64_t number = 1; number <= 400; ++number) {
    const bool idle = number % 4 == 0;
    EXPECT_EQ(outputs.add(run_of(detect_, camera_, 1 + number / 2, !idle)), false) << "each second one finds something";
    EXPECT_EQ(outputs.add(run_of(detect_, camera_, 1 + number / 2, !idle)), idle);
  }
  EXPECT_NEAR(outputs.idle().part, 1.0 / 6.0, 0.1);
}

TEST_F(NodeOutputsTest, WhoHadToSkipSinceItsInputWasOldWouldHaveGivenOne) {
  NodeOutputs outputs(app_.graph, plan_);
  for (std::uint64_t number = 1; number <= 300; ++number) {
    record::Run run = run_of(plan_, camera_, number, number % 2 == 0);
    run.ages = {run.emitted ? Nanos{0} : Nanos{std::chrono::milliseconds{51}}};
    outputs.add(run);
  }
  EXPECT_EQ(outputs.runs_per_output(), 1.0);
}

}  // namespace
}  // namespace ctn::policy
