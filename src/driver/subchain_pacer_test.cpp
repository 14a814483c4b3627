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

// A run hangs at `before`, and ends then. By `after` its place's fixed level 3 is restored.
void expect_suspended_until_it_ends(FakeWorld& world, TimePoint before, TimePoint after) {
  world.run_until(before);
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kOrdinary));
  world.end_hung_run(kOnly);
  world.run_until(after);
  EXPECT_THAT(world.of(kOnly).levels, Each(os::fixed_level(3)));
  EXPECT_EQ(world.hangs.size(), 2U);
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

TEST(SubchainPacer, WhoIsNotPresentIsLeftAloneUntilItComesBack) {
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

// From a core that it shares, and where it hung already.
TEST(SubchainPacer, ARunThatHungElsewhereIsRestoredWhenItEnds) {
  FakeWorld world(1, 1, hangs_in_run(1));
  dispatch::SharedCoreSchedule frames = dispatch::elastic({every(1, 0, ms(4))}, 0.0, ms(5));
  frames.slots.front().hang_after = ms(20);
  world.publish(assignment({shares(0)}, {frames}));
  world.run_until(at(ms(30)));
  ASSERT_THAT(world.hangs, ElementsAre(FakeWorld::Hang{kOnly, true, at(ms(20))}));
  world.publish(assignment({phased(3, ms(20), ms(0), ms(4))}, {{}}));
  expect_suspended_until_it_ends(world, at(ms(45)), at(ms(70)));
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

// --- Fixed priorities ---

constexpr SubchainId kLeader{std::size_t{0}};
constexpr SubchainId kFollower{std::size_t{1}};

TEST(SubchainPacer, PhasesOfSubchainsStayWhatTheyAreThroughPlans) {
  FakeWorld world(2, 0, each_takes(ms(2)));
  world.publish(assignment({phased(1, ms(10), ms(0)), phased(0, ms(10), ms(4))}));
  world.run_until(at(ms(25)));
  world.publish(assignment({phased(0, ms(20), ms(0)), phased(1, ms(20), ms(4))}));
  world.run_until(at(ms(65)));
  EXPECT_THAT(world.sent(kLeader), ElementsAre(0, 10, 20, 40, 60));
  EXPECT_THAT(world.sent(kFollower), ElementsAre(4, 14, 24, 44, 64));
  EXPECT_THAT(world.of(kFollower).levels, Each(os::fixed_level(1)));
}

TEST(SubchainPacer, WhoTookTurnsBeforeKeepsToItsPhase) {
  FakeWorld world(1, 1, each_takes(ms(2)));
  world.publish(assignment({shares(0)}, {dispatch::elastic({every(1, 0, ms(4))}, 0.0, ms(5))}));
  world.run_until(at(ms(8)));
  world.publish(assignment({phased(0, ms(10), ms(3))}, {{}}));
  world.run_until(at(ms(45)));
  std::vector<double> sent = world.sent(kOnly);
  ASSERT_GT(sent.size(), 3U);
  sent.erase(sent.begin(), sent.end() - 3);
  EXPECT_THAT(sent, ElementsAre(23, 33, 43));
}

TEST(SubchainPacer, AFollowerIsTriggeredByOutputsAndNotByRunsThatGiveNone) {
  FakeWorld world(2, 0, each_takes(ms(3)));
  world.gives_output = [](SubchainId id, std::uint64_t number) { return id == kLeader && number != 2; };
  world.publish(assignment({phased(1, ms(10), ms(0)), follows(0, kLeader, 1, ms(10))}));
  world.run_until(at(ms(45)));
  EXPECT_THAT(world.sent(kLeader), ElementsAre(0, 10, 20, 30, 40));
  EXPECT_THAT(world.sent(kFollower), ElementsAre(3, 23, 33, 43));
  for (const record::Trigger& trigger : world.of(kFollower).triggers) EXPECT_EQ(trigger.due, trigger.sent);
}

// As it comes, whatever the clock of its sender does.
TEST(SubchainPacer, AReaderIsTriggeredByWhatArrives) {
  FakeWorld world(1, 1, each_takes(ms(1)));
  const plan::Leader sensor = NodeId(std::size_t{7});
  world.publish(assignment({follows(0, sensor, 2, ms(10))}, {{}}));
  for (const double arrival : {0.5, 5.0, 10.1, 15.1, 20.2, 25.3, 30.3, 35.4}) {
    world.run_until(at(to_nanos(Millis{arrival})));
    world.give_output(sensor);
  }
  world.run_until(at(ms(40)));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(5, 15.1, 25.3, 35.4));
  world.publish(assignment({phased(0, ms(10), ms(7))}, {{}}));
  world.run_until(at(ms(41)));
  EXPECT_THAT(world.unscheduled.subscribers, IsEmpty());
}

// Each look takes the CPU from those below.
TEST(SubchainPacer, AReaderOfEachSeventhOutputLooksNoSooner) {
  FakeWorld world(1, 0, each_takes(ms(0)));
  const plan::Leader sensor = NodeId(std::size_t{7});
  world.publish(assignment({follows(0, sensor, 7, ms(100))}));
  world.run_until(at(ms(1)));
  const std::uint64_t before = world.steps;
  for (int output = 1; output <= 21; ++output) {
    world.run_until(at(ms(10) * output));
    world.give_output(sensor);
  }
  world.run_until(at(ms(215)));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(70, 140, 210));
  EXPECT_EQ(world.steps - before, 3U);
}

