// Nodes that need input, in virtual time: callbacks of messages behind a camera of 25 Hz.
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "config/testing/apps.h"
#include "sim/simulation.h"
#include "sim/testing/outcomes.h"

namespace ctn::sim {
namespace {

// image and show are called for messages of the camera and of image; watch looks at the camera by a timer.
graph::App viewer(const std::string& camera = "external: true, period: 40ms") {
  return parse(R"(
catan: 1
app: viewer
nodes:
  camera: { )" +
               camera +
               R"( }
  image: { fallback_rate: 100Hz, ros: { node: /driver, topic: /raw } }
  show: { fallback_rate: 200Hz, ros: { node: /viewer, topic: /image } }
  watch: { fallback_rate: 50Hz, ros: { node: /watch, timer: 20ms } }
edges: [ camera -> image -> show, camera -> watch ]
objective:
  - { response_time: [camera, image, show], weight: 1 }
  - { response_time: [camera, watch], weight: 0.1 }
scheduler: { slack: 0%, bootstrap: 1s }
)");
}
constexpr const char* kCosts = "image: 2ms\nshow: 1ms\nwatch: 1ms\n";

TEST(SimulatedInputs, RunAsOftenAsMessagesComeWhateverTheTriggers) {
  for (const char* policy : {"default", "fifo"}) {
    for (const int cores : {1, 2}) {
      SCOPED_TRACE(testing::Message() << policy << " on " << cores);
      const Outcome outcome = simulate(viewer(), kCosts, policy, cores);
      EXPECT_NEAR(node(outcome, "image").rate_hz, 25.0, 0.2);
      EXPECT_NEAR(node(outcome, "show").rate_hz, 25.0, 0.2);
      EXPECT_NEAR(node(outcome, "watch").rate_hz, 50.0, 0.2) << "a timer needs none";
      EXPECT_LE(outcome.chains[0].latency_ms.max, 20.0) << "who waits for a message runs when it comes";
    }
  }
}

TEST(SimulatedInputs, AreNotHeldBackWhereNobodySaysWhenMessagesCome) {
  const Outcome outcome = simulate(viewer("external: true"), kCosts, "fifo", 2);
  EXPECT_NEAR(node(outcome, "image").rate_hz, 100.0, 0.2);
  EXPECT_NEAR(node(outcome, "show").rate_hz, 100.0, 0.2) << "it waits for image alone";
}

TEST(SimulatedInputs, OfAnUnscheduledDriverComeAsOftenAsItGivesOutput) {
  const Outcome outcome = simulate(viewer("unscheduled: true, period: 10ms, output_period: 50ms"), kCosts, "fifo", 2);
  EXPECT_NEAR(node(outcome, "image").rate_hz, 20.0, 0.2);
  EXPECT_NEAR(node(outcome, "show").rate_hz, 20.0, 0.2);
}

// The planner asks for no more than comes, and is right about what it gets.
TEST(SimulatedInputs, ArePlannedAsOftenAsTheyCome) {
  for (const int cores : {1, 2}) {
    SCOPED_TRACE(cores);
    auto simulation = simulation_of(viewer(), kCosts, "catan", cores);
    simulation->run_for(std::chrono::seconds{30});
    const graph::App app = viewer();
    ASSERT_TRUE(simulation->plan().has_value());
    const plan::Plan& plan = *simulation->plan();
    const Outcome outcome = simulation->outcome();
    for (const char* name : {"image", "show"}) {
      SCOPED_TRACE(name);
      const std::size_t index = app.graph.find_subchain(name)->index();
      EXPECT_GE(plan.subchains[index].period, Millis{39.9});
      EXPECT_LE(node(outcome, name).rate_hz, 25.1);
      if (plan.expected) {
        EXPECT_NEAR(plan.expected->subchains[index].period.count() * node(outcome, name).rate_hz, 1000.0, 30.0);
      }
    }
  }
}

}  // namespace
}  // namespace ctn::sim
