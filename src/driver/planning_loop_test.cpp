// When a plan is made, and what of it is told, with a world that says what the test wants.
#include "driver/planning_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "config/testing/apps.h"

namespace ctn::driver {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TimePoint at(Nanos offset) { return TimePoint{} + offset; }

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
                                                       const policy::Decision& in_force,
                                                       double to_beat) const override {
    asked.push_back(situation.costs[NodeId(0)].single_thread().count());
    if (fails) return Error::caller("there is no plan", "wait");
    return real_->decide_again(situation, in_force, to_beat);
  }

  mutable std::vector<double> asked;  // what node a costs
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
    const TimePoint begin = at(milliseconds{100} * number);
    for (const NodeId node : {NodeId(0), NodeId(1)}) loop.ran({node, number, begin, begin + cpu, cpu, 0, true, {}});
  }
  void turn(PlanningLoop& loop, TimePoint now) {
    loop.plan(now, *this);
    loop.adopt(*this);
  }

  Result<os::CpuSet> online_cpus() override { return online; }
  os::PowerState power_state() override { return {}; }
  void in_force(const policy::Decision& /*decision*/, policy::PlanReason reason) override {
    told.push_back(std::string("plan ") + policy::to_string(reason));
  }
  void cpus_changed(const os::CpuSet& cpus) override { told.push_back("cpus " + os::to_string(cpus)); }
  void notice(const std::string& kind, const std::string& /*detail*/) override { told.push_back(kind); }

  graph::App app = parse(kTwo);
  std::shared_ptr<Tested> tested = std::make_shared<Tested>();
  os::CpuSet online{0};
  std::vector<std::string> told;
};

using Told = std::vector<std::string>;

TEST_F(PlanningLoopTest, PlansOnceTheBootstrapIsOverAndEveryNodeHasRun) {
  PlanningLoop loop = loop_of();
  EXPECT_FALSE(loop.plan(at(seconds{2}), *this)) << "nobody has run";
  run(loop, 1, milliseconds{10});
  EXPECT_FALSE(loop.plan(at(milliseconds{900}), *this)) << "the bootstrap is not over";
  EXPECT_TRUE(loop.plan(at(seconds{2}), *this));
  EXPECT_EQ(told, (Told{"plan bootstrap"})) << "not adopted yet";
  loop.adopt(*this);
  EXPECT_EQ(told, (Told{"plan bootstrap", "plan measured"}));
  EXPECT_EQ(loop.budget().spent(), std::chrono::microseconds{100});
}

TEST_F(PlanningLoopTest, ForgetsANodesColdRunsOnceItHasOthers) {
  PlanningLoop loop = loop_of();
  const Nanos cpu[] = {milliseconds{90}, milliseconds{30}, milliseconds{30}, milliseconds{20}};
  for (std::uint64_t number = 1; number <= 4; ++number) run(loop, number, cpu[number - 1]);
  turn(loop, at(seconds{2}));
  EXPECT_EQ(tested->asked, (std::vector<double>{20.0}));
}

TEST_F(PlanningLoopTest, AFailureIsToldOnceAndThePlanInForceStays) {
  PlanningLoop loop = loop_of();
  run(loop, 1, milliseconds{10});
  tested->fails = true;
  turn(loop, at(seconds{2}));
  turn(loop, at(seconds{20}));
  turn(loop, at(seconds{40}));
  EXPECT_GE(tested->asked.size(), 2U);
  EXPECT_EQ(told, (Told{"plan bootstrap", "replan-failed"}));
  EXPECT_TRUE(loop.decision().plan.has_value());
}

TEST_F(PlanningLoopTest, ACpuThatGoesIsPlannedForAtOnceAndThenTold) {
  PlanningLoop loop = loop_of({0, 1});
  run(loop, 1, milliseconds{10});
  turn(loop, at(seconds{2}));
  told.clear();
  online = os::CpuSet{1};
  turn(loop, at(seconds{2} + milliseconds{100}));
  EXPECT_EQ(told, (Told{"cpus", "plan cpus", "cpus 1"}));
  EXPECT_EQ(loop.decision().assignment.places.front().cpus, os::CpuSet{1});
  EXPECT_EQ(loop.decision().assignment.cores.size(), 2U) << "cores are those that were given";
}

}  // namespace
}  // namespace ctn::driver
