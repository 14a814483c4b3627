#include "trial/schedule.h"

#include <gtest/gtest.h>

#include "plan/testing/sample_plan.h"

namespace ctn::trial {
namespace {

using plan::kBatch;
using plan::kFast;
using plan::kSee;
using plan::kSlow;

TEST(ScheduleOfAPlan, HasFramesAndPipelinesWhereThePlanHas) {
  const graph::App app = plan::sample_app();
  const plan::Plan plan = plan::sample_plan(app, plan::sample_costs(app));
  const Schedule schedule = schedule_of(app, plan);
  EXPECT_EQ(schedule.cores, plan::kSampleCores);
  for (const SubchainId id : {kFast, kSlow, kBatch}) {
    EXPECT_EQ(schedule.subchains[id.index()].form, Form::kFrames);
    EXPECT_EQ(schedule.subchains[id.index()].core, 0);
  }
  EXPECT_EQ(schedule.subchains[kSee.index()].form, Form::kPipeline);
  ASSERT_EQ(schedule.pipelines.size(), 1U);
  EXPECT_EQ(schedule.pipelines[0].subchain, kSee);
  EXPECT_EQ(schedule.pipelines[0].cores, (std::vector<int>{1, 2}));
  // Paced by its own output: two runs overlap.
  EXPECT_EQ(schedule.pipelines[0].pacing.max_in_flight, 2);
  EXPECT_GT(schedule.pipelines[0].pacing.after_completion, Nanos{0});
  ASSERT_EQ(schedule.frames.size(), 3U);
  EXPECT_EQ(schedule.frames[0], dispatch::shared_core_schedule(app, plan, 0, {}));
  EXPECT_TRUE(schedule.frames[1].slots.empty());
}

// One core, the subchain that owns it.
plan::Plan owning(const graph::App& app) {
  plan::Plan plan = plan::sample_plan(app, plan::sample_costs(app));
  plan.subchains[kSee.index()].cores = {1};
  plan.subchains[kSee.index()].period = Millis{25};
  plan.subchains[kSee.index()].execution = Millis{20};
  return plan;
}

TEST(ScheduleOfAPlan, PacesASubchainThatOwnsItsCoreByItsOutput) {
  const graph::App app = plan::sample_app();
  const Place place = schedule_of(app, owning(app)).subchains[kSee.index()];
  EXPECT_EQ(place.form, Form::kPriority);
  EXPECT_EQ(place.core, 1);
  EXPECT_EQ(place.pause, to_nanos(Millis{5}));
  EXPECT_EQ(place.period, dispatch::kShortestPeriod);
}

TEST(ScheduleOfAPlan, PacesItByWhatIsExpectedWhereThePlanSays) {
  const graph::App app = plan::sample_app();
  plan::Plan plan = owning(app);
  plan.expected.emplace();
  plan.expected->subchains.resize(4);
  plan.expected->subchains[kSee.index()] = {Millis{18}, Millis{15}};
  EXPECT_EQ(schedule_of(app, plan).subchains[kSee.index()].pause, to_nanos(Millis{3}));
}

TEST(ScheduleOfAPlan, PacesItByTimeWhereFramesAreFixed) {
  graph::AppSpec spec = plan::sample_spec();
  spec.scheduler.frames = graph::FrameMode::kFixed;
  const graph::App app = graph::build_app(spec).value();
  const Place place = schedule_of(app, owning(app)).subchains[kSee.index()];
  EXPECT_FALSE(place.pause);
  EXPECT_EQ(place.period, to_nanos(Millis{25}));
}

TEST(ScheduleOfAPlan, TakesMembersOfACoreAsTheyAre) {
  const graph::App app = plan::sample_app();
  plan::Plan plan = plan::sample_plan(app, plan::sample_costs(app));
  plan::CorePlan& core = plan.cores[0];
  core.form = plan::Form::kPriorities;
  core.slots.clear();
  plan::Member fast;
  fast.subchain = kFast;
  fast.priority = 3;
  fast.period = Millis{10};
  fast.phase = Millis{2};
  fast.budget = Millis{7};
  plan::Member slow;
  slow.subchain = kSlow;
  slow.priority = 2;
  slow.period = Millis{50};
  slow.pause = Millis{4};
  plan::Member batch;
  batch.subchain = kBatch;
  batch.after = plan::After{kFast, 2};
  core.members = {fast, slow, batch};
  const Schedule schedule = schedule_of(app, plan);
  EXPECT_TRUE(schedule.frames.empty());
  Place expected{
      .priority = 3, .period = to_nanos(Millis{10}), .phase = to_nanos(Millis{2}), .budget = to_nanos(Millis{7})};
  EXPECT_EQ(schedule.subchains[kFast.index()], expected);
  expected = {.priority = 2, .period = to_nanos(Millis{50}), .pause = to_nanos(Millis{4})};
  EXPECT_EQ(schedule.subchains[kSlow.index()], expected);
  expected = {.priority = 1, .after = plan::After{kFast, 2}};
  EXPECT_EQ(schedule.subchains[kBatch.index()], expected);
}

}  // namespace
}  // namespace ctn::trial