TEST(SubchainPacer, KeepsAPhaseToAClockOfOthersOnceItIsKnown) {
  FakeWorld world(1, 0, each_takes(ms(1)));
  policy::SubchainPlace place = phased(0, ms(10), ms(4));
  place.pacing.clock = NodeId(std::size_t{2});
  world.publish(assignment({place}));
  world.run_until(at(ms(20)));
  world.clock = Ticks{at(ms(2)), ms(10)};
  world.run_until(at(ms(60)));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(4, 14, 24, 36, 46, 56));
}

TEST(SubchainPacer, AFollowerThatIsBusyIsTriggeredOnceWhenItHasEnded) {
  FakeWorld world(2, 0, [](SubchainId id, std::uint64_t) { return id == kLeader ? ms(1) : ms(25); });
  world.publish(assignment({phased(1, ms(10), ms(0)), follows(0, kLeader, 1, ms(10))}));
  world.run_until(at(ms(60)));
  EXPECT_THAT(world.sent(kFollower), ElementsAre(1, 26, 51));
  EXPECT_EQ(world.of(kFollower).triggers[1].due, at(ms(11))) << "when the first of these outputs came";
}

TEST(SubchainPacer, AFollowerOfWhoeverIsNotThereGoesOnAtItsPeriod) {
  FakeWorld world(2, 0, each_takes(ms(1)));
  policy::SubchainPlace leader = phased(1, ms(10), ms(0));
  const policy::SubchainPlace follower = follows(0, kLeader, 1, ms(10));
  world.publish(assignment({leader, follower}));
  world.run_until(at(ms(15)));
  leader.present = false;
  world.publish(assignment({leader, follower}));
  world.run_until(at(ms(1035)));
  EXPECT_THAT(world.sent(kFollower), ElementsAre(1, 11, 1011, 1021, 1031)) << "after a second";
  leader.present = true;
  world.publish(assignment({leader, follower}));
  world.run_until(at(ms(1065)));
  EXPECT_THAT(world.sent(kFollower), ElementsAre(1, 11, 1011, 1021, 1031, 1041, 1051, 1061)) << "and is back at once";
}

// Else a leader that itself needs what the follower gives, as a mapper needs a robot that moves, would give nothing
// for ten periods either.
TEST(SubchainPacer, AFollowerOfALeaderThatRunsAndGivesNothingGoesOnAtItsPeriod) {
  FakeWorld world(2, 0, each_takes(ms(3)));
  world.gives_output = [](SubchainId id, std::uint64_t number) { return id == kLeader && number == 1; };
  world.publish(assignment({phased(1, ms(500), ms(0)), follows(0, kLeader, 1, ms(1000))}));
  world.run_until(at(ms(5500)));
  EXPECT_THAT(world.sent(kFollower), ElementsAre(3, 2003, 3003, 4003, 5003));
}

TEST(SubchainPacer, WhoFollowsNoOtherAnyMoreDoesNotListen) {
  FakeWorld world(2, 1, each_takes(ms(1)));
  world.publish(assignment({phased(1, ms(10), ms(0)), follows(0, kLeader, 1, ms(10))}, {{}}));
  world.run_until(at(ms(5)));
  EXPECT_THAT(world.of(kLeader).subscribers, ElementsAre(kFollower.index()));
  world.publish(assignment({phased(1, ms(10), ms(0)), phased(0, ms(10), ms(7))}, {{}}));
  world.run_until(at(ms(6)));
  EXPECT_THAT(world.of(kLeader).subscribers, IsEmpty());
  world.publish(assignment({phased(1, ms(10), ms(0)), follows(0, kLeader, 1, ms(10))}, {{}}));
  world.run_until(at(ms(8)));
  EXPECT_THAT(world.of(kLeader).subscribers, ElementsAre(kFollower.index()));
  world.publish(
      assignment({phased(1, ms(10), ms(0)), shares(0)}, {dispatch::elastic({every(1, 1, ms(4))}, 0.0, ms(5))}));
  world.run_until(at(ms(9)));
  EXPECT_THAT(world.of(kLeader).subscribers, IsEmpty());
}

TEST(SubchainPacer, WhereThereIsNoRoomToFollowItLooksByItself) {
  FakeWorld world(2, 0, each_takes(ms(3)));
  world.max_subscribers = 0;
  world.publish(assignment({phased(1, ms(10), ms(0)), follows(0, kLeader, 1, ms(5))}));
  world.run_until(at(ms(29)));
  EXPECT_THAT(world.sent(kFollower), ElementsAre(5, 15, 25)) << "every period of its own";
  EXPECT_EQ(world.of(kFollower).triggers.front().due, at(ms(3)));
}

