// Turns, rates and slack of a shared core, in virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "dispatch/shared_core_dispatcher.h"
#include "dispatch/testing/shared_core_samples.h"
#include "dispatch/testing/virtual_core.h"

namespace ctn::dispatch {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<Nanos> sent_at(const VirtualCore& core, int subchain) {
  std::vector<Nanos> times;
  const auto found = core.triggers.find(SubchainId(static_cast<std::size_t>(subchain)));
  if (found == core.triggers.end()) return times;
  for (const VirtualCore::Triggered& trigger : found->second) times.push_back(trigger.sent.time_since_epoch());
  return times;
}

TEST(ElasticFrames, SubchainsTakeTurnsAndOrdinaryThreadsHaveTheSlack) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}), costs({{4}, {4}}));
  core.run_until(at(ms(20)));
  EXPECT_EQ(core.timeline(), "0:4 1:4 .:2 0:4 1:4 .:2");
}

TEST(ElasticFrames, ASlotEndsWithItsRunAndTheSlackIsAShareOfWhatWasUsed) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}), costs({{2, 4}, {4, 2}}));
  core.run_until(at(ms(15)));
  EXPECT_EQ(core.timeline(), "0:2 1:4 .:1.5 0:4 1:2 .:1.5");
}

TEST(ElasticFrames, ARunGoesOnInItsNextSlotsAndDelaysItsNextTrigger) {
  const auto schedule = without_stealing(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}));
  auto core = VirtualCore::with_all(schedule, costs({{6, 4}, {4}}));
  core.run_until(at(ms(21.5)));
  EXPECT_EQ(core.timeline(), "0:4 1:4 .:2 0:2 1:4 .:1.5 0:4");
  ASSERT_EQ(sent_at(core, 0).size(), 2U);
  EXPECT_EQ(core.triggers[SubchainId(0)][1].sent, at(ms(17.5))) << "the first slot that finds it ended";
  EXPECT_EQ(core.triggers[SubchainId(0)][1].due, at(ms(10))) << "the slot in which it was due";
}

TEST(ElasticFrames, TriggersEveryNthFrameFromItsPhaseOn) {
  const auto schedule = elastic({every(1, 0, ms(4)), every(3, 1, ms(4), 1)}, 0.0);
  auto core = VirtualCore::with_all(schedule, costs({{4}, {4}}));
  core.run_until(at(ms(32)));
  EXPECT_EQ(core.timeline(), "0:8 1:4 0:12 1:4 0:4") << "frames 1, 4, ...; its slot is left out in the others";
}

TEST(ElasticFrames, ACappedSubchainIsDeferredAndHoldsNobodyUp) {
  // Every second frame is often enough for 16 ms if frames take 8 ms; they take 4.
  SharedCoreSlot capped = every(2, 1, ms(4));
  capped.min_period = ms(16);
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(4)), capped}, 0.0), costs({{4}, {1}}));
  core.run_until(at(ms(60)));
  EXPECT_THAT(sent_at(core, 1), ElementsAre(ms(4), ms(25), ms(46)));
  EXPECT_EQ(core.timeline(), "0:4 1:1 0:20 1:1 0:20 1:1 0:13") << "the frame that begins 16 ms after its last trigger";
}

TEST(ElasticFrames, ACappedQueueIsDeferredToo) {
  SharedCoreSlot capped = queue(0.5, 1, ms(4));
  capped.min_period = ms(16);
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(4)), capped}, 0.0), costs({{4}, {1}}));
  core.run_until(at(ms(60)));
  EXPECT_THAT(sent_at(core, 1), ElementsAre(ms(4), ms(25), ms(46)));
}

TEST(ElasticFrames, ARunThatWasPlannedForSeveralFramesTakesASliceOfEach) {
  const auto schedule = elastic({every(1, 0, ms(4)), every(3, 1, ms(2))}, 0.0);
  auto core = VirtualCore::with_all(schedule, costs({{4}, {6}}));
  core.run_until(at(ms(24)));
  EXPECT_EQ(core.timeline(), "0:4 1:2 0:4 1:2 0:4 1:2 0:4 1:2");
  EXPECT_THAT(sent_at(core, 1), ElementsAre(ms(4), ms(22)));
  EXPECT_THAT(core.steals, IsEmpty());
}

TEST(ElasticFrames, AnOverdueTriggerDoesNotWaitForAnotherNFrames) {
  const auto schedule = without_stealing(elastic({every(1, 0, ms(4)), every(3, 1, ms(2))}, 0.0));
  auto core = VirtualCore::with_all(schedule, costs({{4}, {7, 1}}));
  core.run_until(at(ms(60)));
  // Frame 3 finds it under way, frame 4 does not; frame 6 is its own again.
  EXPECT_EQ(sent_at(core, 1)[1], ms(4 + 6 + 6 + 6 + 1 + 4));
  EXPECT_EQ(sent_at(core, 1)[2], ms(4 + 6 + 6 + 6 + 5 + 5 + 4));
}

