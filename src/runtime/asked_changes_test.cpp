// Weights, bounds and CPUs that are changed while a session runs, in virtual time: what is planned, told and recorded.
#include "runtime/asked_changes.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "config/testing/apps.h"
#include "plan/json.h"
#include "record/app_changes.h"
#include "record/reader.h"
#include "runtime/testing/virtual_session.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class AskedChangesTest : public VirtualSession {
 protected:
  ~AskedChangesTest() override { std::remove(path.c_str()); }

  void start(int cpus, const std::string& policy = "catan") {
    std::remove(path.c_str());
    costs = {{"left", milliseconds{10}}, {"right", milliseconds{10}}};
    cost = [this](const std::string& node, std::uint64_t /*run*/) {
      ++runs[fake.current_cpu()];
      return costs.at(node);
    };
    on_notice = [this](const std::string& notice) { notices.push_back(notice); };
    // A long `replan`, so that what is planned soon is planned for a reason.
    open(parse(R"(
catan: 1
app: pair
nodes: { left: { fallback_rate: 5Hz }, right: { fallback_rate: 5Hz, max_rate: 80Hz } }
objective:
  - { response_time: [left], weight: 1 }
  - { response_time: [right], weight: 1 }
scheduler: { bootstrap: 1s, replan: 1000s }
)"),
         *policy::make_policy(policy), cpus, path);
    VirtualSession::start();
    pass(seconds{4});
    notices.clear();
  }
  Millis period_in_last_plan(const record::Reader& reader, std::size_t subchain) const {
    return plan::from_json(reader.plans()->back().json, reader.app(), "plan")->subchains[subchain].period;
  }
  record::Reader finished() {
    EXPECT_TRUE(engine->stop().ok());
    Result<record::Reader> reader = record::Reader::open(path);
    EXPECT_TRUE(reader.ok());
    return std::move(*reader);
  }
  std::uint64_t plans() const { return engine->snapshot().plans; }

  const std::string path = testing::TempDir() + "catan_asked_" + std::to_string(::getpid()) + ".catan";
  std::map<int, int> runs;  // by CPU
  std::vector<std::string> notices;
};

TEST_F(AskedChangesTest, AWeightIsPlannedForAtOnceToldAndRecorded) {
  start(1);
  const std::uint64_t before = plans();
  const TimePoint asked = fake.now();
  ASSERT_TRUE(engine->change({.weights = {{"left", 20.0}}}).ok());
  pass(milliseconds{50});
  EXPECT_EQ(plans(), before + 1);
  EXPECT_EQ(notices, std::vector<std::string>{"changed: objective[0].weight (left): 1 -> 20"});
  const Snapshot snapshot = engine->snapshot();
  EXPECT_EQ(snapshot.changes, 1U);
  ASSERT_EQ(snapshot.objective.size(), 2U);
  EXPECT_EQ(snapshot.objective[0].term, "left");
  EXPECT_EQ(snapshot.objective[0].weight, 20.0);
  EXPECT_EQ(snapshot.objective[1].weight, 1.0);

  const record::Reader reader = finished();
  EXPECT_EQ(reader.plans()->back().reason, "asked");
  EXPECT_LE(reader.plans()->back().at - asked, milliseconds{50});
  EXPECT_LT(period_in_last_plan(reader, 0) * 1.5, period_in_last_plan(reader, 1)) << "they were alike";
  const std::vector<record::AppChange> changes = *reader.app_changes();
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].what, record::AppChange::What::kWeight);
  EXPECT_EQ(changes[0].item, 0U);
  EXPECT_EQ(changes[0].before, 1.0);
  EXPECT_EQ(changes[0].after, 20.0);
  EXPECT_EQ(record::app_after(reader.app(), changes)->objective[0].weight, 20.0);
}

