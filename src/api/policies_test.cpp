#include "api/policies.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "config/testing/apps.h"
#include "plan/json.h"

namespace ctn::api {
namespace {

std::string file_of(const std::string& text) {
  // Tests run side by side, each in a process of its own.
  std::string path = testing::TempDir() + "catan_policies_" + std::to_string(getpid());
  std::ofstream(path) << text;
  return path;
}

class PoliciesTest : public ::testing::Test {
 protected:
  std::string costs = file_of("camera: 2ms\ndetect: 9ms\nplan: 4ms\nmotor: 1ms\n");
  ~PoliciesTest() override { std::remove(costs.c_str()); }
  std::string message(const std::string& name) const {
    const auto made = live_policy(name, app);
    return made ? "" : made.error().message();
  }

  graph::App app = tracker_app();
};

TEST_F(PoliciesTest, AreCalledAsWritten) {
  for (const std::string& name :
       {std::string("catan"), std::string("paper"), std::string("default"), std::string("fifo"),
        std::string("rate:12.5Hz"), "picas:" + costs, "davare:" + costs, "verucchi:" + costs}) {
    const auto live = live_policy(name, app);
    ASSERT_TRUE(live.ok()) << live.error().message();
    EXPECT_EQ((*live)->name(), name);
    const auto simulated = simulated_policy(name, app);
    ASSERT_TRUE(simulated.ok()) << name;
    EXPECT_EQ(simulated->policy->name(), name);
    EXPECT_FALSE(simulated->reserve);
  }
}

TEST_F(PoliciesTest, CatanIsThePapersWhereTheAppSaysSo) {
  app.scheduler.planner = graph::PlannerKind::kPaper;
  EXPECT_EQ((*live_policy("catan", app))->name(), "paper");
  EXPECT_EQ((*live_policy("fifo", app))->name(), "fifo");
}

TEST_F(PoliciesTest, WhatOnlyASimulationCanDoIsRefusedInLife) {
  for (const std::string& name : {std::string("deadline"), "deadline:" + costs}) {
    EXPECT_NE(message(name).find("only the simulator"), std::string::npos) << message(name);
    const auto simulated = simulated_policy(name, app);
    ASSERT_TRUE(simulated.ok());
    EXPECT_TRUE(simulated->reserve);
  }
  for (const std::string name : {"picas", "davare", "verucchi"}) {
    EXPECT_NE(message(name).find(name + ":COSTS.yaml"), std::string::npos) << message(name);
    EXPECT_TRUE(simulated_policy(name, app)->policy->needs_costs());
  }
}

TEST_F(PoliciesTest, AGivenPlanIsReadAndCheckedForTheApp) {
  const os::CpuSet cpus{2, 3};
  const model::CostTable ten(app.graph, Millis{10});
  const policy::Situation situation{.app = app, .cpus = cpus, .costs = ten, .typical = ten, .slack = 0.06};
  const auto planned = (*live_policy("catan", app))->decide(situation);
  ASSERT_TRUE(planned.ok());
  std::ofstream(costs) << plan::to_json(*planned->plan, app);
  const auto given = live_policy("static:" + costs, app);
  ASSERT_TRUE(given.ok()) << given.error().message();
  EXPECT_EQ((*given)->name(), "static:" + costs);
  EXPECT_EQ((*given)->decide(situation)->plan->subchains, planned->plan->subchains);
  const graph::App other = parse(R"(
catan: 1
app: other
nodes: { a: {} }
objective: [ { response_time: [a], weight: 1 } ]
)");
  EXPECT_FALSE(live_policy("static:" + costs, other).ok());
  EXPECT_FALSE(live_policy("rates-of:" + costs, other).ok());
  // Of a plan for two cores, on one: its rates alone count.
  const os::CpuSet one{2};
  const auto rates = live_policy("rates-of:" + costs, app);
  ASSERT_TRUE(rates.ok()) << rates.error().message();
  EXPECT_FALSE((*rates)->raises());
  const auto set = (*rates)->decide({.app = app, .cpus = one, .costs = ten, .typical = ten});
  ASSERT_TRUE(set.ok()) << set.error().message();
  EXPECT_FALSE(set->plan);
  for (std::size_t index = 0; index < set->assignment.places.size(); ++index) {
    EXPECT_EQ(set->assignment.places[index].pacing.period,
              to_nanos(plan::usual_timing(*planned->plan, SubchainId(index)).period));
    EXPECT_EQ(set->assignment.places[index].cpus, one);
    EXPECT_EQ(set->assignment.places[index].level, os::Level::kOrdinary);
  }
}

TEST_F(PoliciesTest, FilesThatAreNotThereAreRefused) {
  for (const char* name :
       {"static:/nowhere", "rates-of:/nowhere", "picas:/nowhere", "deadline:/nowhere", "davare:/nowhere"}) {
    EXPECT_NE(message(name).find("/nowhere"), std::string::npos) << name;
    EXPECT_FALSE(simulated_policy(name, app).ok()) << name;
  }
}

TEST_F(PoliciesTest, WhatIsNoNameIsToldWhatWouldBeRight) {
  for (const char* name :
       {"", "catn", "static", "static:", "rates-of", "fifo:", "fifo:x", "rate:", "rate:fast", "picas:", ":x"}) {
    EXPECT_NE(message(name).find("is no scheduler"), std::string::npos) << name;
    for (const char* right : {"static:PLAN.json", "rates-of:PLAN.json", "rate:12.5", "picas:COSTS.yaml", "verucchi"}) {
      EXPECT_NE(message(name).find(right), std::string::npos) << name;
    }
  }
}

}  // namespace
}  // namespace ctn::api
