// All nodes in a loop with a world, in virtual time.
#include "testing/closed_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>

#include "testing/analytic_world.h"
#include "testing/simulated_world.h"

namespace ctn::navigation {
namespace {

using testing::AnalyticWorld;
using testing::ClosedLoop;
using testing::Errors;
using testing::SimulatedWorld;
using testing::two_rooms;

constexpr Errors kLikeReal{.range = 0.01, .way = 0.01, .turn = 0.01, .turn_noise = 0.005};
constexpr Pose kStart{1.5, 1.2, 0.4};

TEST(ClosedLoop, DrivesThroughADoorwayToAGoalWithoutContact) {
  for (const std::uint64_t seed : {1U, 2U}) {
    AnalyticWorld world(two_rooms(), kStart, kLikeReal, seed);
    ClosedLoop loop(world, Point{9.0, 4.8});
    loop.run(60.0);
    EXPECT_TRUE(loop.arrived()) << seed;
    EXPECT_FALSE(world.touched()) << seed;
    EXPECT_LT(distance(position(world.truth()), {9.0, 4.8}), 0.4) << seed;
    EXPECT_LT(world.driven(), 15.0) << seed;  // 8.3 m are the least
  }
}

struct Exploration {
  double time = 0.0;
  Pose end;
  std::vector<Cell> cells;
  std::map<std::string, std::vector<Work>> work;
  bool touched = false;
  bool explored = false;
  double known = 0.0;  // share of places in the rooms that are free on the map

  bool operator==(const Exploration&) const = default;
};

Exploration explore(std::uint64_t seed) {
  Exploration result;
  AnalyticWorld world(two_rooms(), kStart, kLikeReal, seed);
  ClosedLoop loop(world, std::nullopt,
                  [&](const char* node, const std::function<Work()>& run) { result.work[node].push_back(run()); });
  loop.run(120.0);
  result.time = world.time();
  result.end = world.truth();
  result.cells = loop.map().cells;
  result.touched = world.touched();
  result.explored = loop.explored();
  int places = 0;
  int known = 0;
  for (double x = 0.3; x < 9.8; x += 0.2) {
    for (double y = 0.3; y < 5.8; y += 0.2) {
      if (std::abs(x - 5.0) < 0.25 || (std::abs(x - 7.65) < 0.5 && std::abs(y - 2.85) < 0.5)) continue;
      ++places;
      if (loop.map().at({x, y}) == Cell::kFree) ++known;
    }
  }
  result.known = static_cast<double>(known) / places;
  return result;
}

TEST(ClosedLoop, ExploresTwoRooms) {
  const Exploration exploration = explore(1);
  EXPECT_TRUE(exploration.explored);
  EXPECT_FALSE(exploration.touched);
  EXPECT_GT(exploration.known, 0.95);

  const std::vector<Work>& mapping = exploration.work.at("GM");
  std::uint64_t max = 0;
  for (const Work& work : mapping) max = std::max(max, work.cells);
  EXPECT_GT(max, 5 * mapping.front().cells);  // grows with the map
  const std::vector<Work>& planning = exploration.work.at("GP");
  EXPECT_GT(planning.back().cells, planning.front().cells);
}

TEST(ClosedLoop, IsTheSameEachTimeForASeed) {
  const Exploration first = explore(3);
  EXPECT_EQ(explore(3), first);
  EXPECT_NE(explore(4), first);
}

world::WorldFile world_file(const std::string& name) {
  ctn::Result<world::WorldFile> file = world::read_world(std::string(NAVIGATION_WORLDS) + "/" + name);
  EXPECT_TRUE(file) << file.error().message();
  return *file;
}

TEST(ClosedLoop, ReachesTheGoalOfMap1WhereNothingMoves) {
  world::WorldFile file = world_file("map1.yaml");
  file.movers.clear();
  SimulatedWorld plant(file, {});
  ClosedLoop loop(plant, file.goal);
  loop.run(90.0);
  const world::Score score = plant.world().score();
  EXPECT_TRUE(score.reached_at);
  EXPECT_TRUE(score.contacts.empty());
  EXPECT_LT(score.travelled, 25.0);
}

// A box that the map lacks comes to stand in the way when the robot has seen the place free for long.
TEST(ClosedLoop, GoesRoundAnObstacleThatComesToStay) {
  AnalyticWorld world({}, {1.0, 1.25, 0.0}, kLikeReal);
  testing::add_box(world.walls(), 0.0, 0.0, 14.0, 2.5);
  ClosedLoop loop(world, Point{13.0, 1.25});
  loop.run(6.0);
  ASSERT_LT(world.truth().x, 6.0);
  testing::add_box(world.walls(), 7.0, 0.6, 7.6, 1.4);
  loop.run(60.0);
  EXPECT_TRUE(loop.arrived()) << world.truth().x << " " << world.truth().y;
  EXPECT_FALSE(world.touched());
}

}  // namespace
}  // namespace ctn::navigation