TEST(ElasticFrames, NoFrameIsShorterThanItsMinimum) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(2))}, 0.2, ms(10)), costs({{2, 2, 9.5}}));
  core.run_until(at(ms(24)));
  EXPECT_EQ(core.timeline(), "0:2 .:8 0:2 .:8 0:2 b0:2") << "a run that is not done goes on in the background";
}

TEST(ElasticFrames, AskForNothingWhileNobodyHasWork) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(2))}, 0.2, ms(10)), costs({{2}}));
  core.run_until(at(ms(99)));
  EXPECT_EQ(core.calls, 2U * 10U) << "the frame's start and the run's end";
}

TEST(ElasticFrames, WhatHasToBeWaitedIsTheBackgroundsButForTheSlack) {
  const auto schedule = without_stealing(elastic({every(1, 0, ms(2)), every(1, 1, ms(2))}, 0.2, ms(10)));
  auto core = VirtualCore::with_all(schedule, costs({{2}, {17, 1}}));
  core.run_until(at(ms(40)));
  EXPECT_EQ(core.timeline(), "0:2 1:2 b1:4 .:2 0:2 1:2 b1:4 .:2 0:2 1:2 b1:3 .:3 0:2 1:1 .:7");
}

TEST(ElasticFrames, SlackTooSmallForTwoSwitchesIsSavedUp) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(0.5))}), costs({{0.5}}));
  core.run_until(at(ms(2.5)));
  EXPECT_EQ(core.timeline(), "0:1 .:0.25 0:1 .:0.25");
}

TEST(ElasticFrames, WhoCostsNothingDoesNotKeepTheDispatcherBusy) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, Nanos{0}), every(1, 1, Nanos{0})}, 0.0), costs({{0}, {0}}));
  core.run_until(at(ms(100)));
  EXPECT_EQ(core.frames.size(), 1001U);
  EXPECT_LE(core.calls, 2U * core.frames.size());
  EXPECT_EQ(sent_at(core, 1).size(), 1001U) << "without a slice it is still triggered";
}

TEST(ElasticFrames, FramesWithNothingDuePassInTheirShortestTime) {
  auto core = VirtualCore::with_all(elastic({every(4, 0, ms(1), 3)}, 0.0), costs({{1}}));
  core.run_until(at(ms(3)));
  EXPECT_THAT(sent_at(core, 0), ElementsAre(ms(0.3), ms(1.6), ms(2.9)));
}

TEST(ElasticFrames, ALateDispatcherCostsNobodyHisSlice) {
  // Each timer is 1 ms late. The slots are cut short by it on neither side, and the slack grows with what was used.
  const auto schedule = without_stealing(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}));
  auto core = VirtualCore::with_all(schedule, costs({{1000}, {1000}}), [](std::uint64_t) { return ms(1); });
  core.run_until(at(ms(27)));
  EXPECT_EQ(core.timeline(), "0:5 1:5 .:3.5 0:5 1:5 .:3.5");
}

TEST(FixedFrames, SlotsKeepToTheirOffsetsAndWhatIsLeftIsTheBackgrounds) {
  const auto schedule = without_stealing(fixed({every(1, 0, ms(4)), every(1, 1, ms(4))}, ms(10)));
  auto core = VirtualCore::with_all(schedule, costs({{2}, {12, 3}}));
  core.run_until(at(ms(30)));
  EXPECT_EQ(core.timeline(), "0:2 .:2 1:4 .:2 0:2 b1:2 1:4 .:2 0:2 b1:2 1:3 .:3");
  EXPECT_THAT(sent_at(core, 0), ElementsAre(ms(0), ms(10), ms(20), ms(30)));
  EXPECT_THAT(sent_at(core, 1), ElementsAre(ms(4), ms(24))) << "at 14 ms its run was under way";
}

TEST(FixedFrames, PlannedIdleTimeIsTheBackgroundsAndTheSlackIsNot) {
  auto core = VirtualCore::with_all(fixed({every(1, 0, ms(4))}, ms(10)), costs({{100}}));
  core.run_until(at(ms(20)));
  EXPECT_EQ(core.timeline(), "0:4 b0:4 .:2 0:4 b0:4 .:2");
}

