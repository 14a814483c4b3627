// Schedules that change while subchains run, come and go, in virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "dispatch/shared_core_dispatcher.h"
#include "dispatch/testing/shared_core_samples.h"
#include "dispatch/testing/virtual_core.h"

namespace ctn::dispatch {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

void hand_over(VirtualCore& from, VirtualCore& to) {
  for (const auto& [subchain, what] : from.handed_over) to.adopt(subchain, what.first, what.second);
  from.handed_over.clear();
}

TEST(Swap, TakesEffectAtTheEndOfTheFrame) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}), costs({{4}, {4}}));
  core.run_until(at(ms(1)));
  core.change_schedule(elastic({every(1, 1, ms(4)), every(1, 0, ms(4))}));
  core.run_until(at(ms(20)));
  EXPECT_EQ(core.timeline(), "0:4 1:4 .:2 1:4 0:4 .:2");
  ASSERT_THAT(core.swaps, SizeIs(1));
  EXPECT_EQ(core.swaps[0].at, at(ms(10)));
}

TEST(Swap, OfSeveralTheLastCounts) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(4))}, 0.0), costs({{4}}));
  core.run_until(at(ms(1)));
  core.change_schedule(elastic({every(1, 0, ms(1))}, 0.0, ms(50)));
  core.change_schedule(elastic({every(1, 0, ms(4))}, 0.0, ms(8)));
  core.run_until(at(ms(13)));
  EXPECT_THAT(core.frames, ElementsAre(at(ms(0)), at(ms(4)), at(ms(12))));
}

TEST(Swap, ARunUnderWayGoesOnUnderTheNewSlices) {
  const auto before = without_stealing(elastic({every(1, 0, ms(2)), every(1, 1, ms(4))}, 0.0));
  auto core = VirtualCore::with_all(before, costs({{5, 1}, {4}}));
  core.run_until(at(ms(1)));
  core.change_schedule(without_stealing(elastic({every(1, 0, ms(3)), every(1, 1, ms(4))}, 0.0)));
  core.run_until(at(ms(14)));
  EXPECT_EQ(core.timeline(), "0:2 1:4 0:3 1:4 0:1");
}

TEST(Swap, TheRhythmGoesOnUnderANewN) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(1)), every(4, 1, ms(1))}, 0.0), costs({{1}, {1}}));
  core.run_until(at(ms(3.5)));  // in frame 2; 1 was due in frame 0
  core.change_schedule(elastic({every(1, 0, ms(1)), every(3, 1, ms(1), 1)}, 0.0));
  core.run_until(at(ms(12.5)));
  std::vector<TimePoint> sent;
  for (const auto& trigger : core.triggers[SubchainId(1)]) sent.push_back(trigger.sent);
  EXPECT_THAT(sent, ElementsAre(at(ms(1)), at(ms(5)), at(ms(9)))) << "frames 0, 3, 6, whatever the new phase";
}

TEST(Swap, AShorterNThatHasPassedIsDueAtOnce) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(1)), every(8, 1, ms(1))}, 0.0), costs({{1}, {1}}));
  core.run_until(at(ms(5.5)));
  core.change_schedule(elastic({every(1, 0, ms(1)), every(2, 1, ms(1))}, 0.0));
  core.run_until(at(ms(7.5)));
  EXPECT_THAT(core.triggers[SubchainId(1)], SizeIs(2));
}

TEST(Swap, WhoLeavesIsHandedOverWithItsRunAndAtTheOrdinaryLevel) {
  const auto before = elastic({every(1, 0, ms(2)), every(2, 1, ms(4))}, 0.0);
  auto core = VirtualCore::with_all(before, costs({{2}, {8}}));
  core.run_until(at(ms(1)));
  core.change_schedule(elastic({every(1, 0, ms(2))}, 0.0));
  core.run_until(at(ms(20)));
  ASSERT_THAT(core.handed_over, SizeIs(1));
  const auto& [subchain, what] = core.handed_over[0];
  EXPECT_EQ(subchain, SubchainId(1));
  EXPECT_EQ(what.first.sent, 1U);
  EXPECT_EQ(what.first.completed, 0U);
  EXPECT_EQ(what.second.level, MemberLevel::kOrdinary);
  EXPECT_EQ(core.timeline(), "0:2 1:4 0:14");
}

