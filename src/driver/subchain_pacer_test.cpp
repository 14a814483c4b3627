#include "driver/subchain_pacer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "driver/testing/samples.h"

namespace ctn::driver {
namespace {

using os::CpuSet;
using os::Level;
using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr SubchainId kOnly{std::size_t{0}};

// Every 10 ms on a CPU of its own.
policy::Assignment every_10ms(int cpu = 0, Nanos hang_after = Nanos{0}) {
  return assignment({paced(ms(10), CpuSet{cpu}, hang_after)});
}
policy::Assignment absent() {
  policy::Assignment made = every_10ms();
  policy::remove_absent(made, {false});
  return made;
}

FakeWorld::Cost hangs_in_run(std::uint64_t hung) {
  return [hung](SubchainId, std::uint64_t number) { return number == hung ? kNeverEnds : ms(1); };
}

TEST(SubchainPacer, TriggersEveryPeriodAtTheLevelAndOnTheCpusOfItsPlace) {
  FakeWorld world(1, 0, each_takes(ms(4)), 2);
  policy::SubchainPlace place = paced(ms(10), CpuSet{1, 2});
  place.levels = {Level::kActive, Level::kBackground};
  world.publish(assignment({place}));
  world.run_until(at(ms(35)));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(0, 10, 20, 30));
  EXPECT_THAT(world.of(kOnly).levels, ElementsAre(Level::kActive, Level::kBackground));
  EXPECT_EQ(world.of(kOnly).cpus, (CpuSet{1, 2}));
  EXPECT_EQ(world.of(kOnly).level_changes, 1U);
  EXPECT_EQ(world.of(kOnly).moves, 1U);
}

TEST(SubchainPacer, TheEndOfALongRunIsWhatTriggersTheNext) {
  FakeWorld world(1, 0, each_takes(ms(13)));
  world.publish(every_10ms());
  world.run_until(at(ms(40)));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(0, 13, 26, 39));
}

TEST(SubchainPacer, ARunThatEndsWhileItDecidesIsNotMissed) {
  FakeWorld world(1, 0, each_takes(Nanos{0}));
  policy::SubchainPlace place = paced(ms(10), CpuSet{0});
  place.pacing.after_completion = ms(3);
  place.pacing.shortest = ms(1);
  world.publish(assignment({place}));
  world.run_until(at(ms(10)));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(0, 3, 6, 9)) << "by its own output, not by its period";
}

TEST(SubchainPacer, ANewPlaceChangesNothingButWhatIsNewInIt) {
  FakeWorld world(1, 0, each_takes(ms(1)));
  world.publish(every_10ms());
  world.run_until(at(ms(15)));
  world.publish(assignment({paced(ms(4), CpuSet{0})}));
  world.run_until(at(ms(19)));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(0, 10, 15, 19)) << "now, as one new period has passed since";
  EXPECT_EQ(world.of(kOnly).level_changes, 1U);
  EXPECT_EQ(world.of(kOnly).moves, 1U);
  world.publish(assignment({paced(ms(4), CpuSet{1})}));
  world.run_until(at(ms(20)));
  EXPECT_EQ(world.of(kOnly).cpus, CpuSet{1});
  EXPECT_EQ(world.of(kOnly).level_changes, 1U);
}

TEST(SubchainPacer, WhoeverIsNotPresentIsNobodysUntilItComesBack) {
  FakeWorld world(1, 0, each_takes(ms(1)));
  world.publish(every_10ms());
  world.run_until(at(ms(12)));
  world.publish(absent());
  world.run_until(at(ms(50)));
  EXPECT_FALSE(world.of(kOnly).holder);
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kOrdinary));
  world.publish(every_10ms());
  world.run_until(at(ms(65)));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(0, 10, 50, 60));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kActive));
}

TEST(SubchainPacer, WhoeverIsBackSoonKeepsItsDistanceToTheTriggerBefore) {
  FakeWorld world(1, 0, each_takes(ms(1)));
  world.publish(every_10ms());
  world.run_until(at(ms(12)));
  world.publish(absent());
  world.run_until(at(ms(13)));
  world.publish(every_10ms());
  world.run_until(at(ms(25)));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(0, 10, 20));
}

TEST(SubchainPacer, AHungRunIsSuspendedUntilItEnds) {
  FakeWorld world(1, 0, hangs_in_run(2));
  world.publish(every_10ms(0, ms(30)));
  world.run_until(at(ms(39)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kActive));
  EXPECT_THAT(world.hangs, IsEmpty());
  world.run_until(at(ms(60)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kOrdinary));
  world.end_hung_run(kOnly);
  world.run_until(at(ms(65)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kActive));
  EXPECT_THAT(world.hangs,
              ElementsAre(FakeWorld::Hang{kOnly, true, at(ms(40))}, FakeWorld::Hang{kOnly, false, at(ms(60))}));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(0, 10, 60));
}

TEST(SubchainPacer, ANewPlaceDoesNotRaiseAHungRun) {
  FakeWorld world(1, 0, hangs_in_run(1));
  world.publish(every_10ms(0, ms(30)));
  world.run_until(at(ms(40)));
  policy::SubchainPlace place = paced(ms(10), CpuSet{1}, ms(30));
  place.level = Level::kBackground;
  world.publish(assignment({place}));
  world.run_until(at(ms(50)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kOrdinary));
  EXPECT_EQ(world.of(kOnly).cpus, CpuSet{1});
  world.end_hung_run(kOnly);
  world.run_until(at(ms(51)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kBackground));
}

TEST(SubchainPacer, ThreadsThatJoinGetWhatTheOthersHave) {
  FakeWorld world(1, 0, each_takes(ms(1)));
  world.publish(every_10ms(3));
  world.run_until(at(ms(15)));
  world.join(kOnly);
  world.run_until(at(ms(20)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kActive));
  EXPECT_EQ(world.of(kOnly).cpus, CpuSet{3});
}

TEST(SubchainPacer, ThreadsThatJoinAHungRunAreNotRaised) {
  FakeWorld world(1, 0, each_takes(kNeverEnds));
  world.publish(every_10ms(3, ms(30)));
  world.run_until(at(ms(35)));
  world.join(kOnly);
  world.publish(every_10ms(3, ms(30)));
  world.run_until(at(ms(36)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kOrdinary));
  EXPECT_EQ(world.of(kOnly).cpus, CpuSet{3});
}

TEST(SubchainPacer, WithNothingToDoItSleeps) {
  FakeWorld world(1, 1, each_takes(ms(1)));
  world.publish(assignment({shares(0)}, {dispatch::elastic({every(1, 0, ms(4))}, 0.0, ms(5))}));
  world.run_until(at(ms(1)));
  const std::uint64_t before = world.steps;
  policy::SubchainPlace place = paced(ms(10), CpuSet{0});
  place.present = false;
  world.publish(assignment({place}, {{}}));
  world.run_until(at(ms(5)) + Nanos{1});
  const std::uint64_t settled = world.steps;
  EXPECT_GT(settled, before);
  world.run_until(at(ms(1000)));
  EXPECT_EQ(world.steps, settled);
}

}  // namespace
}  // namespace ctn::driver