TEST(FixedFrames, ALateCallDoesNotShiftTheGrid) {
  // Each timer is 3 ms late: the slots' time is lost, their triggers are not.
  const auto schedule = without_stealing(fixed({every(1, 0, ms(2)), every(1, 1, ms(2))}, ms(20)));
  auto core = VirtualCore::with_all(schedule, costs({{1}, {1}}), [](std::uint64_t) { return ms(3); });
  core.run_until(at(ms(100)));
  EXPECT_THAT(sent_at(core, 0), ElementsAre(ms(0), ms(23), ms(43), ms(63), ms(83)));
  EXPECT_THAT(sent_at(core, 1), ElementsAre(ms(5), ms(23), ms(43), ms(63), ms(83)));
  EXPECT_EQ(core.triggers[SubchainId(1)][1].due, at(ms(22)));
}

TEST(FixedFrames, AWholeFrameLateTheGridRestarts) {
  SharedCoreDispatcher dispatcher(at(ms(0)), fixed({every(1, 0, ms(2)), every(1, 1, ms(2))}, ms(10)));
  dispatcher.adopt(SubchainId(0), {});
  dispatcher.adopt(SubchainId(1), {});
  ASSERT_THAT(dispatcher.step(at(ms(0)), {}).triggers, SizeIs(1));
  const std::vector<std::uint64_t> none{0, 0};
  ASSERT_EQ(dispatcher.step(at(ms(1)), none).ask_at, at(ms(2)));
  const std::vector<std::uint64_t> first{1, 0};
  const auto& late = dispatcher.step(at(ms(37)), first);
  EXPECT_EQ(dispatcher.frames(), 2U) << "missed frames are not made up for";
  EXPECT_EQ(late.ask_at, at(ms(39)));
}

TEST(FixedFrames, ASlotThatIsOverBeforeItWasLookedAtHasItsTriggerSent) {
  const auto schedule = fixed({every(1, 0, ms(2)), every(1, 1, ms(2)), every(1, 2, ms(2))}, ms(10));
  SharedCoreDispatcher dispatcher(at(ms(0)), without_stealing(schedule));
  for (const std::size_t index : {0U, 1U, 2U}) dispatcher.adopt(SubchainId(index), {});
  const auto& late = dispatcher.step(at(ms(5)), {});
  ASSERT_THAT(late.triggers, SizeIs(3));
  ASSERT_THAT(late.levels, SizeIs(3));
  EXPECT_EQ(late.levels[2].subchain, SubchainId(2));
  EXPECT_EQ(late.levels[2].level, MemberLevel::kActive);
  EXPECT_THAT(late.steals, IsEmpty());
}

TEST(QueueNodes, ASmallShareEarnsARunNowAndThen) {
  const auto schedule = elastic({every(1, 0, ms(4)), queue(0.25, 1, ms(1))}, 0.0);
  auto core = VirtualCore::with_all(schedule, costs({{4}, {1}}));
  core.run_until(at(ms(50)));
  EXPECT_THAT(sent_at(core, 1), ElementsAre(ms(4), ms(21), ms(38))) << "the first at once, then every fourth frame";
}

TEST(QueueNodes, ALongRunIsServedByTheShareAndFollowedAtOnceIfThereIsCredit) {
  const auto schedule = elastic({every(1, 0, ms(4)), queue(0.4, 1, ms(2))}, 0.0);
  auto core = VirtualCore::with_all(schedule, costs({{4}, {5}}));
  core.run_until(at(ms(600)));
  EXPECT_EQ(core.timeline().substr(0, 32), "0:4 1:2 0:4 1:2 0:4 1:1 0:4 1:2 ");
  EXPECT_NEAR(static_cast<double>(core.completions[SubchainId(1)].size()), 40, 1);
  EXPECT_THAT(core.steals, IsEmpty());
}

TEST(QueueNodes, ALargeShareRunsSeveralTimesInASlot) {
  const auto schedule = elastic({every(1, 0, ms(4)), queue(2.0, 1, ms(4))}, 0.0);
  auto core = VirtualCore::with_all(schedule, costs({{4}, {2}}));
  core.run_until(at(ms(13)));
  EXPECT_THAT(sent_at(core, 1), ElementsAre(ms(4), ms(6), ms(12)));
  const auto fixed_schedule = fixed({every(1, 0, ms(4)), queue(2.0, 1, ms(4))}, ms(10));
  auto fixed_core = VirtualCore::with_all(fixed_schedule, costs({{4}, {2}}));
  fixed_core.run_until(at(ms(15)));
  EXPECT_THAT(sent_at(fixed_core, 1), ElementsAre(ms(4), ms(6), ms(14)));
}

