// Nodes that run when others have given something, in virtual time, worked by hand.
#include <gtest/gtest.h>

#include <string>

#include "config/testing/apps.h"
#include "sim/simulation.h"
#include "sim/testing/outcomes.h"

namespace ctn::sim {
namespace {

// A sensor, what follows it, and what follows that; the consumer takes its time.
graph::App followers(const std::string& of_imu = "", const std::string& of_sum = "") {
  return parse(R"(
catan: 1
app: followers
nodes:
  imu: { unscheduled: true, period: 4ms)" +
               of_imu + R"( }
  sum: { unscheduled: true)" +
               of_sum + R"( }
  guess: { unscheduled: true }
  fuse: { fallback_rate: 10Hz }
edges: [ imu -> sum -> guess -> fuse ]
objective:
  - { response_time: [guess, fuse], weight: 1 }
  - { response_time: [imu, sum], weight: 0.1 }
  - { response_time: [imu, sum, guess], weight: 0.1 }
scheduler: { bootstrap: 1s }
)");
}

TEST(SimulatedFollowers, FollowersTakeWhatWasGivenThisInstant) {
  for (const char* policy : {"default", "fifo", "catan"}) {
    for (const int cores : {1, 3}) {
      SCOPED_TRACE(testing::Message() << policy << " on " << cores);
      const Outcome outcome = simulate(followers(), "imu: 0.1ms\nsum: 0.2ms\nguess: 0.3ms\nfuse: 1ms\n", policy, cores);
      for (const char* name : {"imu", "sum", "guess"}) EXPECT_NEAR(node(outcome, name).rate_hz, 250.0, 0.1) << name;
      if (cores == 1 && policy == std::string("default")) continue;  // fuse may be in between
      EXPECT_DOUBLE_EQ(outcome.chains[1].latency_ms.max, 0.3);
      EXPECT_DOUBLE_EQ(outcome.chains[2].latency_ms.max, 0.6);
      EXPECT_DOUBLE_EQ(outcome.chains[2].response_ms.max, 4.6);
    }
  }
}

TEST(SimulatedFollowers, WhoHasAPeriodOfItsOwnFollowsNoOther) {
  const Outcome outcome =
      simulate(followers("", ", period: 4ms"), "imu: 0.1ms\nsum: 0.2ms\nguess: 0.3ms\nfuse: 1ms\n", "default", 3);
  EXPECT_DOUBLE_EQ(outcome.chains[1].latency_ms.max, 4.2) << "both begin at once, so it has the output before";
}

TEST(SimulatedFollowers, FollowersRunOnOutputAlone) {
  const Outcome outcome =
      simulate(followers(", output_period: 20ms"), "imu: 0.1ms\nsum: 0.2ms\nguess: 0.3ms\nfuse: 1ms\n", "default", 2);
  EXPECT_NEAR(node(outcome, "imu").rate_hz, 250.0, 0.1);
  EXPECT_NEAR(node(outcome, "sum").rate_hz, 50.0, 0.1);
  EXPECT_NEAR(node(outcome, "guess").rate_hz, 50.0, 0.1);
}

// What comes while it is busy makes one run more, of what is newest then: sum runs without a pause.
TEST(SimulatedFollowers, ABusyFollowerRunsOnceMore) {
  const Outcome outcome = simulate(followers(), "imu: 0.1ms\nsum: 10ms\nguess: 0.3ms\nfuse: 1ms\n", "default", 3);
  EXPECT_NEAR(node(outcome, "sum").rate_hz, 100.0, 0.1);
  EXPECT_NEAR(node(outcome, "guess").rate_hz, 100.0, 0.1);
  EXPECT_GE(outcome.chains[1].latency_ms.p50, 10.1);
  EXPECT_LE(outcome.chains[1].latency_ms.max, 14.1);
  const Outcome queued =
      simulate(followers("", ", input: queue"), "imu: 0.1ms\nsum: 10ms\nguess: 0.3ms\nfuse: 1ms\n", "default", 3);
  EXPECT_NEAR(node(queued, "sum").rate_hz, 100.0, 0.1);
  EXPECT_NEAR(static_cast<double>(queued.chains[1].latency_ms.count), 5000.0, 5.0) << "each output is used";
}

}  // namespace
}  // namespace ctn::sim
