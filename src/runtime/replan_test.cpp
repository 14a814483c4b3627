#include "runtime/replan.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "runtime/test_app.h"

namespace ctn::runtime {
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
  return worth_a_swap(current, candidate, candidate);
}

TEST(WorthASwap, NotForLessThanTheThreshold) {
  EXPECT_FALSE(worth(plan_with(100.0, 90.0), plan_with(101.9, 91.0)));
  EXPECT_FALSE(worth(plan_with(100.0, 90.0), plan_with(98.2, 89.0)));
}

TEST(WorthASwap, ForMoreInEitherDirection) {
  EXPECT_TRUE(worth(plan_with(100.0, 90.0), plan_with(103.0, 90.0)));
  EXPECT_TRUE(worth(plan_with(100.0, 90.0), plan_with(97.0, 90.0)));
  EXPECT_TRUE(worth(plan_with(100.0, 90.0), plan_with(100.0, 95.0)));
}

TEST(WorthASwap, NotForAZeroThatStaysZero) { EXPECT_FALSE(worth(plan_with(1.0, 0.0), plan_with(1.0, 0.0))); }

plan::Plan with_objective(plan::Plan plan, double objective, double factor = 1.0) {
  plan.objective = objective;
  plan.relax_factor = factor;
  return plan;
}

TEST(WorthASwap, ForOtherCoresOnlyIfThatIsBetter) {
  const plan::Plan here = with_objective(plan_with(100.0, 90.0), 50.0);
  const plan::Plan there = plan_with(100.0, 90.0, {1});
  EXPECT_FALSE(worth_a_swap(here, here, with_objective(there, 49.5)));
  EXPECT_TRUE(worth_a_swap(here, here, with_objective(there, 48.5)));
  EXPECT_FALSE(worth_a_swap(here, here, with_objective(there, 40.0, 1.5))) << "bounds before the objective";
  EXPECT_TRUE(
      worth_a_swap(with_objective(here, 50.0, 1.5), with_objective(here, 50.0, 1.5), with_objective(there, 60.0)));
}

TEST(WorthASwap, ForAPlanThatCannotHoldAnyMore) {
  EXPECT_TRUE(worth_a_swap(plan_with(100.0, 90.0), std::nullopt, plan_with(100.0, 90.0)));
}

// A subchain that shares its core, in slices of so long.
plan::Plan sharing(double slice, double objective) {
  plan::Plan plan = with_objective(plan_with(100.0, 100.0), objective);
  plan.subchains[0].slice = Millis{slice};
  plan.cores[0].slots.push_back({SubchainId(0), Millis{0}, Millis{slice}, 1, 0});
  return plan;
}

TEST(WorthASwap, OnASharedCoreForRunsThatOutgrowTheirSlices) {
  EXPECT_FALSE(worth_a_swap(sharing(10.0, 50.0), sharing(10.9, 52.0), sharing(10.9, 52.0)));
  EXPECT_TRUE(worth_a_swap(sharing(10.0, 50.0), sharing(11.1, 52.0), sharing(11.1, 52.0)));
  EXPECT_FALSE(worth_a_swap(sharing(10.0, 50.0), sharing(5.0, 47.0), sharing(5.0, 47.0))) << "frames are elastic";
}

TEST(WorthASwap, ForPromisesThatBecameWrong) {
  EXPECT_TRUE(worth_a_swap(sharing(10.0, 50.0), sharing(5.0, 40.0), sharing(5.0, 40.0)));
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

TEST(WorthASwap, ForAnotherExpectation) {
  const plan::Plan plan = expecting(plan_with(100.0, 94.0), 90.0, 80.0);
  EXPECT_TRUE(worth(plan, expecting(plan, 95.0, 80.0)));
  EXPECT_TRUE(worth(plan, expecting(plan, 90.0, 75.0)));
  EXPECT_FALSE(worth(plan, expecting(plan, 90.5, 80.5)));
}

TEST(ReplanClock, WaitsForTheBootstrapAndForEveryNode) {
  const TimePoint start{};
  ReplanClock clock(start, {});
  EXPECT_FALSE(clock.due(start + seconds{1}, true));
  EXPECT_FALSE(clock.due(start + seconds{3}, false)) << "a node has not run yet";
  EXPECT_TRUE(clock.due(start + seconds{3}, true));
  EXPECT_TRUE(clock.first());
  clock.made(start + seconds{3});
  EXPECT_FALSE(clock.first());
  EXPECT_FALSE(clock.due(start + seconds{3}, true));
  EXPECT_TRUE(clock.due(start + seconds{4}, true));
}

}  // namespace
}  // namespace ctn::runtime
