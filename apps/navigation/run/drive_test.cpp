// What is measured of a run, with commands and worlds made by hand.
#include "run/drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "robot.h"

namespace ctn::navigation::run {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

// The robot at (1, 5) looks along x; the goal is at (5, 5).
world::WorldFile hall() {
  world::WorldFile world;
  world.bounds = {{0, 0}, {20, 10}};
  world::add_block(world, {{0, 0}, {20, 0}, {20, 10}, {0, 10}});
  world.start = {1, 5, 0};
  world.goal = Point{5, 5};
  return world;
}

world::MoverSpec crossing(double x, double from, double to, double speed) {
  world::MoverSpec spec;
  spec.path = {{x, from}, {x, to}};
  spec.speed = speed;
  spec.length = spec.width = 0.5;
  return spec;
}

// A map of a scan that shows nothing; obstacles are put in by hand.
LocalMap empty_map(nanoseconds stamp, const Pose& pose) {
  LocalMap map;
  map.stamp = map.odometry.stamp = stamp;
  map.odometry.pose = pose;
  map.frame = {static_cast<int>(pose.x / kCell) - 75, static_cast<int>(pose.y / kCell) - 75, 150, 150};
  map.clearance.assign(map.frame.cells(), 1.0F);
  return map;
}

std::shared_ptr<const LocalMap> with_obstacle(LocalMap map, Point at) {
  map.clearance[map.frame.index(map.frame.column(at.x), map.frame.row(at.y))] = 0.0F;
  return std::make_shared<const LocalMap>(std::move(map));
}

std::shared_ptr<const LocalMap> shared(LocalMap map) { return std::make_shared<const LocalMap>(std::move(map)); }

TEST(Drive, EndsAtTheGoalAndCountsNothingAfterwards) {
  Drive drive(hall(), 1);
  drive.move({0ms, {0.75, 0.0}, nullptr});
  drive.advance(10s);
  EXPECT_TRUE(drive.over());
  const Findings findings = drive.findings();
  EXPECT_EQ(findings.ending, Ending::kGoal);
  // 3.7 m: up to 0.75 m/s in 0.75 s, on 0.28125 m.
  ASSERT_TRUE(findings.reached_at);
  EXPECT_NEAR(std::chrono::duration<double>(*findings.reached_at).count(), 0.75 + (3.7 - 0.28125) / 0.75, 0.002);
  EXPECT_NEAR(findings.way, 3.7, 0.02);
  EXPECT_LT(findings.lasted, 5.4s);
  drive.guided({11s, 10s, {}});
  drive.move({11s, {0.75, 0.0}, nullptr});
  drive.advance(60s);
  EXPECT_TRUE(drive.findings().contacts.empty()) << "it stops at the goal";
  EXPECT_TRUE(drive.findings().guidance_ages.empty());
}

TEST(Drive, AgesCountFromTheScan) {
  Drive drive(hall(), 1);
  drive.guided({130ms, 100ms, {}});
  drive.move({150ms, {}, shared(empty_map(120ms, {1, 5, 0}))});
  EXPECT_THAT(drive.findings().guidance_ages, ::testing::ElementsAre(AgeSample{130ms, 30ms}));
  EXPECT_THAT(drive.findings().scan_ages, ::testing::ElementsAre(AgeSample{150ms, 30ms}));
  drive.detected({170ms});
  EXPECT_THAT(drive.findings().detections, ::testing::ElementsAre(170ms));
}

TEST(Drive, ThePoseOfACommandIsComparedWithTheTrueOne) {
  Drive drive(hall(), 1);
  drive.advance(100ms);
  const Pose start = hall().start;
  drive.guided({130ms, 100ms, {start.x + 0.3, start.y - 0.4, start.heading + 1.0}});
  ASSERT_EQ(drive.findings().pose_errors.size(), 1U);
  EXPECT_NEAR(drive.findings().pose_errors[0], 0.5, 1e-9) << "it has not moved";
}

TEST(Drive, TheLaserGivesAScanOnceIn20Ms) {
  Drive drive(hall(), 1);
  const auto first = drive.laser(45ms);
  EXPECT_EQ(first->scan.stamp, 40ms);
  EXPECT_EQ(first->odometry.stamp, 40ms);
  EXPECT_EQ(drive.laser(59ms), first);
  EXPECT_EQ(drive.laser(60ms)->scan.stamp, 60ms);
  EXPECT_EQ(drive.odometry(79ms).stamp, 60ms);
}

TEST(Drive, AMoverAppearsWhenTheLaserSeesItInTheWay) {
  world::WorldFile world = hall();
  // Its upper edge comes to the way's lower one, 4.62, when its centre is at 4.37: after 3.37 s. A few beams must hit.
  world.movers.push_back(crossing(2.5, 1.0, 9.0, 1.0));
  Drive drive(world, 1);
  drive.advance(6s);
  const std::vector<Appearance> appearances = drive.findings().appearances;
  ASSERT_EQ(appearances.size(), 1U);
  EXPECT_GE(appearances[0].at, 3370ms);
  EXPECT_LE(appearances[0].at, 3440ms);
  EXPECT_EQ(appearances[0].mover, 0U);
  EXPECT_EQ(appearances[0].reaction, std::nullopt);
}

TEST(Drive, WhatIsTooFarAwayOrBesideTheWayDoesNotAppear) {
  world::WorldFile world = hall();
  world.movers.push_back(crossing(4.0, 1.0, 9.0, 1.0));
  world.movers.push_back(crossing(2.5, 1.0, 4.3, 1.0));
  Drive drive(world, 1);
  drive.advance(9s);
  EXPECT_TRUE(drive.findings().appearances.empty());
}

TEST(Drive, TheReactionIsTheFirstVelocityFromAMapThatShowsIt) {
  world::WorldFile world = hall();
  world.movers.push_back(crossing(2.5, 1.0, 9.0, 1.0));
  Drive drive(world, 1);
  drive.advance(4s);
  ASSERT_EQ(drive.findings().appearances.size(), 1U);
  const nanoseconds appeared = drive.findings().appearances[0].at;
  const Pose robot{1, 5, 0};
  // At 4 s the mover is from 4.75 to 5.25 along y, its near side at x = 2.25.
  const Point on_it{2.26, 4.82};
  drive.move({4010ms, {}, with_obstacle(empty_map(appeared - 20ms, robot), on_it)});
  EXPECT_EQ(drive.findings().appearances[0].reaction, std::nullopt) << "a scan from before it appeared";
  drive.move({4020ms, {}, shared(empty_map(4000ms, robot))});
  EXPECT_EQ(drive.findings().appearances[0].reaction, std::nullopt) << "a map that does not show it yet";
  drive.move({4030ms, {}, with_obstacle(empty_map(4000ms, robot), {2.26, 6.0})});
  EXPECT_EQ(drive.findings().appearances[0].reaction, std::nullopt) << "a map that shows something else";
  drive.move({4040ms, {}, with_obstacle(empty_map(4000ms, robot), on_it)});
  EXPECT_EQ(drive.findings().appearances[0].reaction, 4040ms - appeared);
  drive.move({4060ms, {}, with_obstacle(empty_map(4040ms, robot), on_it)});
  EXPECT_EQ(drive.findings().appearances[0].reaction, 4040ms - appeared) << "the first counts";
}

TEST(Drive, AMoverMayAppearAgainWhenItWasGone) {
  world::WorldFile world = hall();
  world.movers.push_back(crossing(2.5, 1.0, 9.0, 2.0));
  Drive drive(world, 1);
  drive.advance(8s);  // there and back
  const std::vector<Appearance> appearances = drive.findings().appearances;
  ASSERT_EQ(appearances.size(), 2U);
  EXPECT_LT(appearances[0].at, 2s);
  EXPECT_GT(appearances[1].at, 5s);
}

TEST(Drive, DoesNotDependOnHowOftenItIsAdvanced) {
  world::WorldFile world = hall();
  world.movers.push_back(crossing(2.5, 1.0, 9.0, 2.0));
  Drive coarse(world, 3);
  Drive fine(world, 3);
  for (Drive* drive : {&coarse, &fine}) drive->move({0ms, {0.2, 0.05}, nullptr});
  for (nanoseconds at{}; at <= 7s; at += 7ms) fine.advance(at);
  coarse.advance(7s);
  fine.advance(7s);
  EXPECT_EQ(coarse.findings().appearances, fine.findings().appearances);
  EXPECT_EQ(coarse.findings().way, fine.findings().way);
  EXPECT_EQ(coarse.laser(7s)->scan.ranges, fine.laser(7s)->scan.ranges);
}

TEST(Drive, EndsWhenNothingIsLeftToExploreForAWhile) {
  world::WorldFile world = hall();
  world.goal.reset();
  Drive drive(world, 1);
  const auto plan = [](Path::Outcome outcome) {
    auto path = std::make_shared<Path>();
    path->outcome = outcome;
    return path;
  };
  drive.planned({1s, plan(Path::Outcome::kNothingLeft), nullptr});
  drive.planned({9s, plan(Path::Outcome::kFound), nullptr});
  drive.planned({12s, plan(Path::Outcome::kNothingLeft), nullptr});
  drive.planned({13s, plan(Path::Outcome::kNothingLeft), nullptr});
  drive.advance(21s);
  EXPECT_FALSE(drive.over());
  drive.advance(30s);
  EXPECT_TRUE(drive.over());
  EXPECT_EQ(drive.findings().ending, Ending::kExplored);
  EXPECT_EQ(drive.findings().lasted, 22s);
  EXPECT_NEAR(drive.findings().explored, 0.95, 0.02) << "all but what lies behind the robot";
  EXPECT_EQ(drive.findings().explored_90_at, 0ns);
}

}  // namespace
}  // namespace ctn::navigation::run
