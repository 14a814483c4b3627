// When a plan is made, and what of it is told, with a world that says what the test wants.
#include "driver/planning_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/testing/times.h"
#include "config/testing/apps.h"

namespace ctn::driver {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr const char* kTwo = R"(
catan: 1
app: two
nodes: { a: {}, b: {} }
edges: [ a -> b ]
subchains: { ab: [a, b] }
objective: [ { response_time: [a, b], weight: 1 } ]
scheduler: { bootstrap: 1s, slack: 0% }
)";

// As the policy of that name, but it fails where it is told to, and shows what it was asked with.
class Tested : public policy::Policy {
 public:
  Tested() : Policy("tested"), real_(*policy::make_policy("catan")) {}
  bool follows_plan() const override { return true; }
  bool adapts() const override { return true; }
  bool raises() const override { return false; }
  Result<policy::Decision> decide(const policy::Situation& situation) const override {
    return real_->decide(situation);
  }
  Result<std::optional<policy::Decision>> decide_again(const policy::Situation& situation,
                                                       const policy::Decision& in_force) const override {
    asked.push_back(situation.costs[NodeId(0)].single_thread().count());
    periodic.push_back(situation.periodic);
    if (fails) return Error::caller("there is no plan", "wait");
    return real_->decide_again(situation, in_force);
  }

  Nanos replan_every(const graph::SchedulerOptions& options) const override { return every.value_or(options.replan); }

  mutable std::vector<double> asked;  // what node a costs
  mutable std::vector<int> periodic;
  std::optional<Nanos> every;
  bool fails = false;

 private:
  std::shared_ptr<const policy::Policy> real_;
};

class PlanningLoopTest : public ::testing::Test, protected PlanningHost {
 protected:
  PlanningLoop loop_of(os::CpuSet cpus = {0}) {
    online = cpus;
    PlanningLoop loop(app, {.policy = tested, .cpus = cpus, .timer = [](const auto& plan) {
                              plan();
                              return PlanningTime{.cpu = std::chrono::microseconds{100}};
                            }});
    EXPECT_TRUE(loop.decide_first().ok());
    loop.begin(TimePoint{}, *this);
    return loop;
  }
  void run(PlanningLoop& loop, std::uint64_t number, Nanos cpu) {
    for (const NodeId node : {NodeId(0), NodeId(1)}) run_one(loop, node, number, cpu);
  }
  static void run_one(PlanningLoop& loop, NodeId node, std::uint64_t number, Nanos cpu) {
    const TimePoint begin = at(milliseconds{100} * number);
    loop.ran({node, number, begin, begin + cpu, cpu, 0, true, {}});
  }
  void step(PlanningLoop& loop, TimePoint now) {
    if (std::optional<Planned> planned = loop.plan(now, *this)) loop.adopt(std::move(*planned), *this);
  }

  Result<os::CpuSet> usable_cpus() override { return online; }
  os::PowerState power_state() override { return {}; }
  ControllerWork controller_work() override { return {}; }
  void raise(const Levels& levels) override { raised.push_back(levels); }
  void in_force(const policy::Decision& /*decision*/, policy::PlanReason reason) override {
    told.push_back(std::string("plan ") + policy::to_string(reason));
  }
  void cpus_changed(const os::CpuSet& cpus) override { told.push_back("cpus " + os::to_string(cpus)); }
  void notice(const std::string& kind, const std::string& /*detail*/) override { told.push_back(kind); }

  graph::App app = parse(kTwo);
  std::shared_ptr<Tested> tested = std::make_shared<Tested>();
  os::CpuSet online{0};
  std::vector<std::string> told;
  std::vector<Levels> raised;
};

using Told = std::vector<std::string>;