TEST(QueueNodes, AFractionAboveOneIsCarriedOver) {
  const auto schedule = elastic({every(1, 0, ms(4)), queue(1.5, 1, ms(3))}, 0.0);
  auto core = VirtualCore::with_all(schedule, costs({{4}, {2}}));
  core.run_until(at(ms(700)));
  EXPECT_NEAR(static_cast<double>(core.completions[SubchainId(1)].size()), 150, 2);
  EXPECT_NEAR(static_cast<double>(core.completions[SubchainId(0)].size()), 100, 2);
  EXPECT_THAT(core.steals, IsEmpty());
}

TEST(QueueNodes, ALongPauseMakesNoBurst) {
  const auto schedule = without_stealing(elastic({every(1, 0, ms(4)), queue(1.0, 1, ms(4))}, 0.0));
  auto core = VirtualCore::with_all(schedule, costs({{4}, {400, 0.01}}));
  core.run_until(at(ms(796)));
  ASSERT_EQ(sent_at(core, 1).size(), 1U);
  core.run_until(at(ms(804)));
  EXPECT_LE(sent_at(core, 1).size(), 3U);
}

TEST(Slack, NobodyIsAboveOrdinaryThreadsInIt) {
  const auto schedule = without_stealing(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}));
  auto core = VirtualCore::with_all(schedule, costs({{1000}, {1000}}));
  core.run_until(at(ms(1000)));
  EXPECT_EQ(core.ordinary_time(at(ms(0)), at(ms(1000))), ms(200));
}

TEST(Slack, IsThereInFixedFramesWithHangingRunsToo) {
  auto schedule = fixed({every(1, 0, ms(4)), every(1, 1, ms(4))}, ms(10));
  for (SharedCoreSlot& slot : schedule.slots) slot.hang_after = ms(50);
  auto core = VirtualCore::with_all(schedule, costs({{1000}, {1000}}));
  core.run_until(at(ms(1000)));
  for (const TimePoint frame : core.frames) {
    if (frame < at(ms(1000))) {
      EXPECT_EQ(core.ordinary_time(frame, frame + ms(10)), ms(2));
    }
  }
}

TEST(Levels, ChangeNoMoreThanTheyMust) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}), costs({{4}, {4}}));
  core.run_until(at(ms(9.9)));
  EXPECT_EQ(core.level_changes, 5U) << "both from ordinary, one to the other, back; the slack lowers none that is done";
  core.run_until(at(ms(99.9)));
  EXPECT_EQ(core.level_changes, 5U + 9U * 4U);
}

TEST(SharedCore, WithoutMembersThereIsNothingToAskFor) {
  SharedCoreDispatcher dispatcher(at(ms(0)), elastic({every(1, 0, ms(4))}));
  EXPECT_EQ(dispatcher.step(at(ms(0)), {}).ask_at, kNever);
  dispatcher.adopt(SubchainId(0), {});
  const auto& decision = dispatcher.step(at(ms(7)), {});
  ASSERT_THAT(decision.triggers, SizeIs(1));
  EXPECT_EQ(decision.triggers[0].due, at(ms(7)));
  EXPECT_EQ(decision.wake_on_completion, SubchainId(0));
}

TEST(SharedCore, ProgressIsNotTrusted) {
  SharedCoreDispatcher dispatcher(at(ms(0)), elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}, 0.0));
  dispatcher.adopt(SubchainId(0), {});
  dispatcher.adopt(SubchainId(1), {});
  const auto step = [&](double now, std::vector<std::uint64_t> completed) -> const SharedCoreDispatcher::Decision& {
    return dispatcher.step(at(ms(now)), completed);
  };
  ASSERT_THAT(step(0, {0, 0}).triggers, SizeIs(1));
  EXPECT_THAT(step(1, {0, 99}).triggers, IsEmpty()) << "that one was never triggered";
  EXPECT_EQ(step(2, {99, 99}).triggers.at(0).subchain, SubchainId(1)) << "one run, however many are claimed";
  EXPECT_THAT(step(2.5, {0, 0}).triggers, IsEmpty());
  const auto& next = step(3, {0, 1, 7, 7});
  ASSERT_THAT(next.triggers, SizeIs(1)) << "what has ended stays so";
  EXPECT_EQ(next.triggers[0].number, 2U);
  EXPECT_THAT(step(4, {}).triggers, IsEmpty());
  EXPECT_THAT(step(1, {2}).triggers, SizeIs(1)) << "time stands still at 4 ms";
  EXPECT_EQ(step(1, {2}).ask_at, at(ms(8)));
}

