#include "dispatch/shared_core_schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plan/testing/sample_plan.h"

namespace ctn::dispatch {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

struct Sample {
  graph::App app = plan::sample_app();
  plan::Plan plan = plan::sample_plan(app, plan::sample_costs(app));
};

TEST(SharedCoreScheduleOf, TakesThePlansFrameAndSlots) {
  const Sample sample;
  const SharedCoreSchedule schedule = shared_core_schedule(sample.app, sample.plan, 0, {});
  EXPECT_EQ(schedule.frames, graph::FrameMode::kElastic);
  EXPECT_EQ(schedule.frame, std::chrono::milliseconds{20});
  EXPECT_EQ(schedule.frame_min, std::chrono::milliseconds{10});
  EXPECT_EQ(schedule.slack, 0.05);
  ASSERT_THAT(schedule.slots, SizeIs(3));
  const SharedCoreSlot& slow = schedule.slots[1];
  EXPECT_EQ(slow.subchain, plan::kSlow);
  EXPECT_EQ(slow.offset, std::chrono::milliseconds{6});
  EXPECT_EQ(slow.slice, std::chrono::milliseconds{5});
  EXPECT_EQ(slow.every, 4);
  EXPECT_EQ(slow.phase, 3);
  EXPECT_EQ(slow.hang_after, Nanos{0});
  EXPECT_FALSE(schedule.slots[2].every);
  EXPECT_EQ(schedule.slots[2].share, 1.5);
}

TEST(SharedCoreScheduleOf, RanksByStealingPriorityAndKnowsWhoMayNot) {
  Sample sample;
  sample.app.steal.priority = {plan::kSee, plan::kBatch, plan::kFast, plan::kSlow};
  sample.app.steal.off = {plan::kFast};
  const SharedCoreSchedule schedule = shared_core_schedule(sample.app, sample.plan, 0, {});
  const auto ranks = [&](std::size_t slot) { return schedule.slots[slot].rank; };
  EXPECT_THAT((std::vector<int>{ranks(0), ranks(1), ranks(2)}), ElementsAre(2, 3, 1));
  EXPECT_FALSE(schedule.slots[0].may_steal);
  EXPECT_TRUE(schedule.slots[1].may_steal);
  for (const SharedCoreSlot& slot : shared_core_schedule(sample.app, sample.plan, 0, {.stealing = false}).slots) {
    EXPECT_FALSE(slot.may_steal);
  }
}

TEST(SharedCoreScheduleOf, TakesARunToHangAfterAMultipleOfWhatWasPlanned) {
  const Sample sample;
  const ScheduleOptions options{.hang_multiple = 10.0, .shortest_hang = std::chrono::milliseconds{500}};
  const SharedCoreSchedule schedule = shared_core_schedule(sample.app, sample.plan, 0, options);
  EXPECT_EQ(schedule.slots[0].hang_after, std::chrono::milliseconds{500}) << "10 x 20 ms are less";
  EXPECT_EQ(schedule.slots[1].hang_after, std::chrono::milliseconds{800});
}

TEST(SharedCoreScheduleOf, WhoWasPlannedAtNoCostStillEndsItsRunInElasticFrames) {
  Sample sample;
  sample.plan.cores[0].slots[0].slice = Millis{0};
  sample.plan.cores[0].slots[1].slice = Millis{0};
  const SharedCoreSchedule elastic = shared_core_schedule(sample.app, sample.plan, 0, {});
  EXPECT_EQ(elastic.slots[0].slice, kSwitchAllowance);
  EXPECT_EQ(elastic.slots[1].slice, kShortestSlice);
  sample.plan.cores[0].frames = graph::FrameMode::kFixed;
  sample.plan.cores[0].frame = Millis{0};
  sample.plan.cores[0].idle = Millis{0};
  const SharedCoreSchedule fixed = shared_core_schedule(sample.app, sample.plan, 0, {});
  EXPECT_EQ(fixed.slots[0].slice, Nanos{0}) << "offsets are as planned";
  EXPECT_EQ(fixed.frame, kShortestFrame);
}

TEST(SharedCoreScheduleOf, ElasticFramesAllowForTheHandOverWhereARunIsToEndInItsSlot) {
  const Sample sample;
  const SharedCoreSchedule schedule = shared_core_schedule(sample.app, sample.plan, 0, {});
  const auto more_than_planned = [&](std::size_t slot) {
    return schedule.slots[slot].slice - to_nanos(sample.plan.cores[0].slots[slot].slice);
  };
  EXPECT_EQ(more_than_planned(0), kSwitchAllowance) << "in every frame";
  EXPECT_EQ(more_than_planned(1), Nanos{0}) << "every fourth frame, a quarter of a run at a time";
  EXPECT_EQ(more_than_planned(2), Nanos{0}) << "a queue, by its share";
}

TEST(SharedCoreScheduleOf, WhoWaitsLongerThanAHandOverDoesNotSteal) {
  Sample sample;
  EXPECT_TRUE(shared_core_schedule(sample.app, sample.plan, 0, {}).slots[0].may_steal);
  plan::SubchainPlan& first = sample.plan.subchains[sample.plan.cores[0].slots[0].subchain.index()];
  first.wait = Millis{0.2};
  EXPECT_TRUE(shared_core_schedule(sample.app, sample.plan, 0, {}).slots[0].may_steal);
  first.wait = Millis{0.3};
  EXPECT_FALSE(shared_core_schedule(sample.app, sample.plan, 0, {}).slots[0].may_steal);
}

TEST(SharedCoreScheduleOf, IdleTimeOfFixedFramesGoesToTheSlotsFirst) {
  Sample sample;
  sample.plan.cores[0].frames = graph::FrameMode::kFixed;
  for (const auto& [idle, more] : {std::pair{Millis{0.3}, 100}, std::pair{Millis{3.0}, 200}, std::pair{Millis{0}, 0}}) {
    sample.plan.cores[0].idle = idle;
    const SharedCoreSchedule schedule = shared_core_schedule(sample.app, sample.plan, 0, {});
    for (std::size_t slot = 0; slot < schedule.slots.size(); ++slot) {
      const plan::Slot& planned = sample.plan.cores[0].slots[slot];
      const Nanos extra = std::chrono::microseconds{more};
      EXPECT_EQ(schedule.slots[slot].slice, to_nanos(planned.slice) + extra);
      EXPECT_EQ(schedule.slots[slot].offset, to_nanos(planned.offset) + static_cast<std::int64_t>(slot) * extra);
    }
  }
}

TEST(SharedCoreScheduleOf, ACoreThatNobodySharesHasNoSlots) {
  const Sample sample;
  EXPECT_THAT(shared_core_schedule(sample.app, sample.plan, 1, {}).slots, IsEmpty());
}

}  // namespace
}  // namespace ctn::dispatch