TEST_F(PlanningLoopTest, LevelsRiseAndNeverFall) {
  PlanningLoop loop = loop_of();
  EXPECT_TRUE(raised.empty()) << "threads begin there";
  const policy::Decision first = loop.decision();
  EXPECT_EQ(loop.levels().dispatcher, first.dispatcher_level);
  policy::Decision higher = first;
  higher.dispatcher_level = os::fixed_level(5);
  loop.adopt({policy::PlanReason::kAsked, higher}, *this);
  ASSERT_EQ(raised.size(), 1U);
  EXPECT_EQ(raised[0].dispatcher, os::fixed_level(5));
  EXPECT_EQ(raised[0].unscheduled, os::Level::kOrdinary) << "a policy that needs no levels";
  loop.adopt({policy::PlanReason::kAsked, first}, *this);
  EXPECT_EQ(raised.size(), 1U);
  EXPECT_EQ(loop.levels().dispatcher, os::fixed_level(5));
}

TEST_F(PlanningLoopTest, PlansWithWhatIsKnownAndSaysWhatIsNot) {
  PlanningLoop loop = loop_of();
  run_one(loop, NodeId(0), 1, milliseconds{10});
  step(loop, at(seconds{2}));
  EXPECT_EQ(told, (Told{"plan bootstrap", "plan measured", "assumed-costs"}));
  EXPECT_EQ(tested->asked, (std::vector<double>{10.0}));
  EXPECT_EQ(loop.decision().plan->assumed, (std::vector<plan::AssumedCost>{{NodeId(1), Millis{5}}}));
  EXPECT_EQ(loop.decision().plan->subchains[0].execution, Millis{15});
  told.clear();
  for (int second = 3; second < 30; ++second) step(loop, at(seconds{second}));
  EXPECT_EQ(told, Told{}) << "said once";
}

TEST_F(PlanningLoopTest, PlansAsOftenAsThePolicySaysAndTellsItThatTimeHasPassed) {
  tested->every = seconds{5};
  PlanningLoop loop = loop_of();
  run(loop, 1, milliseconds{10});
  for (int half_second = 4; half_second <= 36; ++half_second) step(loop, at(milliseconds{500} * half_second));
  EXPECT_EQ(tested->periodic, (std::vector<int>{0, 1, 2, 3})) << "after 2, 7, 12 and 17 s";
}

TEST_F(PlanningLoopTest, ReplacesAPlanWithAssumedCostsAsSoonAsTheyAreKnown) {
  app.scheduler.replan = seconds{1000};
  PlanningLoop loop = loop_of();
  run_one(loop, NodeId(0), 1, milliseconds{10});
  step(loop, at(seconds{2}));
  told.clear();
  run_one(loop, NodeId(1), 1, milliseconds{5});
  step(loop, at(milliseconds{2300}));
  EXPECT_EQ(told, (Told{"plan measured", "assumed-costs"})) << "though what was assumed was right";
  EXPECT_TRUE(loop.decision().plan->assumed.empty());
  step(loop, at(seconds{4}));
  EXPECT_EQ(told.size(), 2U);
}

TEST_F(PlanningLoopTest, PlansOnceTheBootstrapIsOverAndANodeHasRun) {
  PlanningLoop loop = loop_of();
  EXPECT_FALSE(loop.plan(at(seconds{2}), *this)) << "no node has run";
  run(loop, 1, milliseconds{10});
  EXPECT_FALSE(loop.plan(at(milliseconds{900}), *this)) << "the bootstrap is not over";
  std::optional<Planned> planned = loop.plan(at(seconds{2}), *this);
  ASSERT_TRUE(planned);
  EXPECT_EQ(told, (Told{"plan bootstrap"})) << "not adopted yet";
  loop.adopt(std::move(*planned), *this);
  EXPECT_EQ(told, (Told{"plan bootstrap", "plan measured"}));
  EXPECT_EQ(loop.budget().spent(), std::chrono::microseconds{100});
  EXPECT_EQ(loop.planning_cpu(), std::chrono::microseconds{100});
}

