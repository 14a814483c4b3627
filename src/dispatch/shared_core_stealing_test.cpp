// Which subchain may go on in whose slot, in virtual time.
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

TEST(Stealing, ALateRunGoesOnInTheSlotOfALowerRank) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}), costs({{5, 4}, {3}}));
  core.run_until(at(ms(20)));
  EXPECT_EQ(core.timeline(), "0:5 1:3 .:2 0:4 1:3 .:1.75 0:1.25");
  ASSERT_THAT(core.steals, SizeIs(1));
  EXPECT_EQ(core.steals[0].thief, SubchainId(0));
  EXPECT_EQ(core.steals[0].victim, SubchainId(1));
  EXPECT_EQ(core.steals[0].begin, at(ms(4)));
  EXPECT_EQ(core.steals[0].end, at(ms(5)));
  ASSERT_GE(core.slots.size(), 2U);
  EXPECT_EQ(core.slots[1].planned, at(ms(4)));
  EXPECT_EQ(core.slots[1].begin, at(ms(5)));
}

TEST(Stealing, TheOtherGetsWhatIsLeftOfItsSlot) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}, 0.0), costs({{5, 4}, {4}}));
  core.run_until(at(ms(13)));
  EXPECT_EQ(core.timeline(), "0:5 1:3 0:4 1:1") << "its last millisecond comes a frame later";
}

TEST(Stealing, NeverFromAHigherRank) {
  auto schedule = elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}, 0.0);
  std::swap(schedule.slots[0].rank, schedule.slots[1].rank);
  auto core = VirtualCore::with_all(schedule, costs({{5, 4}, {4}}));
  core.run_until(at(ms(9)));
  EXPECT_EQ(core.timeline(), "0:4 1:4 0:1");
  EXPECT_THAT(core.steals, IsEmpty());
}

TEST(Stealing, NotByWhoMayNot) {
  const auto schedule = without_stealing(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}, 0.0));
  auto core = VirtualCore::with_all(schedule, costs({{5, 4}, {4}}));
  core.run_until(at(ms(9)));
  EXPECT_EQ(core.timeline(), "0:4 1:4 0:1");
}

TEST(Stealing, OnlyOnceTheOutputIsDue) {
  const auto schedule = elastic({every(2, 0, ms(4)), every(1, 1, ms(4))}, 0.0);
  auto core = VirtualCore::with_all(schedule, costs({{9, 4}, {4, 3}}));
  core.run_until(at(ms(16)));
  EXPECT_EQ(core.timeline(), "0:4 1:4 0:5 1:3") << "in the second of its two slots";
}

TEST(Stealing, GoesOnFromSlotToSlot) {
  const auto schedule = elastic({every(1, 0, ms(2)), every(1, 1, ms(2)), every(1, 2, ms(2))}, 0.0);
  auto core = VirtualCore::with_all(schedule, costs({{5, 1}, {1}, {1}}));
  core.run_until(at(ms(9)));
  EXPECT_EQ(core.timeline(), "0:5 2:1 0:1 1:1 2:1");
  ASSERT_THAT(core.steals, SizeIs(2));
  EXPECT_EQ(core.steals[0].end, at(ms(4)));
  EXPECT_EQ(core.steals[1].victim, SubchainId(2));
  EXPECT_EQ(core.triggers[SubchainId(1)].front().due, at(ms(2))) << "nothing was left; it waited for its next slot";
  EXPECT_EQ(core.triggers[SubchainId(1)].front().sent, at(ms(7)));
}

TEST(Stealing, EndsAtTheFirstHigherRank) {
  auto schedule = elastic({every(1, 1, ms(2)), every(1, 2, ms(2)), every(1, 0, ms(2)), every(1, 3, ms(2))}, 0.0);
  auto core = VirtualCore::with_all(schedule, costs({{2}, {5, 1}, {2}, {2}}));
  core.run_until(at(ms(9)));
  EXPECT_EQ(core.timeline(), "1:4 0:2 3:2 1:1") << "3 is beyond 0";
}

TEST(Stealing, PassesOverTheSlackIntoTheNextFrameOfLowerRanks) {
  const auto schedule = elastic({every(1, 1, ms(4)), every(1, 0, ms(4))});
  auto core = VirtualCore::with_all(schedule, costs({{5, 4}, {4}}));
  core.run_until(at(ms(14)));
  EXPECT_EQ(core.timeline(), "1:4 0:4 .:2 0:1 1:3");
}

