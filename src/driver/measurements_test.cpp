#include "driver/measurements.h"

#include <gtest/gtest.h>

#include "base/testing/times.h"
#include "config/testing/apps.h"

namespace ctn::driver {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

using Measured = Measurements<record::AllSamples>;

graph::App two_nodes() {
  return parse(R"(
catan: 1
app: two
nodes: { a: {}, b: {} }
edges: [ a -> b ]
subchains: { ab: [a, b] }
objective: [ { response_time: [a, b], weight: 1 } ]
)");
}

// Run k of each node, begun at 100 ms x k; a takes 10 ms, b the next 20.
void add_runs(Measured& measurements, std::uint64_t from, std::uint64_t to) {
  for (std::uint64_t k = from; k <= to; ++k) {
    const TimePoint begin = at(milliseconds{100 * k});
    const record::Run runs[] = {{NodeId(0), k, begin, begin + milliseconds{10}, milliseconds{10}, 0, true, {}},
                                {NodeId(1),
                                 k,
                                 begin + milliseconds{10},
                                 begin + milliseconds{30},
                                 milliseconds{20},
                                 0,
                                 true,
                                 {{NodeId(0), k, k}}}};
    for (const record::Run& run : runs) measurements.ran(run);
  }
}

TEST(Measurements, LeavesOutWhatGoesBackToTheWarmUp) {
  const graph::App app = two_nodes();
  Measured measurements(app, at(seconds{1}));
  add_runs(measurements, 1, 19);
  Snapshot snapshot;
  measurements.fill(snapshot, at(seconds{2}), app, 10.0);
  EXPECT_TRUE(snapshot.warmed_up);
  // Sources begun at 1.0 to 1.9 s; the first has no predecessor within.
  EXPECT_EQ(snapshot.chains[0].response_ms.count, 9U);
  EXPECT_DOUBLE_EQ(snapshot.chains[0].response_ms.mean, 130.0);
  EXPECT_DOUBLE_EQ(snapshot.chains[0].latency_ms.max, 30.0);
  EXPECT_DOUBLE_EQ(snapshot.nodes[1].rate_hz, 10.0);
  EXPECT_DOUBLE_EQ(snapshot.nodes[1].compute_ms.p50, 20.0);
  EXPECT_EQ(snapshot.source_hz, 10.0);
}

plan::Plan predicting(double response, Rate rate) {
  plan::Plan plan;
  plan.subchains.emplace_back().period = rate.period();
  plan.chains.push_back({.path = {NodeId(0), NodeId(1)}, .response = Millis{response}});
  return plan;
}

TEST(Measurements, AveragesPredictionsOverTheTimeTheyWereInForce) {
  const graph::App app = two_nodes();
  Measured measurements(app, at(seconds{2}));
  measurements.plan_in_force(at(seconds{0}), predicting(1000.0, Rate{2.0}));  // over before the measured interval
  measurements.plan_in_force(at(seconds{1}), predicting(100.0, Rate{20.0}));  // of which 2 s count
  measurements.plan_in_force(at(seconds{4}), predicting(200.0, Rate{10.0}));  // 6 s
  Snapshot snapshot;
  measurements.fill(snapshot, at(seconds{10}), app, std::nullopt);
  EXPECT_DOUBLE_EQ(*snapshot.chains[0].predicted_response_ms, (100.0 * 2 + 200.0 * 6) / 8);
  EXPECT_DOUBLE_EQ(snapshot.source_hz, (20.0 * 2 + 10.0 * 6) / 8);
}

TEST(Measurements, BeforeTheMeasuredIntervalThePlanInForceIsTold) {
  const graph::App app = two_nodes();
  Measured measurements(app, at(seconds{2}));
  measurements.plan_in_force(at(seconds{0}), predicting(100.0, Rate{20.0}));
  Snapshot snapshot;
  measurements.fill(snapshot, at(seconds{1}), app, std::nullopt);
  EXPECT_FALSE(snapshot.warmed_up);
  EXPECT_DOUBLE_EQ(*snapshot.chains[0].predicted_response_ms, 100.0);
}

TEST(Measurements, ShowsWhatThePlanInForceRelaxesAndAssumes) {
  const graph::App app = two_nodes();
  Measured measurements(app, at(seconds{2}));
  plan::Plan plan = predicting(50.0, Rate{20.0});
  plan.relax_factor = 1.25;
  plan.relaxed.push_back({"objective[0].max", Millis{40}, Millis{50}});
  plan.assumed.push_back({NodeId(1), Millis{5}});
  measurements.plan_in_force(at(seconds{0}), plan);
  Snapshot shown;
  measurements.fill(shown, at(seconds{1}), app, std::nullopt);
  EXPECT_EQ(shown.relax_factor, 1.25);
  ASSERT_EQ(shown.relaxed.size(), 1U);
  EXPECT_EQ(shown.relaxed[0].bound, "objective[0].max");
  EXPECT_EQ(shown.relaxed[0].asked_ms, 40.0);
  EXPECT_EQ(shown.relaxed[0].planned_ms, 50.0);
  ASSERT_EQ(shown.assumed.size(), 1U);
  EXPECT_EQ(shown.assumed[0].node, "b");
  EXPECT_EQ(shown.assumed[0].cost_ms, 5.0);
  measurements.no_plan_in_force();
  Snapshot without;
  measurements.fill(without, at(seconds{3}), app, std::nullopt);
  EXPECT_EQ(without.relax_factor, 1.0);
  EXPECT_TRUE(without.relaxed.empty());
  EXPECT_TRUE(without.assumed.empty());
}

}  // namespace
}  // namespace ctn::driver