TEST_F(PlanningLoopTest, ForgetsANodesColdRunsOnceItHasOthers) {
  PlanningLoop loop = loop_of();
  const Nanos cpu[] = {milliseconds{90}, milliseconds{30}, milliseconds{30}, milliseconds{20}};
  for (std::uint64_t number = 1; number <= 4; ++number) run(loop, number, cpu[number - 1]);
  step(loop, at(seconds{2}));
  EXPECT_EQ(tested->asked, (std::vector<double>{20.0}));
}

TEST_F(PlanningLoopTest, AFailureIsToldOnceAndThePlanInForceStays) {
  PlanningLoop loop = loop_of();
  run(loop, 1, milliseconds{10});
  tested->fails = true;
  step(loop, at(seconds{2}));
  step(loop, at(seconds{20}));
  step(loop, at(seconds{40}));
  EXPECT_GE(tested->asked.size(), 2U);
  EXPECT_EQ(told, (Told{"plan bootstrap", "replan-failed"}));
  EXPECT_TRUE(loop.decision().plan.has_value());
}

TEST_F(PlanningLoopTest, ACpuThatGoesIsPlannedForAtOnceAndThenTold) {
  PlanningLoop loop = loop_of({0, 1});
  run(loop, 1, milliseconds{10});
  step(loop, at(seconds{2}));
  told.clear();
  online = os::CpuSet{1};
  step(loop, at(seconds{2} + milliseconds{100}));
  EXPECT_EQ(told, (Told{"cpus", "plan cpus", "cpus 1"}));
  EXPECT_EQ(loop.decision().assignment.places.front().cpus, os::CpuSet{1});
  EXPECT_EQ(loop.decision().assignment.cores.size(), 2U) << "cores are those that were given";
}

TEST_F(PlanningLoopTest, APlanThatNamesACpuThatIsGoneIsNotKeptWhateverFails) {
  PlanningLoop loop = loop_of({0, 1});
  run(loop, 1, milliseconds{10});
  step(loop, at(seconds{2}));
  const Nanos period = to_nanos(loop.decision().plan->subchains[0].period);
  told.clear();
  online = os::CpuSet{1};
  tested->fails = true;
  step(loop, at(seconds{3}));
  EXPECT_EQ(told, (Told{"cpus", "replan-failed", "plan cpus", "cpus 1"}));
  EXPECT_FALSE(loop.decision().plan);
  const policy::SubchainPlace& place = loop.decision().assignment.places.front();
  EXPECT_EQ(place.cpus, os::CpuSet{1});
  EXPECT_EQ(place.core, -1);
  EXPECT_EQ(place.level, os::Level::kOrdinary);
  EXPECT_EQ(place.pacing.period, period);
  EXPECT_EQ(place.pacing.max_in_flight, 1);
  EXPECT_EQ(loop.decision().assignment.cores.size(), 2U);
  told.clear();
  step(loop, at(seconds{5}));
  EXPECT_EQ(told, Told{}) << "tried again, and said once";
  tested->fails = false;
  step(loop, at(seconds{7}));
  EXPECT_EQ(told, (Told{"plan periodic"}));
  EXPECT_EQ(loop.decision().assignment.places.front().cpus, os::CpuSet{1});
}

TEST_F(PlanningLoopTest, RatesOnlyFollowWhatIsLeftOfTheCpus) {
  PlanningLoop loop = loop_of({0, 1, 2});
  run(loop, 1, milliseconds{10});
  step(loop, at(seconds{2}));
  tested->fails = true;
  for (const auto& [cpus, when] : {std::pair{os::CpuSet{1, 2}, seconds{3}}, {os::CpuSet{2}, seconds{4}}}) {
    online = cpus;
    step(loop, at(when));
    EXPECT_EQ(loop.decision().assignment.places.front().cpus, cpus);
  }
  EXPECT_EQ(std::count(told.begin(), told.end(), "replan-failed"), 2);
}