TEST(SharedCore, CalledTwiceItHasNothingToAdd) {
  SharedCoreDispatcher dispatcher(at(ms(0)), elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}));
  dispatcher.adopt(SubchainId(0), {});
  dispatcher.adopt(SubchainId(1), {});
  const TimePoint ask_at = dispatcher.step(at(ms(0)), {}).ask_at;
  const auto& again = dispatcher.step(at(ms(0)), {});
  EXPECT_THAT(again.levels, IsEmpty());
  EXPECT_THAT(again.triggers, IsEmpty());
  EXPECT_EQ(dispatcher.frames(), 1U);
  EXPECT_EQ(again.ask_at, ask_at);
}

TEST(SharedCore, WithAnEmptyScheduleItLeavesEverybodyOrdinaryAndTriggersNothing) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}), costs({{6}, {4}}));
  core.run_until(at(ms(5)));
  core.change_schedule({});
  core.run_until(at(ms(100)));
  EXPECT_THAT(core.handed_over, SizeIs(2));
  for (const auto& [subchain, what] : core.handed_over) EXPECT_EQ(what.second.level, MemberLevel::kOrdinary);
  const auto& decision = core.dispatcher.step(at(ms(100)), {});
  EXPECT_EQ(decision.ask_at, kNever);
  EXPECT_THAT(decision.triggers, IsEmpty());
}

TEST(Hang, IsReportedOnceAndItsEndOnce) {
  auto schedule = elastic({every(1, 0, ms(4)), every(1, 1, ms(4))});
  schedule.slots[0].hang_after = ms(50);
  auto core = VirtualCore::with_all(schedule, costs({{4, 100, 4}, {4}}));
  core.run_until(at(ms(1000)));
  ASSERT_THAT(core.hangs, SizeIs(2));
  EXPECT_TRUE(core.hangs[0].second.began);
  EXPECT_EQ(core.hangs[0].first, at(ms(60)));
  EXPECT_FALSE(core.hangs[1].second.began);
  EXPECT_GT(sent_at(core, 0).size(), 50U) << "triggers resume";
}

TEST(Hang, IsSuspendedOutsideItsSlot) {
  auto schedule = elastic({every(1, 0, ms(4)), every(1, 1, ms(4)), every(2, 2, ms(2))}, 0.2, ms(20));
  for (SharedCoreSlot& slot : schedule.slots) slot.hang_after = ms(50);
  auto core = VirtualCore::with_all(schedule, costs({{1e6}, {4}, {4}}));
  core.run_until(at(ms(2000)));
  EXPECT_THAT(core.hangs, SizeIs(1));
  EXPECT_EQ(core.cpu_time(SubchainId(0), at(ms(100)), at(ms(2000))), ms(4 * 95)) << "not in the background either";
  EXPECT_NEAR(static_cast<double>(sent_at(core, 1).size()), 100, 4);
  EXPECT_NEAR(static_cast<double>(sent_at(core, 2).size()), 50, 4);
}

// A process that is stopped and goes on had all threads wait for a quarter of the time that it was stopped.
TEST(Standstill, IsNotChargedAsSlack) {
  SharedCoreDispatcher dispatcher(at(ms(0)), elastic({every(1, 0, ms(4))}));
  dispatcher.adopt(SubchainId(0), {});
  ASSERT_THAT(dispatcher.step(at(ms(0)), std::vector<std::uint64_t>{0}).triggers, SizeIs(1));
  const auto& late = dispatcher.step(at(ms(1000)), std::vector<std::uint64_t>{1});
  EXPECT_EQ(late.ask_at, at(ms(1001))) << "a fifth of the frame, as for its 4 ms";
}

TEST(Standstill, HasRunsWatchedAgain) {
  auto schedule = elastic({every(1, 0, ms(4))});
  schedule.slots[0].hang_after = ms(500);
  SharedCoreDispatcher dispatcher(at(ms(0)), schedule);
  dispatcher.adopt(SubchainId(0), {});
  const std::vector<std::uint64_t> none{0};
  ASSERT_THAT(dispatcher.step(at(ms(0)), none).triggers, SizeIs(1));
  EXPECT_THAT(dispatcher.step(at(ms(1000)), none).hangs, IsEmpty()) << "nobody looked meanwhile";
  EXPECT_LE(dispatcher.step(at(ms(1001)), none).ask_at, at(ms(1500)));
  for (TimePoint now = at(ms(1001)); now < at(ms(1500)); now += ms(1)) {
    ASSERT_THAT(dispatcher.step(now, none).hangs, IsEmpty());
  }
  EXPECT_THAT(dispatcher.step(at(ms(1500)), none).hangs, SizeIs(1)) << "a run that does hang is found";
}

}  // namespace
}  // namespace ctn::dispatch
