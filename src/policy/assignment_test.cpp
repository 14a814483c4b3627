#include "policy/assignment.h"

#include <gtest/gtest.h>

#include "plan/testing/sample_plan.h"
#include "policy/replan.h"

namespace ctn::policy {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class FixedPrioritiesTest : public ::testing::Test {
 protected:
  graph::App app = plan::sample_app();
  model::CostTable costs = plan::sample_costs(app);
  plan::Plan plan = plan::sample_priorities(app, costs);
  Assignment assignment = assignment_of(app, plan, os::CpuSet{4, 5, 6}, {});

  const SubchainPlace& place(SubchainId id) const { return assignment.places[id.index()]; }
};

TEST_F(FixedPrioritiesTest, EachHasTheCoreToItselfAtItsOwnLevel) {
  for (const SubchainId id : {plan::kFast, plan::kSlow, plan::kBatch}) {
    EXPECT_EQ(place(id).core, -1) << "no controller of a core takes turns among them";
    EXPECT_EQ(place(id).cpus, os::CpuSet{4});
    EXPECT_EQ(place(id).pacing.max_in_flight, 1);
  }
  EXPECT_EQ(place(plan::kBatch).level, os::fixed_level(0));
  EXPECT_EQ(place(plan::kSlow).level, os::fixed_level(1));
  EXPECT_EQ(place(plan::kFast).level, os::fixed_level(2));
  EXPECT_TRUE(assignment.cores[0].slots.empty());
}

TEST_F(FixedPrioritiesTest, ByTimeAtItsPhaseAndNoFasterThanItsCap) {
  const dispatch::Pacing& pacing = place(plan::kFast).pacing;
  EXPECT_EQ(pacing.period, milliseconds{20});
  EXPECT_EQ(pacing.phase, milliseconds{5});
  EXPECT_EQ(pacing.budget, milliseconds{6});
  EXPECT_FALSE(pacing.after);
  EXPECT_EQ(pacing.after_completion, Nanos{0});
}

TEST_F(FixedPrioritiesTest, ByOutputsOfAnother) {
  const dispatch::Pacing& pacing = place(plan::kSlow).pacing;
  EXPECT_EQ(pacing.after, (plan::After{plan::kFast, 2}));
  EXPECT_FALSE(pacing.phase);
  EXPECT_EQ(pacing.period, milliseconds{40}) << "how often that is expected";
}

TEST_F(FixedPrioritiesTest, AfterAPause) {
  const dispatch::Pacing& pacing = place(plan::kBatch).pacing;
  EXPECT_EQ(pacing.after_completion, milliseconds{10});
  EXPECT_EQ(pacing.shortest, milliseconds{15});
  EXPECT_FALSE(pacing.phase);
  EXPECT_GE(pacing.period, to_nanos(plan.subchains[3].slice) + milliseconds{10}) << "as those below it were promised";
}

// A promise may be many times what happens.
TEST_F(FixedPrioritiesTest, ARunHangsThatTakesTenUsualPeriods) {
  plan::Plan changed = plan;
  const auto hang_after = [&](double execution, double period) {
    changed.subchains[3].execution = Millis{execution};
    changed.expected.emplace();
    changed.expected->subchains.assign(plan.subchains.size(), {.period = Millis{period}});
    return assignment_of(app, changed, os::CpuSet{4, 5, 6}, {}).places[3].pacing.hang_after;
  };
  EXPECT_EQ(hang_after(5000.0, 300.0), seconds{3});
  EXPECT_EQ(hang_after(200.0, 300.0), seconds{2});
  EXPECT_EQ(hang_after(5000.0, 10.0), kShortestHang);
  changed.for_typical = true;
  for (plan::Member& member : changed.cores[0].members) member.budget = Millis{400};
  EXPECT_EQ(hang_after(200.0, 10.0), seconds{4}) << "its budget is longer than what is promised of typical runs";
  for (plan::Member& member : changed.cores[0].members) member.budget = Millis{40};
  EXPECT_EQ(hang_after(200.0, 300.0), seconds{2}) << "and need not be";
}

// However short its own runs are, those above it may keep the core for as long as their budgets.
TEST_F(FixedPrioritiesTest, ARunDoesNotHangWhileThoseAboveKeepToTheirBudgets) {
  plan::Plan changed = plan;
  for (plan::Member& member : changed.cores[0].members) member.budget = Millis{700};
  const Assignment held_up = assignment_of(app, changed, os::CpuSet{4, 5, 6}, {});
  const auto hang_after = [&](SubchainId id) { return held_up.places[id.index()].pacing.hang_after; };
  EXPECT_EQ(hang_after(plan::kFast), kShortestHang);
  EXPECT_EQ(hang_after(plan::kSlow), milliseconds{1400});
  EXPECT_EQ(hang_after(plan::kBatch), milliseconds{2100});
}

TEST_F(FixedPrioritiesTest, WhoFollowsAnAbsentSubchainGoesByTime) {
  std::vector<bool> present(plan.subchains.size(), true);
  present[plan::kFast.index()] = false;
  remove_absent(assignment, present);
  EXPECT_FALSE(place(plan::kFast).present);
  EXPECT_FALSE(place(plan::kSlow).pacing.after);
  EXPECT_EQ(place(plan::kSlow).pacing.period, milliseconds{40});
}

}  // namespace
}  // namespace ctn::policy