TEST_F(PlanningLoopTest, WithoutAnyCpuItGoesOnAsPlannedAndSaysSoOnce) {
  PlanningLoop loop = loop_of({0, 1});
  run(loop, 1, milliseconds{10});
  step(loop, at(seconds{2}));
  told.clear();
  for (const os::CpuSet& none : {os::CpuSet{}, os::CpuSet{2}}) {
    online = none;
    for (int second = 3; second < 6; ++second) step(loop, at(seconds{second}));
    EXPECT_EQ(told, (Told{"cpus"}));
  }
  EXPECT_TRUE(loop.decision().plan.has_value());
  EXPECT_EQ(loop.cpus(), (os::CpuSet{0, 1}));
  online = os::CpuSet{0, 1};
  step(loop, at(seconds{7}));
  online = os::CpuSet{};
  step(loop, at(seconds{8}));
  EXPECT_EQ(told, (Told{"cpus", "cpus"})) << "told again when it happens again";
}

// --- What is asked for ---

TEST_F(PlanningLoopTest, WhatIsAskedIsPlannedForAtOnceWhateverThePlanInForceIsWorth) {
  PlanningLoop loop = loop_of();
  graph::App asked = app;
  asked.objective[0].weight = 7.0;
  loop.change(asked, {0});
  step(loop, at(milliseconds{50}));
  EXPECT_EQ(told, (Told{"plan bootstrap", "plan asked"})) << "the bootstrap is not over, and nothing was measured";
  step(loop, at(milliseconds{100}));
  EXPECT_EQ(told.size(), 2U);
  run(loop, 1, milliseconds{10});
  step(loop, at(seconds{2}));
  EXPECT_EQ(told.back(), "plan measured");
  EXPECT_EQ(loop.decision().plan->chains[0].weight, 7.0) << "from then on";
}

TEST_F(PlanningLoopTest, CpusThatAreAskedForAreThoseThatCountUntilOthersAre) {
  PlanningLoop loop = loop_of({0, 1});
  run(loop, 1, milliseconds{10});
  step(loop, at(seconds{2}));
  told.clear();
  loop.change(app, {1});
  step(loop, at(seconds{2} + milliseconds{50}));
  EXPECT_EQ(told, (Told{"cpus", "plan cpus", "cpus 1"})) << "not with the next look at the CPUs";
  EXPECT_EQ(loop.decision().assignment.places.front().cpus, os::CpuSet{1});
  told.clear();
  online = os::CpuSet{1};
  step(loop, at(seconds{3}));
  EXPECT_EQ(told, Told{}) << "a CPU that is not used may go";
  loop.change(app, {0, 1});
  step(loop, at(seconds{4}));
  EXPECT_EQ(told, (Told{"plan asked"})) << "the other is gone";
  online = os::CpuSet{0, 1};
  step(loop, at(seconds{5}));
  EXPECT_EQ(loop.cpus(), (os::CpuSet{0, 1}));
}

// --- Rates that cannot be met ---

class ExactRateTest : public PlanningLoopTest {
 protected:
  static graph::App with_rate(const std::string& rate) {
    return parse("catan: 1\napp: exact\nnodes: { a: { min_rate: " + rate + ", max_rate: " + rate +
                 " }, b: {} }\nobjective: [ { response_time: [a], weight: 1 }, { period: b, weight: 1 } ]\n"
                 "scheduler: { bootstrap: 1s, slack: 0% }\n");
  }
  Millis period(const PlanningLoop& loop) const { return loop.decision().plan->subchains[0].period; }
};

