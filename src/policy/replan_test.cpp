#include "policy/replan.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "config/testing/apps.h"
#include "planner/frames.h"

namespace ctn::policy {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

plan::Plan plan_with(double period, double execution, std::vector<int> cores = {0}) {
  plan::Plan plan;
  plan.cores.resize(2);
  plan.subchains.push_back({.cores = std::move(cores),
                            .period = Millis{period},
                            .execution = Millis{execution},
                            .every = 1,
                            .share = 1.0,
                            .slice = Millis{execution},
                            .threads = 1});
  return plan;
}

// One subchain with a core of its own, which the plan in force would time as the candidate does.
bool worth(const plan::Plan& current, const plan::Plan& candidate) {
  return worth_swapping(current, candidate, candidate);
}

TEST(WorthSwapping, NotForLessThanTheThreshold) {
  EXPECT_FALSE(worth(plan_with(100.0, 90.0), plan_with(101.9, 91.0)));
  EXPECT_FALSE(worth(plan_with(100.0, 90.0), plan_with(98.2, 89.0)));
}

TEST(WorthSwapping, ForMoreInEitherDirection) {
  EXPECT_TRUE(worth(plan_with(100.0, 90.0), plan_with(103.0, 90.0)));
  EXPECT_TRUE(worth(plan_with(100.0, 90.0), plan_with(97.0, 90.0)));
  EXPECT_TRUE(worth(plan_with(100.0, 90.0), plan_with(100.0, 95.0)));
}

TEST(WorthSwapping, NotForAZeroThatStaysZero) { EXPECT_FALSE(worth(plan_with(1.0, 0.0), plan_with(1.0, 0.0))); }

plan::Plan with_objective(plan::Plan plan, double objective, double factor = 1.0) {
  plan.objective = objective;
  plan.relax_factor = factor;
  return plan;
}

TEST(WorthSwapping, ForOtherCoresOnlyIfThatIsBetter) {
  const plan::Plan here = with_objective(plan_with(100.0, 90.0), 50.0);
  const plan::Plan there = plan_with(100.0, 90.0, {1});
  EXPECT_FALSE(worth_swapping(here, here, with_objective(there, 49.5)));
  EXPECT_TRUE(worth_swapping(here, here, with_objective(there, 48.5)));
  EXPECT_FALSE(worth_swapping(here, here, with_objective(there, 40.0, 1.5))) << "bounds before the objective";
  EXPECT_TRUE(
      worth_swapping(with_objective(here, 50.0, 1.5), with_objective(here, 50.0, 1.5), with_objective(there, 60.0)));
}

TEST(WorthSwapping, ForAPlanThatCannotHoldAnyMore) {
  EXPECT_TRUE(worth_swapping(plan_with(100.0, 90.0), std::nullopt, plan_with(100.0, 90.0)));
}

// A subchain that shares its core, in slices of so long.
plan::Plan sharing(double slice, double objective) {
  plan::Plan plan = with_objective(plan_with(100.0, 100.0), objective);
  plan.subchains[0].slice = Millis{slice};
  plan.cores[0].slots.push_back({SubchainId(0), Millis{0}, Millis{slice}, 1, 0});
  return plan;
}

TEST(WorthSwapping, OnASharedCoreForRunsThatOutgrowTheirSlices) {
  EXPECT_FALSE(worth_swapping(sharing(10.0, 50.0), sharing(10.9, 52.0), sharing(10.9, 52.0)));
  EXPECT_TRUE(worth_swapping(sharing(10.0, 50.0), sharing(11.1, 52.0), sharing(11.1, 52.0)));
  EXPECT_FALSE(worth_swapping(sharing(10.0, 50.0), sharing(5.0, 47.0), sharing(5.0, 47.0))) << "frames are elastic";
}

TEST(WorthSwapping, ForPromisesThatBecameWrong) {
  EXPECT_TRUE(worth_swapping(sharing(10.0, 50.0), sharing(5.0, 40.0), sharing(5.0, 40.0)));
}

TEST(Incumbent, YieldsAtAnyRateToTheFirstMeasuredPlanAndToOneForOtherCpus) {
  const graph::App app = tracker_app();
  const model::CostTable costs(app.graph, Millis{5.0});
  auto plan = planner::make_plan_in_frames(app, costs, {});
  ASSERT_TRUE(plan.ok());
  for (const PlanReason why : {PlanReason::kMeasured, PlanReason::kCpus}) {
    const Incumbent incumbent(*plan, why, app, costs, costs);
    EXPECT_TRUE(incumbent.yields_to(*plan));
  }
}

dispatch::Pacing paced(plan::Plan plan, double slack, const char* scheduler = "{}", const char* head = "{}") {
  const graph::App app = parse(std::string("catan: 1\napp: one\nnodes: { a: ") + head +
                               " }\nobjective: [ { response_time: [a], weight: 1 } ]\nscheduler: " + scheduler + "\n");
  plan.slack = slack;
  return pacing_of(app, plan, SubchainId(0));
}

TEST(PacingOf, GivesAHangTenTimesTheExecutionAndASecondAtLeast) {
  EXPECT_EQ(paced(plan_with(400.0, 300.0), 0.0).hang_after, seconds{3});
  EXPECT_EQ(paced(plan_with(10.0, 9.0), 0.0).hang_after, seconds{1});
}

plan::Plan expecting(plan::Plan plan, double period, double execution) {
  plan.expected = plan::Expectation{.objective = 0.0, .subchains = {{Millis{period}, Millis{execution}}}, .chains = {}};
  return plan;
}

TEST(PacingOf, FollowsWhatIsExpected) {
  const plan::Plan plan = expecting(plan_with(100.0, 94.0), 90.0, 80.0);
  EXPECT_EQ(paced(plan, 0.06).period, milliseconds{90});
  EXPECT_EQ(paced(plan, 0.06).after_completion, milliseconds{10});
}

TEST(PacingOf, KeepsThePlannedPeriodWithFixedFramesAndExactRates) {
  const plan::Plan plan = expecting(plan_with(100.0, 94.0), 90.0, 80.0);
  const dispatch::Pacing fixed = paced(plan, 0.06, "{ frames: fixed }");
  EXPECT_EQ(fixed.period, milliseconds{100});
  EXPECT_EQ(fixed.after_completion, Nanos{0});
  const dispatch::Pacing exact = paced(plan, 0.06, "{}", "{ min_rate: 10Hz, max_rate: 10Hz }");
  EXPECT_EQ(exact.period, milliseconds{100});
  EXPECT_EQ(exact.after_completion, Nanos{0});
}

TEST(PacingOf, APlanWithoutExpectationIsTakenAtItsWord) {
  EXPECT_EQ(paced(plan_with(100.0, 94.0), 0.06).after_completion, milliseconds{6});
}

TEST(PacingOf, NeverGoesBeyondARateCap) {
  EXPECT_EQ(paced(plan_with(60.0, 83.0, {0, 1}), 0.06, "{}", "{ max_rate: 17Hz }").shortest,
            to_nanos(Millis{1000.0 / 17}));
}

TEST(WorthSwapping, ForAnotherExpectation) {
  const plan::Plan plan = expecting(plan_with(100.0, 94.0), 90.0, 80.0);
  EXPECT_TRUE(worth(plan, expecting(plan, 95.0, 80.0)));
  EXPECT_TRUE(worth(plan, expecting(plan, 90.0, 75.0)));
  EXPECT_FALSE(worth(plan, expecting(plan, 90.5, 80.5)));
}

TEST(ReplanClock, WaitsForTheBootstrapAndForAnyNode) {
  const TimePoint start{};
  ReplanClock clock(start, {});
  EXPECT_FALSE(clock.due(start + seconds{1}, 2));
  EXPECT_FALSE(clock.due(start + seconds{3}, 0)) << "no node has run yet";
  EXPECT_EQ(clock.due(start + seconds{3}, 2), PlanReason::kMeasured);
  clock.made(start + seconds{3}, PlanReason::kMeasured, milliseconds{1}, 2);
  EXPECT_FALSE(clock.due(start + seconds{3}, 2));
  EXPECT_EQ(clock.due(start + seconds{4}, 2), PlanReason::kPeriodic);
}

TEST(ReplanClock, WhoHasMoreToDoIsAskedAgainAsTheBudgetAllows) {
  const TimePoint start{};
  graph::SchedulerOptions options;
  options.replan = seconds{1000};
  ReplanClock clock(start, options, options.replan, milliseconds{10});
  constexpr bool kMore = true;
  EXPECT_FALSE(clock.due(start + seconds{1}, 2, kMore)) << "still the bootstrap";
  clock.made(start + seconds{3}, PlanReason::kMeasured, milliseconds{8}, 2);
  EXPECT_FALSE(clock.due(start + seconds{3}, 2, kMore)) << "a step at a time";
  EXPECT_EQ(clock.due(start + seconds{3} + kChangeSpacing, 2, kMore), PlanReason::kPeriodic);
  EXPECT_FALSE(clock.due(start + seconds{3} + kChangeSpacing, 2));
  clock.made(start + seconds{4}, PlanReason::kPeriodic, milliseconds{10}, 2);
  EXPECT_FALSE(clock.due(start + seconds{5}, 2, kMore)) << "what was saved is used up";
  EXPECT_EQ(clock.due(start + seconds{9}, 2, kMore), PlanReason::kPeriodic);
}

TEST(ReplanClock, CountsPeriodicPlansInARow) {
  const TimePoint start{};
  ReplanClock clock(start, {}, seconds{5});
  clock.made(start + seconds{3}, PlanReason::kMeasured, Nanos{0}, 1);
  EXPECT_EQ(clock.periodic(), 0);
  EXPECT_FALSE(clock.due(start + seconds{7}, 1));
  for (int count = 1; count <= 3; ++count) {
    const TimePoint at = start + seconds{3} + count * seconds{5};
    EXPECT_EQ(clock.due(at, 1), PlanReason::kPeriodic);
    clock.made(at, PlanReason::kPeriodic, Nanos{0}, 1);
    EXPECT_EQ(clock.periodic(), count);
  }
  clock.made(start + seconds{20}, PlanReason::kChange, Nanos{0}, 1);
  EXPECT_EQ(clock.periodic(), 0);
}

TEST(ReplanClock, ANodeThatHasRunForTheFirstTimeIsPlannedForAtOnce) {
  const TimePoint start{};
  graph::SchedulerOptions options;
  options.replan = seconds{1000};
  ReplanClock clock(start, options);
  EXPECT_EQ(clock.due(start + seconds{3}, 1), PlanReason::kMeasured) << "planned with what is known";
  clock.made(start + seconds{3}, PlanReason::kMeasured, Nanos{0}, 1);
  EXPECT_FALSE(clock.due(start + seconds{4}, 1));
  EXPECT_FALSE(clock.due(start + seconds{3} + kChangeSpacing / 2, 2)) << "others may follow at once";
  EXPECT_EQ(clock.due(start + seconds{4}, 2), PlanReason::kMeasured);
  clock.made(start + seconds{4}, PlanReason::kMeasured, Nanos{0}, 2);
  EXPECT_FALSE(clock.due(start + seconds{5}, 2));
}

TEST(ReplanClock, AChangeIsAnsweredAtOnceButNotStormByStorm) {
  const TimePoint start{};
  ReplanClock clock(start, {});
  clock.changed(PlanReason::kChange);
  EXPECT_FALSE(clock.due(start + seconds{1}, 2)) << "the first plan sees to it";
  clock.made(start + seconds{2}, PlanReason::kMeasured, Nanos{0}, 2);
  EXPECT_FALSE(clock.due(start + milliseconds{2500}, 2));
  int plans = 0;
  for (TimePoint now = start + seconds{3}; now < start + seconds{13}; now += milliseconds{10}) {
    clock.changed(PlanReason::kChange);
    const std::optional<PlanReason> due = clock.due(now, 2);
    if (!due) continue;
    EXPECT_EQ(*due, PlanReason::kChange);
    clock.made(now, *due, Nanos{0}, 2);
    ++plans;
  }
  EXPECT_EQ(plans, 40) << "four a second";
}

TEST(ReplanClock, ExpensivePlansAreMadeSeldom) {
  const TimePoint start{};
  ReplanClock clock(start, {});
  clock.made(start + seconds{2}, PlanReason::kMeasured, milliseconds{120}, 2);
  EXPECT_FALSE(clock.due(start + seconds{25}, 2));
  EXPECT_EQ(clock.due(start + seconds{26}, 2), PlanReason::kPeriodic);
  clock.changed(PlanReason::kPower);
  EXPECT_EQ(clock.due(start + seconds{3}, 2), PlanReason::kPower);
}

TEST(ReplanClock, APlanForOtherCpusBeforeAllWasMeasuredIsNotTheFirstMeasuredOne) {
  const TimePoint start{};
  ReplanClock clock(start, {});
  clock.made(start + seconds{1}, PlanReason::kCpus, milliseconds{5}, 2);
  EXPECT_EQ(clock.due(start + seconds{2}, 2), PlanReason::kMeasured);
}

}  // namespace
}  // namespace ctn::policy
