// What LM knows of things that move, in worlds with exact geometry.
#include "motion_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "local_mapper.h"
#include "scan_filter.h"
#include "testing/analytic_world.h"

namespace ctn::navigation {
namespace {

using testing::AnalyticWorld;
using testing::Errors;
using testing::Wall;

constexpr double kScanPeriod = 0.02;
constexpr double kBoxSide = 0.56;

void add_disc(std::vector<Wall>& walls, Point centre, double radius) {
  constexpr int kSides = 40;
  const auto corner = [&](int i) {
    const double angle = 2.0 * std::numbers::pi * i / kSides;
    return centre + Point{std::cos(angle), std::sin(angle)} * radius;
  };
  for (int i = 0; i < kSides; ++i) walls.push_back({corner(i), corner(i + 1)});
}

void add_square(std::vector<Wall>& walls, Point centre) {
  testing::add_box(walls, centre.x - kBoxSide / 2, centre.y - kBoxSide / 2, centre.x + kBoxSide / 2,
                   centre.y + kBoxSide / 2);
}

// A robot that drives at a velocity among walls, and one thing more that is put somewhere before each scan.
class Watching {
 public:
  Watching(std::vector<Wall> walls, const Pose& start, const Errors& errors = {}, double period = kScanPeriod)
      : still_(std::move(walls)), world_(still_, start, errors), period_(period) {}

  template <typename Place>  // place(walls, seconds) adds the thing
  const LocalMap& watch(double seconds, const Velocity& velocity, const Place& place) {
    for (const double until = world_.time() + seconds; world_.time() < until - 1e-9;) {
      world_.advance(period_, velocity);
      world_.walls() = still_;
      place(world_.walls(), world_.time());
      map_ = mapper_.run(*ScanFilter{}.run(world_.scan(), world_.odometry()).scan).map;
    }
    return map_;
  }
  const LocalMap& watch(double seconds, const Velocity& velocity) {
    return watch(seconds, velocity, [](std::vector<Wall>&, double) {});
  }

  AnalyticWorld& world() { return world_; }
  const LocalMap& map() const { return map_; }

