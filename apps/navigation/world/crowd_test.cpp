#include "crowd.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <numbers>

#include "grid.h"
#include "scene.h"

namespace ctn::navigation::world {
namespace {

CrowdSpec any_crowd() {
  CrowdSpec spec;
  spec.seed = *rc::gen::arbitrary<std::uint64_t>();
  spec.density = *rc::gen::inRange(0, 16) * 0.01;
  spec.movers = *rc::gen::inRange(0, 16);
  spec.length = *rc::gen::inRange(8, 30);
  spec.width = *rc::gen::inRange(4, 20);
  return spec;
}

TEST(Crowd, AlwaysLeavesTheRobotAWay) {
  rc::check([] {
    const WorldFile world = make_crowd(any_crowd());
    RC_ASSERT(Grid(world, 0.1).path_exists(position(world.start), *world.goal, kRobotSide / std::numbers::sqrt2));
  });
}

TEST(Crowd, MoversKeepToFreeSpaceAndAwayFromTheStart) {
  rc::check([] {
    const WorldFile world = make_crowd(any_crowd());
    const Scene scene(world, 1);
    for (std::size_t i = 0; i < world.movers.size(); ++i) {
      const Mover& mover = scene.movers()[i];
      for (double at = 0.0; at < mover.cycle(); at += 0.2) {
        const Point where = mover.at(at);
        double nearest = 10.0;
        for (const Segment& wall : world.walls) nearest = std::min(nearest, distance(wall, where));
        RC_ASSERT(nearest > mover.spec().reach());
        RC_ASSERT(scene.to_mover(i, world.start, kRobotSide, at) > 0.3);
      }
    }
  });
}

TEST(Crowd, IsAFileThatReadsAsTheSame) {
  rc::check([] {
    const WorldFile world = make_crowd(any_crowd());
    const auto read = parse_world(to_yaml(world), "crowd.yaml", ".");
    RC_ASSERT(read.ok());
    RC_ASSERT(read->movers == world.movers);
    RC_ASSERT(read->blocks == world.blocks);
    RC_ASSERT(read->bounds == world.bounds);
    RC_ASSERT(read->start == world.start);
    RC_ASSERT(read->goal == world.goal);
    RC_ASSERT(read->walls.size() == world.walls.size());
    RC_ASSERT(to_yaml(*read) == to_yaml(world));
  });
}

TEST(Crowd, IsAsFullAsAskedFor) {
  int movers = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CrowdSpec spec;
    spec.seed = seed;
    const WorldFile world = make_crowd(spec);
    EXPECT_GT(world.blocks.size(), 10U) << seed;
    movers += static_cast<int>(world.movers.size());
  }
  EXPECT_EQ(movers, 20 * CrowdSpec().movers);
}

TEST(Crowd, DiffersWithTheSeed) {
  CrowdSpec one;
  CrowdSpec other;
  other.seed = 2;
  EXPECT_EQ(make_crowd(one), make_crowd(one));
  EXPECT_NE(make_crowd(one).blocks, make_crowd(other).blocks);
  EXPECT_NE(make_crowd(one).movers, make_crowd(other).movers);
}

}  // namespace
}  // namespace ctn::navigation::world
