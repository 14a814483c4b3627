// Each event reaches all that are to hear of it.
#include "driver/event_log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "base/testing/times.h"
#include "config/testing/apps.h"

namespace ctn::driver {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// Remembers what it is given, in words.
class WordWriter : public record::Writer {
 public:
  explicit WordWriter(std::vector<std::string>& words) : words_(words) {}
  void add(const record::Run& /*run*/) override { words_.emplace_back("run"); }
  void add(const record::Trigger& /*trigger*/) override { words_.emplace_back("trigger"); }
  void add(const record::SlotUse& /*slot*/) override { words_.emplace_back("slot"); }
  void add(const record::Steal& /*steal*/) override { words_.emplace_back("steal"); }
  void add(const record::Overrun& /*overrun*/) override { words_.emplace_back("overrun"); }
  void add(const record::PlanChange& change) override { words_.push_back("plan " + change.reason); }
  void add(const record::CostChange& change) override {
    words_.push_back("cost of node " + std::to_string(change.node.index()));
  }
  void add(const record::AppChange& /*change*/) override { words_.emplace_back("app"); }
  void add(const record::ClockReading& /*reading*/) override { words_.emplace_back("clock"); }
  void add(const record::Notice& notice) override { words_.push_back("notice " + notice.kind); }
  void set_totals(const record::Totals& totals) override {
    words_.push_back("starved " + std::to_string(totals.starved));
  }
  Status flush() override { return Error::environment("the disk is full", "make room"); }
  void begin_at(TimePoint /*started*/, Nanos /*warm_up*/) override { words_.emplace_back("begins"); }
  Status close(TimePoint /*ended*/, const os::HostFacts& /*host*/) override {
    words_.emplace_back("closed");
    return Done{};
  }

 private:
  std::vector<std::string>& words_;
};

class EventLogTest : public ::testing::Test {
 protected:
  // A policy that never plans again: what happens is told all the same.
  EventLogTest() {
    EXPECT_TRUE(loop.decide_first().ok());
    log.record_to(std::make_unique<WordWriter>(recorded));
  }
  void run(std::uint64_t number, Nanos cpu, Nanos age = Nanos{0}) {
    const TimePoint begin = at(milliseconds{100} * number);
    log.ran({NodeId(0), number, begin, begin + cpu, cpu, 0, true, {}});
    record::Run taker{NodeId(1), number, begin + cpu, begin + 2 * cpu, cpu, 0, true, {{NodeId(0), number, number}}};
    taker.ages = {age};
    log.ran(taker);
  }
  Snapshot snapshot() const {
    Snapshot shown;
    measurements.fill(shown, at(seconds{100}), app, loop.hand_set_hz());
    return shown;
  }

