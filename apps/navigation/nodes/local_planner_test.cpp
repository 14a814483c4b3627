#include "local_planner.h"

#include <gtest/gtest.h>

#include <cmath>

#include "testing/analytic_world.h"
#include "testing/simulated_world.h"

namespace ctn::navigation {
namespace {

using testing::AnalyticWorld;

Command towards(const Point& carrot, double left = 10.0) {
  Command command;
  command.stop = false;
  command.carrot = carrot;
  command.distance_left = left;
  return command;
}

// LM and LP, 25 times a second.
void drive(AnalyticWorld& world, const Command& command, double seconds) {
  LocalMapper mapper;
  LocalPlanner planner;
  for (double until = world.time() + seconds; world.time() < until - 1e-9;) {
    const LocalMap map = mapper.run(*ScanFilter{}.run(world.scan(), world.odometry()).scan).map;
    world.advance(0.04, planner.run(map, world.odometry(), command).velocity);
  }
}

TEST(LocalPlanner, DrivesStraightToACarrotAhead) {
  AnalyticWorld world({}, {0.0, 0.0, 0.0});
  drive(world, towards({4.0, 0.0}), 4.0);
  EXPECT_GT(world.truth().x, 2.0);
  EXPECT_NEAR(world.truth().y, 0.0, 0.05);
}

TEST(LocalPlanner, IsNeverFasterThanTheRobotMayBe) {
  LocalMap map;
  LocalPlanner planner;
  const Odometry odometry{{}, {}, {LocalPlanner::kLimits.speed, 0.0}};
  EXPECT_LE(planner.run(map, odometry, towards({4.0, 0.0})).velocity.linear, LocalPlanner::kLimits.speed);
  EXPECT_GE(planner.run(map, odometry, towards({4.0, 0.0})).velocity.linear, 0.9 * LocalPlanner::kLimits.speed);
}

TEST(LocalPlanner, StandsStillWhenToldTo) {
  const LocalPlanner::Result result = LocalPlanner{}.run({}, {}, {});
  EXPECT_EQ(result.velocity, Velocity{});
  EXPECT_EQ(result.work, Work{});
}

TEST(LocalPlanner, TurnsOnTheSpotToLookAroundWhereThereIsRoom) {
  Command command;
  command.look_around = true;
  AnalyticWorld open({{{2.0, -5.0}, {2.0, 5.0}}}, {0.0, 0.0, 0.0});
  drive(open, command, 4.0);
  EXPECT_GT(open.truth().heading, 1.5);
  EXPECT_EQ(open.driven(), 0.0);
  AnalyticWorld tight({{{0.38, -5.0}, {0.38, 5.0}}}, {0.0, 0.0, 0.0});
  drive(tight, command, 4.0);
  EXPECT_EQ(tight.truth().heading, 0.0);
}

TEST(LocalPlanner, TurnsOnTheSpotToACarrotBehind) {
  AnalyticWorld world({}, {0.0, 0.0, 0.0});
  drive(world, towards({-3.0, 0.5}), 1.0);
  EXPECT_LT(std::hypot(world.truth().x, world.truth().y), 0.02);
  EXPECT_GT(world.truth().heading, 0.5);
  drive(world, towards({-3.0, 0.5}), 5.0);
  EXPECT_LT(world.truth().x, -1.5);
}

// A wall just behind it, where its laser sees nothing, and which it touches as it turns.
TEST(LocalPlanner, GetsFreeOfAWallThatItDoesNotSee) {
  world::WorldFile file;
  file.bounds = {{0.0, 0.0}, {8.0, 8.0}};
  world::add_block(file, {{0.0, 0.0}, {8.0, 0.0}, {8.0, 8.0}, {0.0, 8.0}});
  file.start = {kInnerRadius + 0.02, 4.0, 0.0};
  testing::SimulatedWorld plant(file, {});
  LocalMapper mapper;
  LocalPlanner planner;
  while (plant.time() < 30.0) {
    const LocalMap map = mapper.run(*ScanFilter{}.run(plant.scan(), plant.odometry()).scan).map;
    plant.advance(0.04, planner.run(map, plant.odometry(), towards({1.0, 6.5})).velocity);
  }
  EXPECT_FALSE(plant.world().contacts().empty()) << "the wall did not hold it: this test shows nothing";
  EXPECT_LT(distance(position(plant.world().truth()), {1.0, 6.5}), 0.5);
}

// Held from behind, with something that it sees ahead and a little aside.
TEST(LocalPlanner, TouchesNothingThatItSeesWhenItGetsFree) {
  world::WorldFile file;
  file.bounds = {{0.0, 0.0}, {8.0, 8.0}};
  world::add_block(file, {{0.0, 0.0}, {8.0, 0.0}, {8.0, 8.0}, {0.0, 8.0}});
  file.start = {kInnerRadius + 0.02, 4.0, 0.0};
  const double ahead = file.start.x + 0.44;
  world::add_block(file, {{ahead, 4.16}, {ahead + 0.3, 4.16}, {ahead + 0.3, 4.5}, {ahead, 4.5}});
  testing::SimulatedWorld plant(file, {});
  LocalMapper mapper;
  LocalPlanner planner;
  double farthest = 0.0;
  while (plant.time() < 20.0) {
    const LocalMap map = mapper.run(*ScanFilter{}.run(plant.scan(), plant.odometry()).scan).map;
    plant.advance(0.04, planner.run(map, plant.odometry(), towards({1.0, 6.5})).velocity);
    farthest = std::max(farthest, plant.world().truth().x);
  }
  for (const world::Contact& contact : plant.world().contacts()) {
    const double heading = contact.pose.heading;
    const double rearmost = contact.pose.x - kInnerRadius * (std::abs(std::cos(heading)) + std::abs(std::sin(heading)));
    EXPECT_NEAR(rearmost, 0.0, 0.01) << "it is not the wall behind";
  }
  EXPECT_GT(farthest, file.start.x + 0.03) << "it did not try to get free: this test shows nothing";
}

TEST(LocalPlanner, StopsBeforeAWall) {
  AnalyticWorld world({{{2.0, -20.0}, {2.0, 20.0}}}, {0.0, 0.0, 0.0});
  drive(world, towards({6.0, 0.0}), 12.0);
  EXPECT_FALSE(world.touched());
  EXPECT_GT(world.truth().x, 0.8);
}

TEST(LocalPlanner, GoesRoundAPillarInTheWay) {
  std::vector<testing::Wall> walls;
  testing::add_box(walls, 1.6, -0.1, 1.9, 0.2);
  AnalyticWorld world(walls, {0.0, 0.0, 0.0});
  drive(world, towards({2.9, 0.0}, 4.0), 15.0);
  EXPECT_FALSE(world.touched());
  EXPECT_GT(world.truth().x, 2.5);
}

// An obstacle that the global map lacks stands on the path along a corridor: a corridor 2.5 m wide, and a box in its
// middle that leaves 1 m on one side.
TEST(LocalPlanner, GoesRoundAnObstacleThatTheGlobalMapLacks) {
  std::vector<testing::Wall> walls;
  testing::add_box(walls, -2.0, -1.25, 12.0, 1.25);
  testing::add_box(walls, 4.0, -0.7, 4.6, 0.25);
  AnalyticWorld world(walls, {0.0, 0.0, 0.0});
  Path path;
  path.outcome = Path::Outcome::kFound;
  path.to_goal = true;
  for (int i = 0; i <= 45; ++i) path.points.push_back({i * 0.2, 0.0});  // through the box
  LocalMapper mapper;
  Command command;
  while (world.time() < 40.0 && !command.arrived) {
    const LocalMap map = mapper.run(*ScanFilter{}.run(world.scan(), world.odometry()).scan).map;
    command = NavigationCommand{}.run(path, {}, world.odometry()).command;
    world.advance(0.04, LocalPlanner{}.run(map, world.odometry(), command).velocity);
  }
  EXPECT_TRUE(command.arrived) << world.truth().x << " " << world.truth().y;
  EXPECT_FALSE(world.touched());
  EXPECT_LT(world.driven(), 11.0);  // 9 m are the least
}

TEST(LocalPlanner, WaitsWhereNoWayIsLeftAndGoesOnWhenThereIs) {
  std::vector<testing::Wall> walls;
  testing::add_box(walls, -2.0, -1.25, 12.0, 1.25);
  walls.push_back({{3.0, -1.25}, {3.0, 1.25}});
  AnalyticWorld world(walls, {0.0, 0.0, 0.0});
  Command command = towards({4.0, 0.0});
  drive(world, command, 8.0);
  EXPECT_FALSE(world.touched());
  EXPECT_LT(world.truth().x, 3.0);
  const double x = world.truth().x;
  drive(world, command, 8.0);
  EXPECT_FALSE(world.touched());
  EXPECT_NEAR(world.truth().x, x, 0.3);
  world.walls().pop_back();
  drive(world, command, 8.0);
  EXPECT_FALSE(world.touched());
  EXPECT_GT(world.truth().x, 3.5);
}

TEST(LocalPlanner, StopsForWhatStepsInTheWay) {
  AnalyticWorld world({{{9.0, -5.0}, {9.0, 5.0}}}, {0.0, 0.0, 0.0});
  drive(world, towards({8.0, 0.0}), 3.0);
  const double x = world.truth().x;
  world.walls().push_back({{x + 1.2, -20.0}, {x + 1.2, 20.0}});
  drive(world, towards({8.0, 0.0}), 6.0);
  EXPECT_FALSE(world.touched());
  EXPECT_LT(world.truth().x, x + 1.2);
}

// A thing as large as the robot, as LM would give it.
MovingObstacle thing(const Point& at, const Point& velocity) {
  const double pace = std::hypot(velocity.x, velocity.y);
  return {at, kOuterRadius, velocity, velocity * (1.0 / pace), pace};
}

LocalMap with_moving(const Point& at, const Point& velocity) {
  LocalMap map;
  map.moving.push_back(thing(at, velocity));
  return map;
}

Odometry driving(double speed) { return {{}, {}, {speed, 0.0}}; }

TEST(Foresight, WhatIsFarAwayConcernsNothing) {
  const LocalMap map = with_moving({9.0, 0.0}, {-0.5, 0.0});
  Foresight foresight(map, {}, 0.1, 1.0, LocalPlanner::kLimits);
  EXPECT_FALSE(foresight.concerned());
  EXPECT_EQ(foresight.of({0.75, 0.0}).level, Foresight::Level::kSafe);
}

// It crosses 1.7 m ahead. The robot, which drives at full speed, can stop before its course, or cannot any more.
TEST(Foresight, AVelocityIsSafeOnlyIfTheRobotCanStillStop) {
  const LocalMap map = with_moving({1.7, -1.0}, {0.0, 0.7});
  // 0.75 * 0.1 + 0.75^2 / 2 = 0.36 m until it stands; its course begins 1.7 - 0.4 - 0.06 - 0.28 = 0.96 m ahead.
  EXPECT_EQ(Foresight(map, driving(0.75), 0.1, 1.0, LocalPlanner::kLimits).of({0.75, 0.0}).level,
            Foresight::Level::kSafe);
  Odometry nearer = driving(0.75);
  nearer.pose.x = 0.65;
  EXPECT_LT(Foresight(map, nearer, 0.1, 1.0, LocalPlanner::kLimits).of({0.75, 0.0}).level, Foresight::Level::kSafe);
  EXPECT_LT(Foresight(map, driving(0.75), 0.8, 1.0, LocalPlanner::kLimits).of({0.75, 0.0}).level,
            Foresight::Level::kSafe)
      << "it reacts too late";
}

TEST(Foresight, WhatGoesAwayMayTurnBack) {
  const LocalMap map = with_moving({1.0, 1.8}, {0.0, 0.5});  // it has crossed ahead of the robot
  const Odometry standing;
  EXPECT_EQ(Foresight(map, standing, 0.1, 1.0, LocalPlanner::kLimits).of({0.0, 0.0}).level, Foresight::Level::kSafe);
  Odometry within = driving(0.0);
  within.pose.x = 1.0;
  const Velocity stay;
  EXPECT_EQ(Foresight(map, within, 0.1, 1.0, LocalPlanner::kLimits).of(stay).level, Foresight::Level::kSafe)
      << "there is time to leave its course";
  within.pose.y = 0.9;
  EXPECT_LT(Foresight(map, within, 0.1, 1.0, LocalPlanner::kLimits).of(stay).level, Foresight::Level::kSafe);
}

// As above, but it turned back before where it is going, 1.5 m farther on.
TEST(Foresight, WhatGoesAwayTurnsBackNoEarlierThanWhereItDidBefore) {
  LocalMap map = with_moving({1.0, 1.2}, {0.0, 0.5});
  Odometry within = driving(0.0);
  within.pose.x = 1.0;
  EXPECT_LT(Foresight(map, within, 0.1, 1.0, LocalPlanner::kLimits).of({}).level, Foresight::Level::kSafe);
  map.moving.front().ahead = 1.5;
  EXPECT_EQ(Foresight(map, within, 0.1, 1.0, LocalPlanner::kLimits).of({}).level, Foresight::Level::kSafe);
  map.moving.front().ahead = 0.0;
  map.moving.front().velocity = {};
  EXPECT_LT(Foresight(map, within, 0.1, 1.0, LocalPlanner::kLimits).of({}).level, Foresight::Level::kSafe)
      << "it stands there, and may start";
  map.moving.front().course = {0.0, -1.0};
  EXPECT_EQ(Foresight(map, within, 0.1, 1.0, LocalPlanner::kLimits).of({}).level, Foresight::Level::kSafe)
      << "it never came nearer";
}

TEST(Foresight, WhatStandsIsFearedByAnImpatientRobotToo) {
  LocalMap map = with_moving({1.0, 1.15}, {0.0, 0.5});
  map.moving.front().velocity = {};
  Odometry within = driving(0.0);
  within.pose.x = 1.0;
  EXPECT_LT(Foresight(map, within, 0.1, 0.2, LocalPlanner::kLimits).of({}).level, Foresight::Level::kSafe);
}

// They were seen 2 s ago, 1 m before where they are expected to be.
TEST(Foresight, WhatIsNotSeenIsNoFartherAheadThanExpectedButMayHaveTurnedBack) {
  Odometry within = driving(0.0);
  within.pose.x = 1.0;
  LocalMap coming = with_moving({1.0, 2.4}, {0.0, -0.5});
  coming.moving.front().unseen = 2.0;
  EXPECT_EQ(Foresight(coming, within, 0.1, 1.0, LocalPlanner::kLimits).of({}).level, Foresight::Level::kSafe)
      << "there is time to leave its course";
  LocalMap going = with_moving({1.0, 2.6}, {0.0, 0.5});
  EXPECT_EQ(Foresight(going, within, 0.1, 1.0, LocalPlanner::kLimits).of({}).level, Foresight::Level::kSafe);
  going.moving.front().unseen = 2.0;
  EXPECT_LT(Foresight(going, within, 0.1, 1.0, LocalPlanner::kLimits).of({}).level, Foresight::Level::kSafe);
}

// It turned back a moment ago, and by what was measured since it is slower than it was.
TEST(Foresight, WhatIsSlowerThanItWasMayBeAsFastAgain) {
  LocalMap map = with_moving({0.9, 1.9}, {0.0, -0.4});
  const auto level = [&map](double caution) {
    return Foresight(map, driving(0.75), 0.1, caution, LocalPlanner::kLimits).of({0.75, 0.0}).level;
  };
  EXPECT_EQ(level(1.0), Foresight::Level::kSafe) << "the robot goes through in front of it";
  EXPECT_EQ(level(0.0), Foresight::Level::kSafe);
  map.moving.front().pace = 0.8;
  EXPECT_LT(level(0.0), Foresight::Level::kSafe) << "for what is expected, whatever it could do besides";
  map.moving.front().ahead = 0.3;
  EXPECT_EQ(level(0.0), Foresight::Level::kSafe) << "it does not come so far";
}

TEST(MovingObstacle, AtItsPaceIsWhereItGoesByWhatItOnceDid) {
  MovingObstacle moving = thing({1.0, 0.0}, {0.0, 0.4});
  EXPECT_EQ(moving.at_its_pace(2.0), moving.at(2.0)) << "it is as fast as ever";
  moving.pace = 0.5;
  EXPECT_NEAR(moving.at_its_pace(2.0).y, 1.0, 1e-9);
  moving.unseen = 1.0;  // its place is what 0.4 m/s made of it
  EXPECT_NEAR(moving.at_its_pace(2.0).y, 1.1, 1e-9);
  moving.ahead = 0.7;
  EXPECT_NEAR(moving.at_its_pace(2.0).y, 0.7, 1e-9);
  moving.velocity = {};
  EXPECT_EQ(moving.at_its_pace(2.0), moving.centre) << "it stands";
}

TEST(Foresight, PredictsFromTheScansInstant) {
  LocalMap old = with_moving({1.5, -1.2}, {0.0, 0.7});
  LocalMap now = with_moving({1.5, -0.85}, {0.0, 0.7});
  Odometry odometry = driving(0.6);
  odometry.stamp = std::chrono::milliseconds(500);
  now.stamp = odometry.stamp;
  Command command = towards({4.0, 0.0});
  EXPECT_EQ(LocalPlanner{}.run(with_moving({1.5, -0.85}, {0.0, 0.7}), driving(0.6), command).velocity,
            LocalPlanner{}.run(now, odometry, command).velocity);
  // The same thing in a map that is half a second old, but for what it may have done since.
  Foresight late(old, odometry, 0.1, 0.0, LocalPlanner::kLimits);
  Foresight fresh(now, odometry, 0.1, 0.0, LocalPlanner::kLimits);
  for (double speed = -0.4; speed < 0.75; speed += 0.1) {
    for (double turn = -1.0; turn < 1.1; turn += 0.5) {
      EXPECT_EQ(late.of({speed, turn}).level, fresh.of({speed, turn}).level) << speed << " " << turn;
    }
  }
}

// It passes in front of a robot that drives too fast to stop as far from it as it should.
TEST(Foresight, TellsHowMuchOfTheRoomIsLeftWhereThereIsTooLittle) {
  const LocalMap map = with_moving({0.9, -0.4}, {0.0, 0.5});
  Foresight foresight(map, driving(0.6), 0.1, 0.0, LocalPlanner::kLimits);
  const Foresight::Safety brakes = foresight.of({0.35, 0.0});
  const Foresight::Safety goes = foresight.of({0.6, 0.0});
  ASSERT_EQ(brakes.level, Foresight::Level::kTooNear);
  ASSERT_EQ(goes.level, Foresight::Level::kTooNear);
  EXPECT_GT(brakes.room, goes.room + 0.01);
}

// The wheels count 0.1 m/s too much in one instant. Without that it would be as if the robot had been told to go so.
TEST(LocalPlanner, KnowsHowFastItIsByWhatItWasTold) {
  const auto told = [](double too_much) {
    LocalPlanner planner;
    Velocity velocity;
    for (int i = 0; i <= 5; ++i) {
      LocalMap map;
      Odometry odometry = driving(velocity.linear + (i == 5 ? too_much : 0.0));
      map.stamp = odometry.stamp = std::chrono::milliseconds(40 * i);
      velocity = planner.run(map, odometry, towards({8.0, 0.0})).velocity;
    }
    return velocity.linear;
  };
  EXPECT_NEAR(told(0.1), told(0.0), 0.04);
  LocalPlanner first;  // was told nothing yet: believes the wheels
  EXPECT_GT(first.run({}, driving(0.4), towards({8.0, 0.0})).velocity.linear, 0.5);
}

TEST(LocalPlanner, GetsOutOfTheWayOfWhatComesTowardsIt) {
  const Command command = towards({4.0, 0.0});
  const Velocity free = LocalPlanner{}.run({}, driving(0.5), command).velocity;
  EXPECT_GT(free.linear, 0.7);
  EXPECT_LT(LocalPlanner{}.run(with_moving({1.4, 0.0}, {-0.5, 0.0}), driving(0.5), command).velocity.linear, 0.5);
  // It passes far off: no reason to wait.
  EXPECT_GT(LocalPlanner{}.run(with_moving({1.7, 2.5}, {-0.8, 0.0}), {}, command).velocity.linear, 0.2);
}

TEST(LocalPlanner, DoesNotDriveInFrontOfWhatCrosses) {
  const Command command = towards({4.0, 0.0});
  const Velocity free = LocalPlanner{}.run({}, driving(0.6), command).velocity;
  const Velocity crossed = LocalPlanner{}.run(with_moving({1.2, -1.1}, {0.0, 0.8}), driving(0.6), command).velocity;
  EXPECT_LT(crossed.linear, free.linear - 0.1);
}

TEST(LocalPlanner, CountsOnReactingWithinItsPeriodHoweverSeldomMapsCome) {
  const auto before_a_wall = [](double ahead, double period) {
    AnalyticWorld world({{{ahead + kOuterRadius, -20.0}, {ahead + kOuterRadius, 20.0}}}, {0.0, 0.0, 0.0});
    LocalMapper mapper;
    mapper.run(*ScanFilter{}.run(world.scan(), world.odometry()).scan);
    world.advance(period, {});
    const LocalMap map = mapper.run(*ScanFilter{}.run(world.scan(), world.odometry()).scan).map;
    Odometry odometry = driving(0.6);
    odometry.stamp = map.stamp;
    return LocalPlanner{}.run(map, odometry, towards({8.0, 0.0})).velocity;
  };
  EXPECT_NE(before_a_wall(0.3, 0.02), before_a_wall(0.5, 0.02));
  for (double ahead = 0.3; ahead < 0.56; ahead += 0.05) {
    EXPECT_EQ(before_a_wall(ahead, 0.2), before_a_wall(ahead, 0.02)) << ahead;
  }
}

// All nodes of the local chain, 25 times a second, and a box that moves, whatever happens.
struct Encounter {
  bool touched = false;
  Pose end;
  double seconds = 0.0;
};
template <typename Place>
Encounter meet(std::vector<testing::Wall> walls, const Command& command, double seconds, double period,
               const Place& place) {
  AnalyticWorld world(walls, {0.0, 0.0, 0.0}, {.range = 0.01, .turn_noise = 0.005});
  LocalMapper mapper;
  LocalPlanner planner;
  while (world.time() < seconds - 1e-9) {
    const LocalMap map = mapper.run(*ScanFilter{}.run(world.scan(), world.odometry()).scan).map;
    const Velocity velocity = planner.run(map, world.odometry(), command).velocity;
    for (double until = world.time() + period; world.time() < until - 1e-9;) {
      world.walls() = walls;
      const Point at = place(world.time());
      testing::add_box(world.walls(), at.x - 0.28, at.y - 0.28, at.x + 0.28, at.y + 0.28);
      world.advance(0.02, velocity);
    }
    if (!command.stop && distance(position(world.truth()), command.carrot) < 0.3) break;
  }
  return {world.touched(), world.truth(), world.time()};
}

std::vector<testing::Wall> big_room() {
  std::vector<testing::Wall> walls;
  testing::add_box(walls, -4.0, -4.0, 8.0, 4.0);
  return walls;
}

TEST(LocalPlanner, CrossesTheCourseOfWhatGoesToAndFroWithoutContact) {
  for (const double speed : {0.3, 0.5, 0.7}) {
    for (const double phase : {0.0, 3.0}) {
      const auto at = [&](double seconds) {
        const double along = std::fmod(seconds * speed + phase, 6.0);
        return Point{2.5, -1.5 + (along < 3.0 ? along : 6.0 - along)};
      };
      const Encounter encounter = meet(big_room(), towards({5.0, 0.0}), 60.0, 0.04, at);
      EXPECT_FALSE(encounter.touched) << speed << " m/s, phase " << phase;
      EXPECT_LT(encounter.seconds, 59.0) << speed << " m/s, phase " << phase;
    }
  }
}

TEST(LocalPlanner, GivesWayToWhatComesHeadOn) {
  for (const double aside : {-0.3, 0.0, 0.2}) {
    const auto at = [&](double seconds) { return Point{5.5 - 0.5 * seconds, aside}; };
    const Encounter encounter = meet(big_room(), towards({7.0, 0.0}), 40.0, 0.04, at);
    EXPECT_FALSE(encounter.touched) << aside;
    EXPECT_LT(encounter.seconds, 39.0) << aside;
  }
}

TEST(LocalPlanner, GetsOutOfTheWayWhereItWasToStandStill) {
  for (const double aside : {-0.2, 0.0, 0.3}) {
    const auto at = [&](double seconds) { return Point{0.5 * aside + 0.2, 3.5 - 0.5 * seconds}; };
    const Encounter encounter = meet(big_room(), {}, 14.0, 0.04, at);
    EXPECT_FALSE(encounter.touched) << aside;
  }
}

TEST(LocalPlanner, NearObstaclesAreMoreWork) {
  AnalyticWorld world({{{0.42, -20.0}, {0.42, 20.0}}}, {0.0, 0.0, 0.0});
  LocalMapper mapper;
  const LocalMap map = mapper.run(*ScanFilter{}.run(world.scan(), world.odometry()).scan).map;
  LocalPlanner planner;
  EXPECT_GT(planner.run(map, world.odometry(), towards({4.0, 0.0})).work.candidates,
            planner.run({}, world.odometry(), towards({4.0, 0.0})).work.candidates);
}

}  // namespace
}  // namespace ctn::navigation
