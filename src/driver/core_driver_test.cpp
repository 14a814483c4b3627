#include "driver/core_driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "driver/testing/samples.h"

namespace ctn::driver {
namespace {

using dispatch::elastic;
using dispatch::fixed;
using os::CpuSet;
using os::Level;
using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr SubchainId kFirst{std::size_t{0}};
constexpr SubchainId kSecond{std::size_t{1}};

// Turns of 4 ms each.
dispatch::SharedCoreSchedule two_slots() { return elastic({every(1, 0, ms(4)), every(1, 1, ms(4))}, 0.0); }
dispatch::SharedCoreSchedule one_slot(int subchain) { return elastic({every(1, subchain, ms(4))}, 0.0); }

// Both take turns on core 0.
policy::Assignment both_share(Nanos hang_after = Nanos{0}) {
  dispatch::SharedCoreSchedule schedule = two_slots();
  for (dispatch::SharedCoreSlot& slot : schedule.slots) slot.hang_after = hang_after;
  return assignment({shares(0), shares(0)}, {schedule, {}});
}
// The first alone on core 0, the second on a CPU that it owns.
policy::Assignment second_owns_a_cpu(Nanos period, Nanos hang_after = Nanos{0}) {
  return assignment({shares(0), paced(period, CpuSet{1}, hang_after)}, {one_slot(0), {}});
}

FakeWorld::Cost second_takes(Nanos cost) {
  return [cost](SubchainId id, std::uint64_t) { return id == kSecond ? cost : ms(3); };
}

TEST(CoreDriver, MembersTakeTurns) {
  FakeWorld world(2, 2, each_takes(ms(3)));
  world.publish(both_share());
  world.run_until(at(ms(11)));
  EXPECT_THAT(world.sent(kFirst), ElementsAre(0, 6));
  EXPECT_THAT(world.sent(kSecond), ElementsAre(3, 9));
  EXPECT_EQ(world.of(kFirst).cpus, CpuSet{0});
  EXPECT_THAT(world.of(kFirst).levels, Each(Level::kBackground));
  EXPECT_THAT(world.of(kSecond).levels, Each(Level::kActive));
  EXPECT_THAT(world.slots, ElementsAre(dispatch::SlotUse{0, kFirst, at(ms(0)), at(ms(0)), at(ms(3))},
                                       dispatch::SlotUse{0, kSecond, at(ms(3)), at(ms(3)), at(ms(6))},
                                       dispatch::SlotUse{0, kFirst, at(ms(6)), at(ms(6)), at(ms(9))}));
}

TEST(CoreDriver, TellsOfItsOwnCore) {
  FakeWorld world(2, 2, each_takes(ms(3)));
  world.publish(assignment({shares(1), shares(1)}, {{}, two_slots()}));
  world.run_until(at(ms(4)));
  ASSERT_EQ(world.slots.size(), 1U);
  EXPECT_EQ(world.slots[0].core, 1);
}

TEST(CoreDriver, AStealIsToldOnceItIsOver) {
  FakeWorld world(2, 2,
                  [](SubchainId id, std::uint64_t number) { return id == kFirst && number == 1 ? ms(5) : ms(3); });
  world.publish(both_share());
  world.run_until(at(ms(4.5)));
  EXPECT_THAT(world.steals, IsEmpty());
  EXPECT_THAT(world.of(kFirst).levels, Each(Level::kActive)) << "in the other's slot";
  world.run_until(at(ms(20)));
  EXPECT_THAT(world.steals, ElementsAre(dispatch::Steal{0, kFirst, kSecond, at(ms(4)), at(ms(5))}));
}

TEST(CoreDriver, ARunThatEndsWhileItDecidesEndsItsSlot) {
  FakeWorld world(2, 2, [](SubchainId id, std::uint64_t) { return id == kFirst ? Nanos{0} : ms(3); });
  world.publish(both_share());
  world.run_until(at(ms(4)));
  EXPECT_THAT(world.sent(kFirst), ElementsAre(0, 3));
  EXPECT_THAT(world.sent(kSecond), ElementsAre(0, 3)) << "at once, not after a slice";
}

TEST(CoreDriver, WhoeverComesFromItsOwnCoreIsAbsentUntilItIsLetGo) {
  FakeWorld world(2, 2, each_takes(ms(3)));
  world.publish(second_owns_a_cpu(ms(10)));
  world.run_until(at(ms(13)));
  ASSERT_EQ(world.of(kSecond).triggers.size(), 2U);
  world.publish(both_share());
  world.run_until(at(ms(22)));
  EXPECT_EQ(world.of(kSecond).holder, 2U);
  EXPECT_EQ(world.of(kSecond).cpus, CpuSet{0});
  EXPECT_THAT(world.sent(kSecond), ElementsAre(0, 10, 18)) << "counted on, in its slot after the first's";
}

TEST(CoreDriver, WhoeverLeavesDoesSoAtTheEndOfTheFrame) {
  FakeWorld world(2, 2, each_takes(ms(3)));
  world.publish(both_share());
  world.run_until(at(ms(7)));
  world.publish(second_owns_a_cpu(ms(20)));
  world.run_until(at(ms(11)));
  EXPECT_EQ(world.of(kSecond).holder, 2U) << "its slot of this frame is still to come";
  world.run_until(at(ms(13)));
  EXPECT_EQ(world.of(kSecond).holder, kSecond.index());
  EXPECT_THAT(world.of(kSecond).levels, Each(Level::kActive));
  EXPECT_EQ(world.of(kSecond).cpus, CpuSet{1});
  world.run_until(at(ms(30)));
  EXPECT_THAT(world.sent(kSecond), ElementsAre(3, 9, 29)) << "a period of the new pacing after the last one";
}

TEST(CoreDriver, FromCoreToCoreARunGoesOn) {
  FakeWorld world(2, 2, second_takes(ms(11)));
  world.publish(both_share());
  world.run_until(at(ms(5)));
  world.publish(assignment({shares(0), shares(1)}, {one_slot(0), one_slot(1)}));
  world.run_until(at(ms(30)));
  EXPECT_EQ(world.of(kSecond).holder, 3U);
  EXPECT_EQ(world.of(kSecond).cpus, CpuSet{1});
  EXPECT_THAT(world.sent(kSecond), ElementsAre(3, 14, 25)) << "the run of 3 ms ends on the other core";
}

TEST(CoreDriver, WithoutOneOfItsMembersTheOthersGoOn) {
  FakeWorld world(2, 2, each_takes(ms(3)));
  world.publish(both_share());
  world.run_until(at(ms(7)));
  policy::Assignment without = both_share();
  policy::remove_absent(without, {true, false});
  world.publish(without);
  world.run_until(at(ms(20)));
  EXPECT_FALSE(world.of(kSecond).holder);
  EXPECT_THAT(world.of(kSecond).levels, Each(Level::kOrdinary));
  EXPECT_THAT(world.sent(kFirst), ElementsAre(0, 6, 12, 15, 18));
  world.publish(both_share());
  world.run_until(at(ms(31)));
  EXPECT_THAT(world.sent(kFirst), ElementsAre(0, 6, 12, 15, 18, 21, 27));
  EXPECT_THAT(world.sent(kSecond), ElementsAre(3, 9, 24, 30));
}

TEST(CoreDriver, ThreadsThatJoinGetTheLevelAndTheCpuOfNow) {
  FakeWorld world(2, 2, each_takes(ms(3)));
  world.publish(both_share());
  world.run_until(at(ms(7)));
  world.join(kFirst);
  world.join(kSecond);
  // It leaves at the end of the frame only.
  world.publish(second_owns_a_cpu(ms(20)));
  world.run_until(at(ms(8)));
  EXPECT_THAT(world.of(kFirst).levels, Each(Level::kActive));
  EXPECT_THAT(world.of(kSecond).levels, Each(Level::kBackground));
  EXPECT_EQ(world.of(kSecond).cpus, CpuSet{0});
}

TEST(CoreDriver, AHungRunIsSuspendedOutsideItsSlots) {
  FakeWorld world(2, 2, second_takes(kNeverEnds));
  world.publish(both_share(ms(30)));
  world.run_until(at(ms(40)));
  EXPECT_THAT(world.hangs, ElementsAre(FakeWorld::Hang{kSecond, true, at(ms(33))}));
  bool raised_beside_its_slot = false;
  world.after_step = [&] {
    const bool first_is_active = world.of(kFirst).levels.front() == Level::kActive;
    raised_beside_its_slot |= first_is_active && world.of(kSecond).levels.front() != Level::kOrdinary;
  };
  world.run_until(at(ms(80)));
  EXPECT_FALSE(raised_beside_its_slot);
  world.end_hung_run(kSecond);
  world.run_until(at(ms(90)));
  ASSERT_EQ(world.hangs.size(), 2U);
  EXPECT_FALSE(world.hangs[1].began);
}

TEST(CoreDriver, AHungRunStaysSuspendedWhereItGoes) {
  FakeWorld world(2, 2, second_takes(kNeverEnds));
  world.publish(both_share(ms(30)));
  world.run_until(at(ms(40)));
  world.publish(second_owns_a_cpu(ms(20), ms(30)));
  world.run_until(at(ms(100)));
  EXPECT_EQ(world.of(kSecond).holder, kSecond.index());
  EXPECT_THAT(world.of(kSecond).levels, Each(Level::kOrdinary));
}

TEST(CoreDriver, FixedFramesKeepToTheirGrid) {
  FakeWorld world(2, 1, each_takes(ms(1)));
  world.publish(assignment({shares(0), shares(0)}, {fixed({every(1, 0, ms(2)), every(2, 1, ms(2))}, ms(10))}));
  world.run_until(at(ms(35)));
  EXPECT_THAT(world.sent(kFirst), ElementsAre(0, 10, 20, 30));
  EXPECT_THAT(world.sent(kSecond), ElementsAre(2, 22));
}

}  // namespace
}  // namespace ctn::driver