  graph::App app = parse(R"(
catan: 1
app: two
nodes: { a: { fallback_rate: 10Hz, min_rate: 2Hz }, b: {} }
edges: [ { path: a -> b, max_age: 50ms } ]
subchains: { ab: [a, b] }
objective: [ { response_time: [a, b], weight: 2, max: 300ms } ]
)");
  PlanningLoop loop{app,
                    {.policy = *policy::make_policy("default"), .cpus = os::CpuSet{0}, .timer = [](const auto& plan) {
                       plan();
                       return PlanningTime{};
                     }}};
  Measurements<record::AllSamples> measurements{app, TimePoint{}};
  Notices notices{{}, true};
  std::vector<std::string> recorded;
  EventLog<record::AllSamples> log{app, loop, measurements, notices};
};

using Words = std::vector<std::string>;

TEST_F(EventLogTest, RunsAreMeasuredRecordedAndPlannedWith) {
  std::uint64_t number = 0;
  while (number < 60) run(++number, milliseconds{10});
  EXPECT_EQ(recorded, Words(120, "run"));
  while (number < 120) run(++number, milliseconds{30});
  EXPECT_EQ(snapshot().nodes[0].compute_ms.max, 30.0);
  EXPECT_EQ(snapshot().chains[0].latency_ms.max, 60.0);
  EXPECT_EQ(snapshot().cost_changes, 2U) << "one a node, although the policy does not adapt";
  EXPECT_EQ(std::count(recorded.begin(), recorded.end(), "cost of node 0"), 1);
  EXPECT_EQ(std::count(recorded.begin(), recorded.end(), "cost of node 1"), 1);
}

TEST_F(EventLogTest, NoticesAreShownAndRecorded) {
  run(1, milliseconds{10}, milliseconds{60});
  EXPECT_EQ(recorded, (Words{"run", "run", "notice stale-input"}));
  recorded.clear();
  log.hang_changed(SubchainId(0), true, at(seconds{1}));
  log.hang_changed(SubchainId(0), false, at(seconds{2}));
  EXPECT_EQ(recorded, (Words{"notice watchdog", "notice watchdog"}));
  EXPECT_EQ(measurements.lock()->counts.hangs, 1U);
  recorded.clear();
  notices.add({at(seconds{3}), "of-others", "of another thread"});
  EXPECT_TRUE(recorded.empty());
  log.flush(at(seconds{4}));
  log.flush(at(seconds{5}));
  EXPECT_EQ(recorded, (Words{"notice of-others", "notice record-failed"})) << "told once";
  ASSERT_EQ(notices.newest().size(), 5U);
  EXPECT_EQ(notices.newest()[4].find("record-failed: the disk is full"), 0U) << notices.newest()[4];
}

TEST_F(EventLogTest, WhatControllersDoIsCountedAndRecorded) {
  log.triggered({SubchainId(0), 1, at(seconds{1}), at(seconds{1})});
  log.slot_over({0, SubchainId(0), at(seconds{1}), at(seconds{1}), at(seconds{2})});
  log.stole({0, SubchainId(0), SubchainId(0), at(seconds{1}), at(seconds{2})});
  log.over_budget({SubchainId(0), 1, at(seconds{2}), milliseconds{3}});
  EXPECT_EQ(recorded, (Words{"trigger", "slot", "steal", "overrun"}));
  EXPECT_EQ(measurements.lock()->counts.triggers, 1U);
  EXPECT_EQ(measurements.lock()->counts.steals, 1U);
  EXPECT_EQ(snapshot().budget_overruns, 1U);
}

TEST_F(EventLogTest, PlansComeAndGo) {
  policy::Decision decision;
  decision.plan.emplace().relax_factor = 1.5;
  decision.plan->subchains.emplace_back().period = Millis{100};
  decision.plan->chains.push_back({.path = {NodeId(0), NodeId(1)}, .response = Millis{200}});
  log.in_force(at(seconds{1}), decision, policy::PlanReason::kMeasured);
  EXPECT_EQ(snapshot().relax_factor, 1.5);
  log.in_force(at(seconds{2}), {}, policy::PlanReason::kCpus);
  EXPECT_EQ(snapshot().relax_factor, 1.0);
  EXPECT_EQ(snapshot().plans, 1U);
  EXPECT_EQ(recorded, (Words{"plan measured"}));
}

TEST_F(EventLogTest, TheRecordEndsWithTheTotals) {
  measurements.starved(3, milliseconds{5});
  EXPECT_TRUE(log.close(at(seconds{1}), {}).ok());
  run(1, milliseconds{10}, milliseconds{60});
  EXPECT_EQ(recorded, (Words{"starved 3", "closed"})) << "what comes later is not recorded";
  EXPECT_EQ(notices.newest().size(), 1U) << "but told";
}

TEST_F(EventLogTest, SnapshotsSayWhatIsAskedFor) {
  measurements.cpus_in_use(os::CpuSet{0});
  const Snapshot shown = snapshot();
  EXPECT_EQ(shown.cpus, std::vector<int>{0});
  ASSERT_EQ(shown.objective.size(), 1U);
  EXPECT_EQ(shown.objective[0].term, "a -> b");
  EXPECT_EQ(shown.objective[0].weight, 2.0);
  EXPECT_EQ(shown.objective[0].max_ms, 300.0);
  EXPECT_EQ(shown.nodes[0].min_rate_hz, 2.0);
  EXPECT_FALSE(shown.nodes[1].min_rate_hz);
  EXPECT_EQ(shown.source_hz, 10.0) << "set by hand";
}

}  // namespace
}  // namespace ctn::driver