TEST(Swap, ARunMovesToAnotherCoreAndIsNotTriggeredTwice) {
  const auto cost = costs({{2}, {8, 1}, {2}});
  auto first = VirtualCore::with_all(elastic({every(1, 0, ms(2)), every(2, 1, ms(4))}, 0.0), cost);
  auto second = VirtualCore::with_all(elastic({every(1, 2, ms(2))}, 0.0), cost);
  first.run_until(at(ms(1)));
  second.run_until(at(ms(1)));
  first.change_schedule(elastic({every(1, 0, ms(2))}, 0.0));
  second.change_schedule(without_stealing(elastic({every(1, 2, ms(2)), every(2, 1, ms(3))}, 0.0)));
  first.run_until(at(ms(6)));
  second.run_until(at(ms(6)));
  ASSERT_THAT(second.swaps, SizeIs(1));
  EXPECT_EQ(second.cpu_time(SubchainId(1), at(ms(0)), at(ms(6))), ms(0)) << "absent until it comes";
  hand_over(first, second);
  second.run_until(at(ms(30)));
  ASSERT_GE(second.completions[SubchainId(1)].size(), 2U);
  EXPECT_EQ(second.completions[SubchainId(1)][0], at(ms(6 + 2 + 3 + 2 + 1)));
  EXPECT_EQ(second.triggers[SubchainId(1)].front().number, 2U);
}

TEST(Swap, AnAdoptionMayComeBeforeItsSchedule) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(2))}, 0.0), costs({{2}, {2}}));
  core.run_until(at(ms(1)));
  core.adopt(SubchainId(1), {}, {});
  core.run_until(at(ms(5)));
  EXPECT_THAT(core.triggers[SubchainId(1)], IsEmpty());
  core.change_schedule(elastic({every(1, 0, ms(2)), every(1, 1, ms(2))}, 0.0));
  core.run_until(at(ms(10)));
  EXPECT_EQ(core.timeline(), "0:8 1:2");
}

TEST(Swap, WhoWasAdoptedForAScheduleThatIsNoMoreIsHandedOn) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(2))}, 0.0), costs({{2}, {2}}));
  core.run_until(at(ms(1)));
  core.adopt(SubchainId(1), {.sent = 5, .completed = 4}, {.sent = 5, .completed = 4, .left = ms(1)});
  core.change_schedule(elastic({every(1, 0, ms(2))}, 0.0));
  core.run_until(at(ms(5)));
  ASSERT_THAT(core.handed_over, SizeIs(1));
  EXPECT_EQ(core.handed_over[0].second.first.sent, 5U);
}

TEST(Swap, AllMayLeaveAndOthersCome) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(2))}, 0.0), costs({{2}, {2}}));
  core.run_until(at(ms(1)));
  core.change_schedule({});
  core.run_until(at(ms(10)));
  EXPECT_THAT(core.handed_over, SizeIs(1));
  core.change_schedule(fixed({every(1, 1, ms(2))}, ms(5)));
  core.adopt(SubchainId(1), {}, {});
  core.run_until(at(ms(20)));
  EXPECT_EQ(core.timeline(), "0:2 .:8 1:2 .:3 1:2 .:3");
}

TEST(Swap, AThiefThatStaysGoesOnStealingAndOneThatLeavesDoesNot) {
  const auto before = elastic({every(1, 1, ms(4)), every(1, 0, ms(4))}, 0.0);
  for (const bool stays : {true, false}) {
    auto core = VirtualCore::with_all(before, costs({{6, 1}, {4}}));
    core.run_until(at(ms(7)));
    std::vector<SharedCoreSlot> slots{every(1, 1, ms(3))};
    if (stays) slots.push_back(every(1, 0, ms(5)));
    core.change_schedule(elastic(slots, 0.0));
    core.run_until(at(ms(11)));
    EXPECT_EQ(core.timeline(), stays ? "1:4 0:6 1:1" : "1:4 0:4 1:3");
  }
}

TEST(Swap, AHangGoesAlongAndIsNotReportedTwice) {
  auto schedule = elastic({every(1, 0, ms(2)), every(1, 1, ms(2))}, 0.0);
  for (SharedCoreSlot& slot : schedule.slots) slot.hang_after = ms(10);
  const auto cost = costs({{30, 1}, {2}, {2}});
  auto first = VirtualCore::with_all(schedule, cost);
  first.run_until(at(ms(20)));
  ASSERT_THAT(first.hangs, SizeIs(1));
  first.change_schedule(elastic({every(1, 1, ms(2))}, 0.0));
  first.run_until(at(ms(30)));
  VirtualCore second(elastic({every(1, 2, ms(2)), schedule.slots[0]}, 0.0), cost);
  second.run_until(at(ms(30)));
  hand_over(first, second);
  second.run_until(at(ms(200)));
  ASSERT_THAT(second.hangs, SizeIs(1));
  EXPECT_FALSE(second.hangs[0].second.began);
  EXPECT_GT(second.completions[SubchainId(0)].size(), 10U);
}

TEST(Swap, CreditBeyondTheNewShareIsLost) {
  auto core = VirtualCore::with_all(elastic({queue(5.0, 0, ms(1))}, 0.0, ms(10)), costs({{1}}));
  core.run_until(at(ms(0.5)));
  core.change_schedule(elastic({queue(0.25, 0, ms(1))}, 0.0, ms(10)));
  core.run_until(at(ms(31)));
  EXPECT_THAT(core.triggers[SubchainId(0)], SizeIs(2));
}

}  // namespace
}  // namespace ctn::dispatch