TEST(Stealing, NotOverTheNextFramesStartOfAHigherRank) {
  const auto schedule = elastic({every(1, 0, ms(4)), every(1, 1, ms(4))});
  auto core = VirtualCore::with_all(schedule, costs({{4}, {5, 4}}));
  core.run_until(at(ms(15)));
  EXPECT_EQ(core.timeline(), "0:4 1:4 .:2 0:4 1:1");
  EXPECT_THAT(core.steals, IsEmpty());
}

TEST(Stealing, PassesOverSlotsThatNobodyUses) {
  const auto schedule = elastic({every(1, 0, ms(2)), every(2, 1, ms(2), 1), every(1, 2, ms(2))}, 0.0);
  auto core = VirtualCore::with_all(schedule, costs({{3, 1}, {1}, {1}}));
  core.run_until(at(ms(4)));
  EXPECT_EQ(core.timeline(), "0:3 2:1");
  ASSERT_THAT(core.steals, SizeIs(1));
  EXPECT_EQ(core.steals[0].victim, SubchainId(2));
}

TEST(Stealing, InFixedFramesTheThiefsEndGivesTheRestBack) {
  auto core = VirtualCore::with_all(fixed({every(1, 0, ms(4)), every(1, 1, ms(4))}, ms(10)), costs({{5, 4}, {3}}));
  core.run_until(at(ms(20)));
  EXPECT_EQ(core.timeline(), "0:5 1:3 .:2 0:4 1:3 .:3");
  EXPECT_EQ(core.triggers[SubchainId(1)].front().due, at(ms(4)));
  EXPECT_EQ(core.triggers[SubchainId(1)].front().sent, at(ms(5)));
}

TEST(Stealing, InFixedFramesUnusedSlotsAreTheBackgrounds) {
  const auto schedule = fixed({every(1, 0, ms(2)), every(2, 1, ms(2), 1), every(1, 2, ms(2))}, ms(10));
  auto core = VirtualCore::with_all(schedule, costs({{5, 1}, {1}, {1}}));
  core.run_until(at(ms(10)));
  EXPECT_EQ(core.timeline(), "0:2 b0:2 0:1 2:1 .:4");
}

TEST(Stealing, AHangingRunGivesBackWhatItStole) {
  auto schedule = elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}, 0.0);
  schedule.slots[0].hang_after = ms(5);
  auto core = VirtualCore::with_all(schedule, costs({{1e6}, {3}}));
  core.run_until(at(ms(22)));
  EXPECT_EQ(core.timeline(), "0:5 1:3 0:4 1:3 0:4 1:3");
  ASSERT_THAT(core.steals, SizeIs(1));
  EXPECT_EQ(core.steals[0].end, at(ms(5)));
}

TEST(Stealing, WhoseSlotIsStolenToItsLastInstantIsNotTriggeredInIt) {
  auto core = VirtualCore::with_all(elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}, 0.0), costs({{8, 4}, {4}}));
  core.run_until(at(ms(16)));
  EXPECT_EQ(core.timeline(), "0:12 1:4");
  EXPECT_EQ(core.triggers[SubchainId(1)].front().sent, at(ms(12)));
  EXPECT_EQ(core.slots[1].begin, core.slots[1].end);
}

TEST(Stealing, WhoeverALateDispatcherCostItsSlotMayGoOnInALowerRanks) {
  const auto schedule = fixed({every(1, 0, ms(2)), every(1, 1, ms(2)), every(1, 2, ms(2))}, ms(10));
  SharedCoreDispatcher dispatcher(at(ms(0)), schedule);
  for (const std::size_t index : {0U, 1U, 2U}) dispatcher.adopt(SubchainId(index), {});
  const auto& late = dispatcher.step(at(ms(5)), {});
  EXPECT_THAT(late.triggers, SizeIs(2)) << "0 and 1, whose slots are over; 2 gets what 0 leaves of its own";
  const std::vector<std::uint64_t> first_is_done{1, 0, 0};
  const auto& over = dispatcher.step(at(ms(5.5)), first_is_done);
  EXPECT_THAT(over.steals, ElementsAre(Steal{0, SubchainId(0), SubchainId(2), at(ms(5)), at(ms(5.5))}));
}

TEST(Stealing, AVictimThatIsLateByItMayStealInTurn) {
  const auto schedule = elastic({every(1, 0, ms(2)), every(1, 1, ms(2)), every(1, 2, ms(2))}, 0.0);
  auto core = VirtualCore::with_all(schedule, costs({{3, 1}, {2}, {1}}));
  core.run_until(at(ms(6)));
  EXPECT_EQ(core.timeline(), "0:3 1:2 2:1");
  ASSERT_THAT(core.steals, SizeIs(2));
  EXPECT_EQ(core.steals[1].thief, SubchainId(1));
}

}  // namespace
}  // namespace ctn::dispatch
