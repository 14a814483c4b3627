#include "global_planner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "navigation_command.h"

namespace ctn::navigation {
namespace {

// Free from (0, 0) to `size`, with a wall around it.
GlobalMap room(const Point& size) {
  GlobalMap map;
  map.frame = {-25, -25, static_cast<int>(size.x / kCell) + 50, static_cast<int>(size.y / kCell) + 50};
  map.cells.assign(map.frame.cells(), Cell::kUnknown);
  for (int row = 0; row < map.frame.height; ++row) {
    for (int column = 0; column < map.frame.width; ++column) {
      const Point at = map.frame.centre(column, row);
      const bool inside = at.x > 0.0 && at.y > 0.0 && at.x < size.x && at.y < size.y;
      const bool near = at.x > -kCell && at.y > -kCell && at.x < size.x + kCell && at.y < size.y + kCell;
      if (near) map.cells[map.frame.index(column, row)] = inside ? Cell::kFree : Cell::kObstacle;
    }
  }
  return map;
}

void fill(GlobalMap& map, const Point& from, const Point& to, Cell cell) {
  for (int row = map.frame.row(from.y); row <= map.frame.row(to.y); ++row) {
    for (int column = map.frame.column(from.x); column <= map.frame.column(to.x); ++column) {
      map.cells[map.frame.index(column, row)] = cell;
    }
  }
}

double length(const std::vector<Point>& points) {
  double sum = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += distance(points[i - 1], points[i]);
  return sum;
}

TEST(GlobalPlanner, GoesStraightWhereItCan) {
  const GlobalMap map = room({8.0, 4.0});
  const Path path = GlobalPlanner{}.run(map, {1.0, 2.0, 0.0}, Point{7.0, 2.0}).path;
  ASSERT_EQ(path.outcome, Path::Outcome::kFound);
  EXPECT_TRUE(path.to_goal);
  EXPECT_NEAR(length(path.points), 6.0, 0.1);
  EXPECT_LT(distance(path.points.front(), {1.0, 2.0}), 0.05);
  EXPECT_LT(distance(path.points.back(), {7.0, 2.0}), 0.05);
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    EXPECT_LE(distance(path.points[i - 1], path.points[i]), Path::kSpacing);
  }
}

TEST(GlobalPlanner, KeepsItsDistanceInADoorway) {
  GlobalMap map = room({8.0, 6.0});
  fill(map, {4.0, 0.0}, {4.1, 3.9}, Cell::kObstacle);  // a doorway from there to 5.3
  fill(map, {4.0, 5.3}, {4.1, 5.9}, Cell::kObstacle);
  const Path path = GlobalPlanner{}.run(map, {1.0, 1.0, 0.0}, Point{7.0, 1.0}).path;
  ASSERT_EQ(path.outcome, Path::Outcome::kFound);
  bool through = false;
  for (const Point& point : path.points) {
    if (std::abs(point.x - 4.05) > 0.2) continue;
    through = true;
    EXPECT_NEAR(point.y, 4.6, 0.3);
  }
  EXPECT_TRUE(through);
}

TEST(GlobalPlanner, DoesNotSqueezeThroughAGap) {
  GlobalMap map = room({8.0, 4.0});
  fill(map, {4.0, 0.0}, {4.1, 1.7}, Cell::kObstacle);
  fill(map, {4.0, 2.3}, {4.1, 3.9}, Cell::kObstacle);
  EXPECT_EQ(GlobalPlanner{}.run(map, {1.0, 2.0, 0.0}, Point{7.0, 2.0}).path.outcome, Path::Outcome::kNoWay);
}

TEST(GlobalPlanner, FindsNoWayIntoAWallNorWithoutAMap) {
  const GlobalMap map = room({8.0, 4.0});
  EXPECT_EQ(GlobalPlanner{}.run(map, {1.0, 2.0, 0.0}, Point{8.01, 2.0}).path.outcome, Path::Outcome::kNoWay);
  const GlobalPlanner::Result result = GlobalPlanner{}.run({}, Pose{}, Point{1.0, 1.0});
  EXPECT_EQ(result.path.outcome, Path::Outcome::kNoMap);
  EXPECT_EQ(result.work, Work{});
}

TEST(GlobalPlanner, GoesThroughTheUnknownToAGoalEvenBeyondTheMap) {
  GlobalMap map = room({8.0, 4.0});
  fill(map, {7.9, 0.5}, {8.1, 3.5}, Cell::kUnknown);  // the wall there was not seen
  const Path path = GlobalPlanner{}.run(map, {1.0, 2.0, 0.0}, Point{20.0, 2.0}).path;
  ASSERT_EQ(path.outcome, Path::Outcome::kFound);
  EXPECT_LT(distance(path.points.back(), {20.0, 2.0}), 0.05);
}

TEST(GlobalPlanner, ExploresTheNearestFrontierThatIsLargeEnough) {
  GlobalMap map = room({12.0, 4.0});
  fill(map, {0.0, 1.0}, {0.5, 3.0}, Cell::kUnknown);    // 5.5 m away
  fill(map, {8.0, 1.0}, {12.0, 3.9}, Cell::kUnknown);   // 2 m away
  fill(map, {6.0, 3.0}, {6.04, 3.04}, Cell::kUnknown);  // nearest, but a speck
  const Path path = GlobalPlanner{}.run(map, {6.0, 2.0, 0.0}, std::nullopt).path;
  ASSERT_EQ(path.outcome, Path::Outcome::kFound);
  EXPECT_FALSE(path.to_goal);
  EXPECT_NEAR(path.points.back().x, 8.0, 0.1);
}

TEST(GlobalPlanner, HasNothingLeftToExploreInAClosedRoom) {
  EXPECT_EQ(GlobalPlanner{}.run(room({8.0, 4.0}), {1.0, 2.0, 0.0}, std::nullopt).path.outcome,
            Path::Outcome::kNothingLeft);
}

TEST(GlobalPlanner, ALargerMapIsMoreWork) {
  const Work small = GlobalPlanner{}.run(room({8.0, 4.0}), {1.0, 2.0, 0.0}, std::nullopt).work;
  const Work large = GlobalPlanner{}.run(room({16.0, 8.0}), {1.0, 2.0, 0.0}, std::nullopt).work;
  EXPECT_GT(large.expanded, 3 * small.expanded);
  EXPECT_GT(large.cells, 2 * small.cells);
}

// A robot at (1, 2) that looks ahead and sees what the map does not have: a box on the straight way.
Localization seeing_a_box(double left, double right) {
  auto scan = std::make_shared<CleanScan>();
  scan->odometry.pose = {1.0, 2.0, 0.0};
  for (double y = right; y <= left; y += kCell) scan->points.push_back({2.0, y});
  Localization localization;
  localization.newest = scan;
  return localization;
}

double least_distance(const Path& path, const Point& from) {
  double least = 1e9;
  for (const Point& point : path.points) least = std::min(least, distance(point, from));
  return least;
}

TEST(GlobalPlanner, GoesRoundWhatOnlyTheNewestScanShows) {
  const GlobalMap map = room({8.0, 4.0});
  const Point goal{7.0, 2.0};
  const Path through = GlobalPlanner{}.run(map, seeing_a_box(-1.0, 1.0), goal).path;  // sees nothing
  ASSERT_EQ(through.outcome, Path::Outcome::kFound);
  EXPECT_LT(least_distance(through, {3.0, 2.0}), 0.15);
  const Path round = GlobalPlanner{}.run(map, seeing_a_box(0.3, -0.3), goal).path;
  ASSERT_EQ(round.outcome, Path::Outcome::kFound);
  EXPECT_GT(least_distance(round, {3.0, 2.0}), GlobalPlanner::kClearance + 0.2);
  EXPECT_LT(distance(round.points.front(), {1.0, 2.0}), 0.05);
}

TEST(GlobalPlanner, TakesWhatBlocksAllWaysToBePassingBy) {
  const GlobalMap map = room({8.0, 4.0});
  const GlobalPlanner::Result blocked = GlobalPlanner{}.run(map, seeing_a_box(1.9, -1.9), Point{7.0, 2.0});
  EXPECT_EQ(blocked.path.outcome, Path::Outcome::kFound);
  EXPECT_NEAR(length(blocked.path.points), 6.0, 0.1);

  GlobalMap open = room({8.0, 4.0});
  fill(open, {7.0, 1.0}, {8.0, 3.0}, Cell::kUnknown);
  EXPECT_EQ(GlobalPlanner{}.run(open, seeing_a_box(1.9, -1.9), std::nullopt).path.outcome, Path::Outcome::kFound);
  EXPECT_EQ(GlobalPlanner{}.run(map, seeing_a_box(1.9, -1.9), std::nullopt).path.outcome, Path::Outcome::kNothingLeft);
}

// A wall with a doorway ahead of the robot, and another one 8.5 m to the left: 14 m more.
GlobalMap two_doorways() {
  GlobalMap map = room({8.0, 12.0});
  fill(map, {3.0, 0.0}, {3.1, 1.4}, Cell::kObstacle);
  fill(map, {3.0, 2.6}, {3.1, 10.0}, Cell::kObstacle);
  return map;
}

Localization at(const Localization& localization, int seconds) {
  auto scan = std::make_shared<CleanScan>(*localization.newest);
  scan->stamp = std::chrono::seconds(seconds);
  Localization later = localization;
  later.newest = scan;
  return later;
}

constexpr Point kBeyondDoorway{7.0, 2.0};

bool is_short(const GlobalPlanner::Result& result) {
  return result.path.outcome == Path::Outcome::kFound && length(result.path.points) < 8.0;
}

TEST(GlobalPlanner, WaitsForWhatBlocksTheWayNoLongerThanTheWayRoundTakes) {
  const GlobalMap map = two_doorways();
  const Localization blocked = seeing_a_box(0.5, -0.5);
  const Localization aside = seeing_a_box(-1.0, 1.0);  // says nothing
  GlobalPlanner planner;
  EXPECT_TRUE(is_short(planner.run(map, at(aside, -1), kBeyondDoorway)));
  for (const int seconds : {0, 5, 10}) EXPECT_TRUE(is_short(planner.run(map, at(blocked, seconds), kBeyondDoorway)));
  EXPECT_TRUE(is_short(planner.run(map, at(aside, 12), kBeyondDoorway))) << "it has passed";
  EXPECT_TRUE(is_short(planner.run(map, at(blocked, 15), kBeyondDoorway)));
  EXPECT_TRUE(is_short(planner.run(map, at(blocked, 30), kBeyondDoorway))) << "another wait, of 19 s at most";
  EXPECT_FALSE(is_short(planner.run(map, at(blocked, 50), kBeyondDoorway)));
}

TEST(GlobalPlanner, LooksForAShorterWayOnlyWhereItHasBecomeLonger) {
  const GlobalMap map = two_doorways();
  GlobalPlanner planner;
  const GlobalPlanner::Result first = planner.run(map, at(seeing_a_box(0.5, -0.5), 0), kBeyondDoorway);
  EXPECT_FALSE(is_short(first)) << "it has never known another one";
  EXPECT_EQ(planner.run(map, at(seeing_a_box(0.5, -0.5), 1), kBeyondDoorway).work, first.work);
  planner.run(map, at(seeing_a_box(-1.0, 1.0), 2), kBeyondDoorway);
  EXPECT_GT(planner.run(map, at(seeing_a_box(0.5, -0.5), 3), kBeyondDoorway).work.expanded, first.work.expanded);
}

TEST(GlobalPlanner, RemembersWhatItWaitedForInVainUntilItSeesThroughIt) {
  const GlobalMap map = two_doorways();
  const Localization blocked = seeing_a_box(0.5, -0.5);
  const Localization aside = seeing_a_box(-1.0, 1.0);
  GlobalPlanner planner;
  planner.run(map, at(aside, -1), kBeyondDoorway);
  planner.run(map, at(blocked, 0), kBeyondDoorway);
  ASSERT_FALSE(is_short(planner.run(map, at(blocked, 30), kBeyondDoorway)));
  EXPECT_FALSE(is_short(planner.run(map, at(blocked, 31), kBeyondDoorway)));
  EXPECT_FALSE(is_short(planner.run(map, at(aside, 32), kBeyondDoorway))) << "it no longer looks there";
  auto through = std::make_shared<CleanScan>(*aside.newest);
  through->ranges.assign(721, 6.0F);
  Localization free;
  free.newest = through;
  EXPECT_TRUE(is_short(planner.run(map, at(free, 33), kBeyondDoorway)));
}

TEST(GlobalPlanner, ForgetsWhatItWaitedForInVainWhereNoOtherWayIsLeft) {
  GlobalMap map = two_doorways();
  GlobalPlanner planner;
  planner.run(map, at(seeing_a_box(-1.0, 1.0), -1), kBeyondDoorway);
  planner.run(map, at(seeing_a_box(0.5, -0.5), 0), kBeyondDoorway);
  ASSERT_FALSE(is_short(planner.run(map, at(seeing_a_box(0.5, -0.5), 30), kBeyondDoorway)));
  fill(map, {3.0, 10.0}, {3.1, 12.0}, Cell::kObstacle);
  EXPECT_TRUE(is_short(planner.run(map, at(seeing_a_box(-1.0, 1.0), 31), kBeyondDoorway)));
}

TEST(GlobalPlanner, PlansNothingBeforeTheFirstScan) {
  EXPECT_EQ(GlobalPlanner{}.run(room({8.0, 4.0}), Localization{}, Point{7.0, 2.0}).path.outcome, Path::Outcome::kNoMap);
}

Path straight() {
  Path path;
  path.outcome = Path::Outcome::kFound;
  path.to_goal = true;
  for (int i = 0; i <= 20; ++i) path.points.push_back({i * 0.2, 1.0});
  return path;
}

TEST(NavigationCommand, PointsToThePathAheadInTheOdometrysFrame) {
  Localization localization;
  localization.correction = {10.0, 0.0, std::numbers::pi / 2.0};
  Odometry odometry;
  odometry.stamp = std::chrono::seconds(3);
  odometry.pose = transformed(inverse(localization.correction), Pose{1.0, 1.1, 0.0});
  const Command command = NavigationCommand{}.run(straight(), localization, odometry).command;
  EXPECT_FALSE(command.stop);
  EXPECT_EQ(command.stamp, odometry.stamp);
  const Point carrot = transformed(localization.correction, command.carrot);
  EXPECT_NEAR(carrot.x, 1.8, 1e-9);  // 0.1 m to the path and four points on
  EXPECT_NEAR(carrot.y, 1.0, 1e-9);
  EXPECT_NEAR(command.distance_left, 3.1, 1e-9);
}

TEST(NavigationCommand, HandsOnThePathBeyondTheCarrot) {
  Odometry odometry;
  odometry.pose = {1.0, 1.0, 0.0};
  const Command command = NavigationCommand{}.run(straight(), {}, odometry).command;
  ASSERT_FALSE(command.beyond.empty());
  EXPECT_EQ(command.beyond.front(), command.carrot);
  EXPECT_NEAR(command.beyond.back().x, 4.0, 1e-9);  // no farther than kBeyond
  EXPECT_EQ(command.beyond.size(), 12U);
}

TEST(NavigationCommand, FarFromThePathItPointsToWhereThatIsNearest) {
  Odometry odometry;
  odometry.pose = {1.0, 2.5, 0.0};
  const Command command = NavigationCommand{}.run(straight(), {}, odometry).command;
  EXPECT_NEAR(command.carrot.x, 1.0, 1e-9);
  EXPECT_NEAR(command.carrot.y, 1.0, 1e-9);
  EXPECT_NEAR(command.distance_left, 4.5, 1e-9);
}

TEST(NavigationCommand, StopsAtTheEndAndWithoutAPath) {
  Odometry odometry;
  odometry.pose = {3.9, 1.0, 0.0};
  const Command there = NavigationCommand{}.run(straight(), {}, odometry).command;
  EXPECT_TRUE(there.stop);
  EXPECT_TRUE(there.arrived);
  Path frontier = straight();
  frontier.to_goal = false;
  EXPECT_FALSE(NavigationCommand{}.run(frontier, {}, odometry).command.arrived);
  EXPECT_TRUE(NavigationCommand{}.run(frontier, {}, odometry).command.stop);
  EXPECT_TRUE(NavigationCommand{}.run({}, {}, odometry).command.stop);
  EXPECT_FALSE(NavigationCommand{}.run({}, {}, odometry).command.arrived);
  EXPECT_FALSE(NavigationCommand{}.run({}, {}, odometry).command.look_around);
}

TEST(NavigationCommand, LooksAroundWhereThereIsNoWay) {
  Path path;
  path.outcome = Path::Outcome::kNoWay;
  const Command command = NavigationCommand{}.run(path, {}, {}).command;
  EXPECT_TRUE(command.stop);
  EXPECT_TRUE(command.look_around);
}

}  // namespace
}  // namespace ctn::navigation
