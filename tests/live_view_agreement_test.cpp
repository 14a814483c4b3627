// What a view of an app that runs shows (view/live_view.h) beside what the report of its record says afterwards
// (report/metrics.h): the same figures, from two programs. A simulated run of nine seconds, so that all of it is in the
// view's window.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "config/testing/apps.h"
#include "policy/policy.h"
#include "record/reader.h"
#include "report/metrics.h"
#include "sim/simulation.h"
#include "view/live_view.h"

namespace ctn {
namespace {

using std::chrono::seconds;

// Two subchains that take turns, one of which takes batches, and a bound that is not always kept.
constexpr const char* kWatched = R"(
catan: 1
app: watched
nodes: { imu: { unscheduled: true, period: 10ms }, scan: {}, LM: {}, LP: {}, log: { input: queue } }
edges: [ imu -> LM, scan -> LM, scan -> LP, scan -> log ]
subchains: { fast: [scan, LM], slow: [LP] }
objective:
  - { response_time: [scan, LM], weight: 1, max: 25ms }
  - { response_time: [LP], weight: 0.5 }
  - { period: log, weight: 0.1 }
order: [fast, slow, log]
scheduler: { slack: 0%, bootstrap: 1s }
)";
constexpr const char* kWatchedCosts =
    "imu: 100us\nscan: 1ms\nLM: { cost: 4ms, typical: 3ms, spikes: [0.02, 20ms] }\nLP: 5ms\nlog: 500us\n";

void expect_same(const Summary& live, const Summary& afterwards, const std::string& of) {
  EXPECT_GT(afterwards.count, 0U) << of;
  EXPECT_EQ(live.count, afterwards.count) << of;
  EXPECT_NEAR(live.mean, afterwards.mean, 1e-9) << of;
  EXPECT_EQ(live.p50, afterwards.p50) << of;
  EXPECT_EQ(live.p95, afterwards.p95) << of;
  EXPECT_EQ(live.max, afterwards.max) << of;
}

TEST(LiveViewAgreement, ShowsWhatTheReportSays) {
  const graph::App app = in_frames(parse(kWatched));
  const std::string path = testing::TempDir() + fmt::format("live_view_{}.catan", getpid());
  std::remove(path.c_str());
  sim::Options options{.policy = *policy::make_policy("catan")};
  options.recording = {.path = path, .note = {}};
  auto simulation = sim::Simulation::create(
      app, std::make_unique<sim::DrawnCosts>(app, parse_costs(app, kWatchedCosts), 1), std::move(options));
  ASSERT_TRUE(simulation.ok()) << simulation.error().message();
  (*simulation)->run_for(seconds{9});
  ASSERT_TRUE((*simulation)->finish().ok());
  const auto record = record::Reader::open(path);
  ASSERT_TRUE(record.ok()) << record.error().message();
  std::remove(path.c_str());
  const auto report = report::measure(*record, {.whole = true});
  ASSERT_TRUE(report.ok()) << report.error().message();

  view::LiveView view(record->app(), record->header());
  view.add(record::Trigger{SubchainId(0), 0, record->header().started, record->header().started});
  for (const record::PlanChange& change : record->plans().value()) view.add(change);
  ASSERT_TRUE(record->each_run([&](const record::Run& run) { view.add(run); }).ok());
  std::uint64_t steals = 0;
  ASSERT_TRUE(record
                  ->each_steal([&](const record::Steal& steal) {
                    ++steals;
                    view.add(steal);
                  })
                  .ok());
  const TimePoint ended = record->ending().ended;
  const view::Picture picture = view.picture(ended, {.seen_alive = ended, .over = true});

  EXPECT_NEAR(picture.window_s, 9.0, 1e-6);
  ASSERT_EQ(picture.chains.size(), report->chains.size());
  for (std::size_t index = 0; index < picture.chains.size(); ++index) {
    const view::Chain& live = picture.chains[index];
    const report::ChainMetrics& afterwards = report->chains[index];
    EXPECT_EQ(live.path, afterwards.path);
    expect_same(live.response_ms, afterwards.response_ms, live.path);
    expect_same(live.latency_ms, afterwards.latency_ms, live.path);
    expect_same(live.period_ms, afterwards.period_ms, live.path);
  }
  EXPECT_GT(picture.chains[0].over_bound, 0U);
  EXPECT_LT(picture.chains[0].over_bound, picture.chains[0].response_ms.count);
  ASSERT_EQ(picture.nodes.size(), report->nodes.size());
  for (std::size_t index = 0; index < picture.nodes.size(); ++index) {
    const view::Node& live = picture.nodes[index];
    const report::NodeMetrics& afterwards = report->nodes[index];
    EXPECT_EQ(live.name, afterwards.name);
    EXPECT_EQ(live.runs, afterwards.runs) << live.name;
    EXPECT_NEAR(live.cores, afterwards.cores, 1e-6) << live.name;
    expect_same(live.compute_ms, afterwards.compute_ms, live.name);
    expect_same(live.period_ms, afterwards.period_ms, live.name);
  }
  EXPECT_NEAR(*picture.objective, *report->objective.measured, 1e-9);
  EXPECT_GT(steals, 0U);
  EXPECT_EQ(picture.subchains[0].stole + picture.subchains[1].stole + picture.subchains[2].stole, steals);
  double busy = 0.0;
  for (const view::Core& core : picture.cores) busy += core.busy;
  EXPECT_NEAR(busy, report->cores_used, 1e-6);
  EXPECT_EQ(picture.plan->reason, record->plans()->back().reason);
}

}  // namespace
}  // namespace ctn