TEST(SubchainPacer, ARunBeyondItsBudgetIsDemotedUntilTheNextTrigger) {
  FakeWorld world(1, 0, [](SubchainId, std::uint64_t number) { return number == 2 ? ms(7) : ms(2); });
  world.publish(assignment({phased(3, ms(10), ms(0), ms(4))}));
  world.run_until(at(ms(13)));
  EXPECT_THAT(world.of(kOnly).levels, Each(os::fixed_level(3)));
  EXPECT_EQ(world.of(kOnly).measured, 0U) << "a run that ends in time is not measured";
  world.run_until(at(ms(15)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kBackground));
  world.run_until(at(ms(19)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kBackground)) << "its run has ended, and the next one has not begun";
  world.run_until(at(ms(21)));
  EXPECT_THAT(world.of(kOnly).levels, Each(os::fixed_level(3)));
  EXPECT_THAT(world.overruns, ElementsAre(dispatch::Overrun{kOnly, 2, at(ms(14)) + dispatch::kBudgetGrain,
                                                            ms(4) + dispatch::kBudgetGrain}));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(0, 10, 20));
}

TEST(SubchainPacer, ARunThatGoesOnHasItsBudgetOnceAPeriodAndIsToldOfOnce) {
  FakeWorld world(1, 0, [](SubchainId, std::uint64_t number) { return number == 1 ? ms(35) : ms(2); });
  world.publish(assignment({phased(3, ms(10), ms(0), ms(4))}));
  for (int period = 0; period < 3; ++period) {
    world.run_until(at(ms(10 * period + 3)));
    EXPECT_THAT(world.of(kOnly).levels, Each(os::fixed_level(3))) << period;
    world.run_until(at(ms(10 * period + 9)));
    EXPECT_THAT(world.of(kOnly).levels, Each(Level::kBackground)) << period;
  }
  world.run_until(at(ms(51)));
  EXPECT_THAT(world.sent(kOnly), ElementsAre(0, 40, 50)) << "at 10, 20 and 30 it was given its budget";
  EXPECT_EQ(world.overruns.size(), 1U);
}

TEST(SubchainPacer, TimeThatARunWaitsIsNotItsBudgets) {
  FakeWorld world(1, 0, each_takes(ms(9)));
  // Pre-empted for all but the first and the last millisecond.
  world.cpu_time = [&](SubchainId) {
    const Nanos since = (world.now - TimePoint{}) % ms(10);
    return (world.now - TimePoint{}) / ms(10) * ms(2) + std::min(since, ms(1)) + std::max(since - ms(8), Nanos{0});
  };
  world.publish(assignment({phased(3, ms(10), ms(0), ms(2))}));
  world.run_until(at(ms(9)) + Nanos{1});
  EXPECT_THAT(world.overruns, IsEmpty());
  EXPECT_EQ(world.of(kOnly).measured, 7U) << "after 2 ms, and then each time that the rest has passed";
  EXPECT_THAT(world.of(kOnly).levels, Each(os::fixed_level(3)));
}

TEST(SubchainPacer, ADemotedRunThatHangsIsSuspendedAndRestored) {
  FakeWorld world(1, 0, [](SubchainId, std::uint64_t number) { return number == 1 ? kNeverEnds : ms(1); });
  policy::SubchainPlace place = phased(3, ms(10), ms(0), ms(4));
  place.pacing.hang_after = ms(30);
  world.publish(assignment({place}));
  world.run_until(at(ms(29)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kBackground));
  expect_suspended_until_it_ends(world, at(ms(45)), at(ms(46)));
  EXPECT_EQ(world.overruns.size(), 1U);
}

TEST(SubchainPacer, ADemotedRunStaysSoThroughPlansThatLimitIt) {
  FakeWorld world(1, 0, each_takes(ms(9)));
  world.publish(assignment({phased(3, ms(20), ms(0), ms(4))}));
  world.run_until(at(ms(5)));
  world.join(kOnly);
  world.publish(assignment({phased(2, ms(20), ms(0), ms(5))}));
  world.run_until(at(ms(6)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kBackground)) << "threads that join it, too";
  world.publish(assignment({paced(ms(20), CpuSet{0})}));
  world.run_until(at(ms(7)));
  EXPECT_THAT(world.of(kOnly).levels, Each(Level::kActive)) << "on cores that it owns";
}

TEST(SubchainPacer, ARunThatBeganElsewhereHasItsBudgetFromThenOn) {
  FakeWorld world(1, 1, [](SubchainId, std::uint64_t number) { return number == 1 ? ms(40) : ms(1); });
  world.publish(assignment({shares(0)}, {dispatch::elastic({every(1, 0, ms(4))}, 0.0, ms(5))}));
  world.run_until(at(ms(6)));
  world.publish(assignment({phased(3, ms(20), ms(0), ms(4))}, {{}}));
  world.run_until(at(ms(60)));
  ASSERT_EQ(world.overruns.size(), 1U);
  EXPECT_LE(world.overruns.front().cpu, ms(4) + dispatch::kBudgetGrain);
  EXPECT_GT(world.overruns.front().at, at(ms(10)));
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