 private:
  std::vector<Wall> still_;
  AnalyticWorld world_;
  double period_;
  LocalMapper mapper_;
  LocalMap map_;
};

const std::vector<Wall> kHall = [] {
  std::vector<Wall> walls;
  testing::add_box(walls, -4.0, -4.0, 4.0, 4.0);
  return walls;
}();

void expect_seen(const LocalMap& map, Point centre, double radius, Point velocity) {
  ASSERT_EQ(map.moving.size(), 1U);
  const MovingObstacle& seen = map.moving.front();
  EXPECT_NEAR(seen.centre.x, centre.x, 0.08);
  EXPECT_NEAR(seen.centre.y, centre.y, 0.08);
  EXPECT_NEAR(seen.velocity.x, velocity.x, 0.15);
  EXPECT_NEAR(seen.velocity.y, velocity.y, 0.15);
  EXPECT_NEAR(seen.radius, radius, 0.06);
  EXPECT_NEAR(seen.pace, std::hypot(velocity.x, velocity.y), 0.12);
}

TEST(MotionTracker, SeesADiscPassWhileTheRobotDrivesAndTurns) {
  const Point velocity{-0.1, 0.5};
  const auto disc_at = [&](double seconds) { return Point{2.2, -1.2} + velocity * seconds; };
  Watching watching(kHall, {-0.5, 0.0, 0.0}, {.range = 0.01});
  for (int i = 0; i < 30; ++i) {
    const LocalMap& map = watching.watch(0.1, {0.3, i % 10 < 5 ? 0.5 : -0.5},
                                         [&](auto& walls, double seconds) { add_disc(walls, disc_at(seconds), 0.3); });
    if (i < 8) continue;
    SCOPED_TRACE(i);
    expect_seen(map, disc_at(watching.world().time()), 0.3, velocity);
  }
}

TEST(MotionTracker, SeesABoxPassOnAllItsSides) {
  const Point velocity{0.0, 0.5};
  const auto box_at = [&](double seconds) { return Point{1.5, -1.5} + velocity * seconds; };
  Watching watching(kHall, {0.0, 0.0, 0.0}, {.range = 0.01});
  for (int i = 0; i < 50; ++i) {
    const LocalMap& map =
        watching.watch(0.1, {}, [&](auto& walls, double seconds) { add_square(walls, box_at(seconds)); });
    if (i < 8) continue;
    SCOPED_TRACE(i);
    expect_seen(map, box_at(watching.world().time()), kBoxSide / std::numbers::sqrt2, velocity);
  }
}

TEST(MotionTracker, TakesNoWallForAMovingThing) {
  for (const double period : {0.02, 0.2}) {
    Watching watching(testing::two_rooms(), {2.5, 3.0, 0.0}, {.range = 0.01, .turn = 0.02, .turn_noise = 0.02}, period);
    for (int i = 0; i < 60; ++i) {
      const LocalMap& map = watching.watch(0.2, {0.4, i % 20 < 10 ? 0.5 : 1.4});
      EXPECT_TRUE(map.moving.empty()) << "every " << period << " s, at " << watching.world().time();
    }
    EXPECT_FALSE(watching.world().touched());
  }
}

TEST(MotionTracker, GoesOnBehindWhatHidesIt) {
  std::vector<Wall> walls = kHall;
  walls.push_back({{1.0, -0.3}, {1.0, 0.3}});  // hides what is from -0.6 to 0.6 at x = 2
  Watching watching(walls, {0.0, 0.0, 0.0}, {.range = 0.01});
  const Point velocity{0.0, 0.6};
  const auto box_at = [&](double seconds) { return Point{2.3, -1.9} + velocity * seconds; };
  for (int i = 0; i < 50; ++i) {
    const LocalMap& map = watching.watch(0.1, {}, [&](auto& all, double seconds) { add_square(all, box_at(seconds)); });
    if (i < 8) continue;
    SCOPED_TRACE(i);
    ASSERT_EQ(map.moving.size(), 1U);
    EXPECT_LT(distance(map.moving.front().centre, box_at(watching.world().time())), 0.2);
    EXPECT_NEAR(map.moving.front().velocity.y, velocity.y, 0.35);
    EXPECT_NEAR(map.moving.front().velocity.x, 0.0, 0.35);
  }
}

// The robot turns so that the box, which it has seen, is partly beyond the edge of the laser's view, on either side.
TEST(MotionTracker, SeesABoxAtTheEdgeOfTheView) {
  for (const double side : {-1.0, 1.0}) {
    for (const double speed : {-0.25, 0.25}) {
      Watching watching(kHall, {0.0, 0.0, 0.0}, {.range = 0.01});
      const auto box_at = [&](double seconds) { return Point{1.2 + speed * (seconds - 2.0), side * 0.8}; };
      const auto place = [&](auto& walls, double seconds) { add_square(walls, box_at(seconds)); };
      watching.watch(1.2, {}, place);
      for (int i = 0; i < 16; ++i) {
        const LocalMap& map = watching.watch(0.1, {0.0, -side * 0.8}, place);
        SCOPED_TRACE(i);
        ASSERT_EQ(map.moving.size(), 1U);
        EXPECT_LT(distance(map.moving.front().centre, box_at(watching.world().time())), 0.2) << side << " " << speed;
        if (i >= 8) continue;  // hardly any of it is seen: its place is known, but not how fast it is
        EXPECT_NEAR(map.moving.front().velocity.x, speed, 0.25) << side << " " << speed;
        EXPECT_NEAR(map.moving.front().velocity.y, 0.0, 0.25) << side << " " << speed;
      }
    }
  }
}

TEST(MotionTracker, RemembersWhatHasStoppedUntilItIsLikeAWall) {
  Watching watching(kHall, {0.0, 0.0, 0.0}, {.range = 0.01});
  const auto box_at = [](double seconds) { return Point{1.5, -1.5 + 0.5 * std::min(seconds, 3.0)}; };
  const auto place = [&](auto& walls, double seconds) { add_square(walls, box_at(seconds)); };
  watching.watch(3.0, {}, place);
  const LocalMap& map = watching.watch(0.8, {}, place);
  ASSERT_EQ(map.moving.size(), 1U);
  EXPECT_FALSE(map.moving.front().moves());
  EXPECT_NEAR(map.moving.front().pace, 0.5, 0.12);
  EXPECT_NEAR(std::abs(map.moving.front().course.y), 1.0, 0.05);
  EXPECT_TRUE(map.static_clearance.empty());
  watching.watch(8.0, {}, place);
  EXPECT_TRUE(watching.map().moving.empty());
}

// It goes from 1.2 m on the right to 0.6 m on the left, waits, and comes back.
TEST(MotionTracker, KnowsWhereItsCourseEndsOnceItTurnedBackThere) {
  constexpr double kSpeed = 0.6;
  constexpr double kPause = 1.0;
  constexpr double kTurns = 3.0;  // seconds until it is at the left end
  const auto box_at = [&](double seconds) {
    const double back = std::max(0.0, seconds - kTurns - kPause);
    return Point{1.5, -1.2 + kSpeed * (std::min(seconds, kTurns) - back)};
  };
  Watching watching(kHall, {0.0, 0.0, 0.0}, {.range = 0.01});
  const auto place = [&](auto& walls, double seconds) { add_square(walls, box_at(seconds)); };
  watching.watch(kTurns - 0.2, {}, place);
  ASSERT_EQ(watching.map().moving.size(), 1U);
  EXPECT_TRUE(std::isinf(watching.map().moving.front().ahead));
  EXPECT_TRUE(std::isinf(watching.map().moving.front().behind));
  watching.watch(0.8, {}, place);
  ASSERT_EQ(watching.map().moving.size(), 1U);
  EXPECT_FALSE(watching.map().moving.front().moves());
  EXPECT_TRUE(std::isinf(watching.map().moving.front().ahead)) << "it has stopped, and may still go on";
  watching.watch(1.9, {}, place);
  ASSERT_EQ(watching.map().moving.size(), 1U);
  const MovingObstacle& thing = watching.map().moving.front();
  EXPECT_LT(thing.course.y, -0.9);
  EXPECT_TRUE(std::isinf(thing.ahead));
  EXPECT_NEAR(thing.behind, 0.6 - box_at(watching.world().time()).y, 0.12);
}

// It brakes at 1 m/s^2, stands, and goes on.
TEST(MotionTracker, KnowsTheCourseOfWhatSlowsDown) {
  Watching watching(kHall, {0.0, 0.0, 0.0}, {.range = 0.01});
  const auto place = [](auto& walls, double seconds) {
    const double braking = std::clamp(seconds - 2.5, 0.0, 0.5);
    add_square(walls, {1.6, -1.0 + 0.5 * std::min(seconds, 2.5) + 0.5 * braking - 0.5 * braking * braking});
  };
  watching.watch(2.0, {}, place);
  for (int i = 0; i < 100; ++i) {
    watching.watch(kScanPeriod, {}, place);
    ASSERT_EQ(watching.map().moving.size(), 1U);
    EXPECT_GT(watching.map().moving.front().course.y, 0.99) << watching.world().time() << " s";
  }
  EXPECT_FALSE(watching.map().moving.front().moves());
}

// The robot turns its back to a box that comes, and does not see it for 4 s.
TEST(MotionTracker, ForgetsWhatIsNotSeenOnlyOnceItMustHavePassed) {
  Watching watching(kHall, {0.0, 0.0, 0.0}, {.range = 0.01});
  const auto box_at = [](double seconds) { return Point{3.6 - 0.5 * seconds, 0.9}; };
  const auto place = [&](auto& walls, double seconds) { add_square(walls, box_at(seconds)); };
  watching.watch(1.5, {}, place);
  watching.watch(1.9, {0.0, -1.5}, place);
  watching.watch(3.3, {}, place);
  ASSERT_EQ(watching.map().moving.size(), 1U);
  EXPECT_GT(watching.map().moving.front().unseen, MotionTracker::kUnseen);
  EXPECT_LT(distance(watching.map().moving.front().centre, box_at(watching.world().time())), 0.5);
  watching.watch(2.0, {});
  EXPECT_TRUE(watching.map().moving.empty());
}

TEST(MotionTracker, ForgetsWhatIsGone) {
  Watching watching(kHall, {0.0, 0.0, 0.0}, {.range = 0.01});
  watching.watch(2.0, {}, [](auto& walls, double seconds) { add_square(walls, {1.5, -1.0 + 0.5 * seconds}); });
  ASSERT_EQ(watching.map().moving.size(), 1U);
  watching.watch(0.5, {});
  EXPECT_TRUE(watching.map().moving.empty());
}

TEST(LocalMapper, GivesTheDistancesToWhatDoesNotMove) {
  Watching watching(kHall, {0.0, 0.0, 0.0}, {.range = 0.01});
  const auto place = [](auto& walls, double seconds) { add_square(walls, {1.5, -1.0 + 0.5 * seconds}); };
  const LocalMap& map = watching.watch(2.0, {}, place);
  const Point on_its_face{1.22, 0.0};
  EXPECT_LT(map.clearance_at(on_its_face), 0.05);
  EXPECT_GT(map.static_clearance_at(on_its_face), 0.2);
  EXPECT_NEAR(map.static_clearance_at({0.0, 2.8}), map.clearance_at({0.0, 2.8}), 1e-6);
}

}  // namespace
}  // namespace ctn::navigation