TEST_F(ExactRateTest, BeyondTheGuessIsMetAtALowerOneUntilNodesHaveRun) {
  app = with_rate("300Hz");
  PlanningLoop loop = loop_of();
  EXPECT_EQ(told, (Told{"plan bootstrap", "assumed-costs"}));
  EXPECT_DOUBLE_EQ(period(loop).count(), 1000.0 / 300);
  EXPECT_EQ(loop.decision().plan->relax_factor, 1.0);
  for (const plan::AssumedCost& assumed : loop.decision().plan->assumed) EXPECT_LT(assumed.cost, Millis{5});
  told.clear();
  run(loop, 1, milliseconds{1});
  step(loop, at(seconds{2}));
  EXPECT_EQ(told, (Told{"plan measured", "assumed-costs"}));
  EXPECT_DOUBLE_EQ(period(loop).count(), 1000.0 / 300);
}

TEST_F(ExactRateTest, AGuessThatWasLoweredIsKeptFromPlanToPlan) {
  app = with_rate("300Hz");
  PlanningLoop loop = loop_of();
  run_one(loop, NodeId(1), 1, milliseconds{1});
  step(loop, at(seconds{2}));
  const plan::Plan first = *loop.decision().plan;
  ASSERT_EQ(first.assumed.size(), 1U);
  EXPECT_LT(first.assumed[0].cost, Millis{5});
  told.clear();
  for (int second = 3; second < 30; ++second) step(loop, at(seconds{second}));
  EXPECT_EQ(told, Told{}) << "no plan replaces its equal";
}

TEST_F(ExactRateTest, ThatCannotBeMetAsMeasuredIsRelaxedAndTightenedWhenItCan) {
  app = with_rate("100Hz");
  PlanningLoop loop = loop_of();
  std::uint64_t number = 0;
  const auto runs = [&](Nanos cpu) {
    for (int k = 0; k < 60; ++k) run(loop, ++number, cpu);
  };
  runs(milliseconds{2});
  step(loop, at(seconds{7}));
  EXPECT_EQ(period(loop), Millis{10});
  told.clear();
  runs(milliseconds{20});
  step(loop, at(seconds{14}));
  ASSERT_TRUE(loop.decision().plan);
  EXPECT_EQ(told, (Told{"plan change", "relaxed"}));
  EXPECT_GE(period(loop), Millis{20});
  ASSERT_EQ(loop.decision().plan->relaxed.size(), 1U);
  EXPECT_EQ(loop.decision().plan->relaxed[0].key, "nodes.a.min_rate");
  EXPECT_EQ(loop.decision().plan->relaxed[0].planned, period(loop));
  for (int second = 15; second < 40; ++second) step(loop, at(seconds{second}));
  EXPECT_EQ(told.size(), 2U) << "no plan replaces its equal";
  told.clear();
  runs(milliseconds{2});
  step(loop, at(seconds{50}));
  EXPECT_EQ(told, (Told{"plan change", "relaxed"}));
  EXPECT_EQ(period(loop), Millis{10});
  EXPECT_TRUE(loop.decision().plan->relaxed.empty());
}

TEST_F(ExactRateTest, ThatNeedsACpuThatGoesIsRelaxedOnThoseThatAreLeft) {
  app = in_frames(with_rate("100Hz"));
  PlanningLoop loop = loop_of({0, 1});
  run(loop, 1, std::chrono::microseconds{9500});
  step(loop, at(seconds{2}));
  EXPECT_EQ(period(loop), Millis{10});
  told.clear();
  online = os::CpuSet{1};
  step(loop, at(seconds{3}));
  EXPECT_EQ(told, (Told{"cpus", "plan cpus", "relaxed", "cpus 1"}));
  EXPECT_GT(period(loop), Millis{10.5}) << "b has at least 1 ms of each frame";
  for (const policy::SubchainPlace& place : loop.decision().assignment.places) EXPECT_EQ(place.cpus, os::CpuSet{1});
  told.clear();
  online = os::CpuSet{0, 1};
  step(loop, at(seconds{4}));
  EXPECT_EQ(told, (Told{"cpus", "plan cpus", "relaxed", "cpus 0-1"}));
  EXPECT_EQ(period(loop), Millis{10});
}

}  // namespace
}  // namespace ctn::driver