TEST_F(AskedChangesTest, BoundsArePlannedForAndTakenAwayAgain) {
  start(1);
  ASSERT_TRUE(engine->change({.min_rates = {{"right", 60.0}}}).ok());
  pass(seconds{3});
  EXPECT_NEAR(rate(engine->snapshot(), "right"), 60.0, 20.0);
  ASSERT_TRUE(engine->change({.maxes = {{"1", 1.0}}, .min_rates = {{"right", {}}}}).ok());
  pass(milliseconds{50});
  Snapshot snapshot = engine->snapshot();
  EXPECT_EQ(snapshot.objective[1].max_ms, 1.0);
  ASSERT_EQ(snapshot.relaxed.size(), 1U) << "which could not be kept";
  EXPECT_EQ(snapshot.relaxed[0].bound, "objective[1].max");
  ASSERT_TRUE(engine->change({.maxes = {{"1", {}}}}).ok());
  pass(milliseconds{50});
  snapshot = engine->snapshot();
  EXPECT_TRUE(snapshot.relaxed.empty());
  EXPECT_FALSE(snapshot.nodes[1].min_rate_hz);
  const record::Reader reader = finished();
  EXPECT_EQ(reader.app_changes()->size(), 4U);
  EXPECT_FALSE(record::app_after(reader.app(), *reader.app_changes())->objective[1].max);
}

TEST_F(AskedChangesTest, CpusAreThoseThatWereAskedUntilOthersAre) {
  start(2);
  EXPECT_GT(runs[0], 0);
  EXPECT_GT(runs[1], 0);
  ASSERT_TRUE(engine->change({.cpus = {{1}}}).ok());
  pass(milliseconds{200});
  EXPECT_EQ(engine->snapshot().cpus, std::vector<int>{1});
  runs.clear();
  pass(seconds{2});
  EXPECT_EQ(runs[0], 0);
  EXPECT_GT(runs[1], 50);
  // What is taken meanwhile counts as well.
  fake.set_cpuset({0});
  pass(milliseconds{200});
  EXPECT_EQ(engine->snapshot().cpus, std::vector<int>{1}) << "none of those that were asked is left";
  EXPECT_EQ(notices.back().find("cpus: of CPUs 1, none is online and allowed"), 0U) << notices.back();
  ASSERT_TRUE(engine->change({.cpus = {{0, 1}}}).ok());
  pass(milliseconds{100});
  EXPECT_EQ(engine->snapshot().cpus, std::vector<int>{0});
  fake.set_cpuset({0, 1});
  pass(milliseconds{200});
  EXPECT_EQ(engine->snapshot().cpus, (std::vector<int>{0, 1}));
  const record::Reader reader = finished();
  EXPECT_TRUE(reader.app_changes()->empty()) << "CPUs are in its plans and notices";
}

TEST_F(AskedChangesTest, WhatIsWrongIsAllToldAndNothingIsChanged) {
  start(2);
  const std::uint64_t before = plans();
  const Status refused = engine->change({.cpus = {{0, 5}}, .weights = {{"left", 7.0}, {"nobody", 1.0}}});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(refused.error().problems().size(), 2U) << refused.error().message();
  EXPECT_FALSE(engine->change({.cpus = {std::vector<int>{}}}).ok());
  pass(milliseconds{200});
  EXPECT_EQ(plans(), before);
  EXPECT_EQ(engine->snapshot().objective[0].weight, 1.0);
  EXPECT_EQ(engine->snapshot().changes, 0U);
  EXPECT_TRUE(engine->stop().ok());
}

TEST_F(AskedChangesTest, WhatIsSoAlreadyMakesNoPlan) {
  start(2);
  const std::uint64_t before = plans();
  ASSERT_TRUE(engine->change({.cpus = {{0, 1}}, .weights = {{"left", 1.0}}, .maxes = {{"left", {}}}}).ok());
  pass(milliseconds{200});
  EXPECT_EQ(plans(), before);
  EXPECT_TRUE(notices.empty());
  EXPECT_TRUE(engine->stop().ok());
}

TEST_F(AskedChangesTest, AfterTheEndNothingCanBeChanged) {
  start(1);
  ASSERT_TRUE(engine->stop().ok());
  EXPECT_FALSE(engine->change({.weights = {{"left", 2.0}}}).ok()) << "it does not run";
}

TEST_F(AskedChangesTest, APolicyThatNeverPlansAgainSaysSo) {
  start(1, "default");
  const Status refused = engine->change({.weights = {{"left", 2.0}}});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message().find("'default' never plans again"), std::string::npos);
  EXPECT_TRUE(engine->stop().ok());
}

}  // namespace
}  // namespace ctn::runtime
