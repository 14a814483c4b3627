#include "world.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <numbers>

#include "crowd.h"

namespace ctn::navigation::world {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr double kQuarter = std::numbers::pi / 2.0;

double in_seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

// 40 m x 40 m, the robot in the middle.
WorldFile hall() {
  WorldFile world;
  world.bounds = {{-20, -20}, {20, 20}};
  add_block(world, {{-20, -20}, {20, -20}, {20, 20}, {-20, 20}});
  world.goal = Point{10, 0};
  return world;
}

// It has its speed within a step, and no noise: for closed forms.
WorldOptions ideal() {
  WorldOptions options;
  options.limits.acceleration = options.limits.turn_acceleration = 1e9;
  options.laser.noise = 0.0;
  options.drift = {0.0, 0.0, 0.0};
  return options;
}

MoverSpec box_on(Point from, Point to, double speed) {
  MoverSpec spec;
  spec.path = {from, to};
  spec.speed = speed;
  spec.length = spec.width = kRobotSide;
  return spec;
}

TEST(World, DrivesAlongAnArc) {
  World world(hall(), ideal());
  world.command(0ms, {0.5, 0.25});
  world.advance(1ms);  // in which the speeds rise
  const Pose start = world.truth();
  world.advance(10'001ms);
  const double radius = 2.0;
  EXPECT_NEAR(world.truth().heading, start.heading + 2.5, 1e-9);
  EXPECT_NEAR(world.truth().x, start.x + radius * (std::sin(start.heading + 2.5) - std::sin(start.heading)), 1e-9);
  EXPECT_NEAR(world.truth().y, start.y - radius * (std::cos(start.heading + 2.5) - std::cos(start.heading)), 1e-9);
  EXPECT_NEAR(world.score().travelled, 5.0 + 0.00025, 1e-9);
}

TEST(World, AcceleratesEvenlyToItsLimit) {
  WorldOptions options = ideal();
  options.limits.acceleration = 0.5;
  World world(hall(), options);
  world.command(0ms, {7.0, 0.0});
  world.advance(1000ms);
  EXPECT_NEAR(world.speed(), 0.5, 1e-9);
  EXPECT_NEAR(world.truth().x, 0.5 * 0.5 * 1.0, 1e-9);
  world.advance(3000ms);
  EXPECT_NEAR(world.speed(), 0.75, 1e-9);
  EXPECT_NEAR(world.truth().x, 0.5 * 0.5 * 1.5 * 1.5 + 1.5 * 0.75, 1e-9);
  world.command(3000ms, {0.0, 0.0});
  world.advance(4000ms);
  EXPECT_NEAR(world.speed(), 0.25, 1e-9);
}

TEST(World, TurnsWithinItsLimit) {
  WorldOptions options = ideal();
  options.limits.turn_acceleration = 3.0;
  World world(hall(), options);
  world.command(0ms, {0.0, -9.0});
  world.advance(500ms);
  EXPECT_NEAR(world.turn_rate(), -1.5, 1e-9);
  EXPECT_NEAR(world.truth().heading, -0.375, 1e-9);
  world.advance(1500ms);
  EXPECT_NEAR(world.turn_rate(), -1.5, 1e-9);
}

TEST(World, ObeysACommandFromTheNextStepOn) {
  World world(hall(), ideal());
  world.command(10'000us, {0.5, 0.0});
  world.command(20'500us, {0.0, 0.0});
  EXPECT_EQ(world.now(), 20ms);
  world.advance(21ms);
  EXPECT_NEAR(world.speed(), 0.5, 1e-12);  // the step from 20 ms on is still the first command's
  world.advance(22ms);
  EXPECT_EQ(world.speed(), 0.0);
  world.command(5ms, {0.25, 0.0});  // too late: from now on
  world.advance(23ms);
  EXPECT_NEAR(world.speed(), 0.25, 1e-12);
}

TEST(World, TakesNoNumberThatIsNone) {
  World world(hall(), ideal());
  world.command(0ms, {std::nan(""), INFINITY});
  world.advance(1s);
  EXPECT_EQ(world.truth(), Pose());
}

TEST(World, ContactWithAWallHasItsInstant) {
  World world(hall(), ideal());
  world.command(0ms, {0.7, 0.0});
  world.advance(60s);
  const Score score = world.score();
  ASSERT_EQ(score.contacts.size(), 1U);
  EXPECT_FALSE(score.contacts[0].mover.has_value());
  EXPECT_EQ(score.contacts[0].speed, 0.7);
  // Half a step is lost while the speed rises. 20 um, what Box2D can tell, are 30 us.
  EXPECT_NEAR(in_seconds(score.contacts[0].at), (20.0 - 0.28) / 0.7 + 0.0005, 4e-5);
  EXPECT_NEAR(world.truth().x, 20.0 - 0.28, 3e-5);
  EXPECT_EQ(world.speed(), 0.0);
}

TEST(World, ACornerTouchesFirst) {
  WorldFile file = hall();
  file.start.heading = kQuarter / 2.0;
  World world(file, ideal());
  world.command(0ms, {0.0, 0.0});
  world.advance(1ms);
  world.command(1ms, {0.5, 0.0});
  world.advance(60s);
  ASSERT_EQ(world.score().contacts.size(), 1U);
  // Along the diagonal of the hall, into its corner: two sides' ends arrive together.
  const double path = (20.0 - 0.28 * std::numbers::sqrt2) * std::numbers::sqrt2;
  EXPECT_NEAR(in_seconds(world.score().contacts[0].at), 0.0015 + path / 0.5, 1e-4);
}

TEST(World, BacksOutOfContactAndCanMeetTheWallAgain) {
  WorldFile file = hall();
  file.start.x = 19.0;
  World world(file, ideal());
  world.command(0ms, {0.5, 0.0});
  world.advance(10s);
  EXPECT_EQ(world.score().contacts.size(), 1U);  // it pushes on, but that is the same one
  world.command(10s, {-0.5, 0.0});
  world.advance(11s);
  EXPECT_NEAR(world.truth().x, 20.0 - 0.28 - 0.5, 1e-3);
  world.command(11s, {0.5, 0.0});
  world.advance(15s);
  EXPECT_EQ(world.score().contacts.size(), 2U);
}

TEST(World, ContactWithAMoverHasItsInstant) {
  WorldFile file = hall();
  file.movers.push_back(box_on({10, 0}, {-10, 0}, 0.5));
  World world(file, ideal());
  world.command(0ms, {0.5, 0.0});
  world.advance(30s);
  const Score score = world.score();
  ASSERT_EQ(score.contacts.size(), 1U);  // it goes through, which is one
  EXPECT_EQ(score.contacts[0].mover, 0U);
  EXPECT_NEAR(in_seconds(score.contacts[0].at), 0.00025 + (10.0 - kRobotSide) / 1.0, 4e-5);
}

TEST(World, AMoverRunsIntoARobotThatStands) {
  WorldFile file = hall();
  MoverSpec disc = box_on({5, 0}, {-5, 0}, 0.5);
  disc.radius = 0.3;
  file.movers.push_back(disc);
  World world(file, ideal());
  world.advance(60s);
  const Score score = world.score();
  ASSERT_EQ(score.contacts.size(), 3U);  // there, back, and there again
  EXPECT_NEAR(in_seconds(score.contacts[0].at), (5.0 - 0.28 - 0.3) / 0.5, 5e-5);
  EXPECT_NEAR(in_seconds(score.contacts[1].at), 20.0 + (5.0 - 0.28 - 0.3) / 0.5, 5e-5);
  EXPECT_EQ(world.truth(), Pose());
}

TEST(World, AMoverIsMetWhileTheRobotPushesAWall) {
  WorldFile file = hall();
  file.start.x = 19.0;
  file.movers.push_back(box_on({19.5, 10}, {19.5, -10}, 0.5));
  World world(file, ideal());
  world.command(0ms, {0.5, 0.0});
  world.advance(25s);
  const Score score = world.score();
  ASSERT_EQ(score.contacts.size(), 2U);
  EXPECT_EQ(score.contacts[1].mover, 0U);
  EXPECT_NEAR(in_seconds(score.contacts[1].at), (10.0 - kRobotSide) / 0.5, 5e-5);
}

TEST(World, MayEndAtTheFirstContact) {
  WorldFile file = hall();
  file.start.x = 19.0;
  WorldOptions options = ideal();
  options.after_contact = AfterContact::kEnd;
  World world(file, options);
  world.command(0ms, {0.5, 0.0});
  world.advance(5s);
  EXPECT_TRUE(world.ended());
  const Pose there = world.truth();
  world.command(5s, {-0.5, 0.0});
  world.advance(8s);
  EXPECT_EQ(world.truth(), there);
  EXPECT_EQ(world.odometry_at(8s).stamp, 8s);  // time goes on
}

TEST(World, NothingIsMissedWhileNothingIsNear) {
  // A fast mover from afar, a wall that is reached at full speed while turning: as found when each step is looked at.
  rc::check([] {
    WorldFile file = hall();
    file.movers.push_back(box_on({*rc::gen::inRange(2, 15) * 1.0, -15}, {1, 15}, *rc::gen::inRange(1, 50) * 0.1));
    World world(file, ideal());
    world.command(0ms, {*rc::gen::inRange(-7, 8) * 0.1, *rc::gen::inRange(-10, 11) * 0.1});
    for (nanoseconds at = 1ms; at <= 20s; at += 1ms) {
      world.advance(at);
      const bool wall = world.scene().to_walls(world.truth(), kRobotSide, 1.0) <= 0.0;
      const bool mover = world.scene().to_mover(0, world.truth(), kRobotSide, in_seconds(at)) <= 0.0;
      RC_ASSERT(!wall);
      if (!mover) continue;
      const std::vector<Contact> contacts = world.score().contacts;
      RC_ASSERT(std::ranges::any_of(contacts, [](const Contact& contact) { return contact.mover.has_value(); }));
      return;
    }
  });
}

TEST(World, SensorsAreAClockOfTheirOwn) {
  World world(hall(), WorldOptions());
  world.command(0ms, {0.5, 0.0});
  const Scan first = world.scan_at(39'999'999ns);
  EXPECT_EQ(first.stamp, 20ms);
  const Scan again = world.scan_at(39'999'999ns);
  EXPECT_EQ(again.stamp, 20ms);
  EXPECT_EQ(again.ranges, first.ranges);
  EXPECT_EQ(world.scan_at(40ms).stamp, 40ms);
  EXPECT_EQ(world.odometry_at(59ms).stamp, 40ms);
  EXPECT_EQ(world.odometry_at(60ms).stamp, 60ms);
  EXPECT_EQ(world.scan_at(20ms).ranges, first.ranges);  // of then, noise and all
}

TEST(World, ScansAreFromWhereTheRobotWas) {
  WorldOptions options = ideal();
  World world(hall(), options);
  world.command(0ms, {0.5, 0.0});
  world.advance(10s);
  const Scan scan = world.scan_at(4s);
  EXPECT_EQ(scan.ranges.size(), 721U);
  EXPECT_NEAR(scan.ranges[360], 20.0 - world.truth_at(4s).x, 2e-5);
  EXPECT_NEAR(world.truth_at(4s).x, 2.0, 0.001);
  EXPECT_NEAR(scan.ranges[0], 20.0, 2e-5);
}

TEST(World, RangesHaveTheNoiseThatTheyShould) {
  WorldOptions options;
  options.laser.noise = 0.02;
  WorldOptions exact = options;
  exact.laser.noise = 0.0;
  World noisy(hall(), options);
  World silent(hall(), exact);
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (nanoseconds at{}; at < 2s; at += kSensorPeriod) {
    const Scan& scan = noisy.scan_at(at);
    const Scan& truth = silent.scan_at(at);
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const double error = static_cast<double>(scan.ranges[i]) - static_cast<double>(truth.ranges[i]);
      sum += error;
      squares += error * error;
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 0.0, 5.0 * 0.02 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(squares / count), 0.02, 0.02 * 5.0 / std::sqrt(2.0 * count));
}

TEST(World, OdometryDoesNotDriftWhileTheRobotStands) {
  World world(hall(), WorldOptions());
  EXPECT_EQ(world.odometry_at(60s).pose, Pose());
}

// After N metres the standard deviation is sqrt(N) times that after one.
TEST(World, OdometryDriftsWithTheWay) {
  constexpr int kRuns = 300;
  std::array<double, 2> along{};
  std::array<double, 2> turned{};
  for (int seed = 1; seed <= kRuns; ++seed) {
    WorldOptions options = ideal();
    options.seed = static_cast<std::uint64_t>(seed);
    options.drift = {0.02, 0.0, 0.01};
    World world(hall(), options);
    world.command(0ms, {0.5, 0.0});
    for (const std::size_t i : {0U, 1U}) {
      const nanoseconds at = i == 0 ? 4s : 16s;  // 2 m and 8 m
      const Pose pose = world.odometry_at(at).pose;
      along[i] += std::pow(pose.x - world.truth_at(at).x, 2) / kRuns;
      turned[i] += std::pow(pose.heading, 2) / kRuns;
    }
  }
  // A variance of 300 draws has a standard error of 8 %; along, the turning takes its part.
  EXPECT_NEAR(turned[0] / (0.01 * 0.01 * 2.0), 1.0, 0.35);
  EXPECT_NEAR(turned[1] / (0.01 * 0.01 * 8.0), 1.0, 0.35);
  EXPECT_NEAR(along[0] / (0.02 * 0.02 * 2.0), 1.0, 0.35);
  EXPECT_NEAR(along[1] / (0.02 * 0.02 * 8.0), 1.0, 0.35);
}

TEST(World, OdometryWithoutDriftIsTheTruth) {
  World world(hall(), ideal());
  world.command(0ms, {0.5, 0.2});
  const Odometry odometry = world.odometry_at(10s);
  EXPECT_NEAR(odometry.pose.x, world.truth().x, 1e-5);
  EXPECT_NEAR(odometry.pose.y, world.truth().y, 1e-5);
  EXPECT_NEAR(odometry.pose.heading, world.truth().heading, 1e-9);
  EXPECT_NEAR(odometry.velocity.linear, 0.5, 1e-9);
  EXPECT_NEAR(odometry.velocity.angular, 0.2, 1e-9);
}

TEST(World, KnowsWhenTheGoalWasReached) {
  World world(hall(), ideal());
  world.command(0ms, {0.5, 0.0});
  world.advance(30s);
  const auto reached = world.score().reached_at;
  ASSERT_TRUE(reached.has_value());
  EXPECT_NEAR(in_seconds(*reached), (10.0 - kGoalRadius) / 0.5, 0.0021);
}

TEST(World, CountsWhatWasSeen) {
  WorldFile file = hall();
  file.goal.reset();
  World world(file, ideal());
  EXPECT_NEAR(world.score().explored, 0.5, 0.02);  // half of the hall is in front of it
  world.command(0ms, {0.0, 1.0});
  world.advance(4s);
  EXPECT_GT(world.score().explored, 0.98);
}

// However often the world is read, the bytes are the same.
TEST(World, DoesNotDependOnTheCallersSteps) {
  rc::check([](std::uint64_t seed) {
    CrowdSpec spec;
    spec.seed = seed;
    const WorldFile file = make_crowd(spec);
    World steady(file, WorldOptions());
    World erratic(file, WorldOptions());
    nanoseconds at{};
    for (int i = 0; i < 10; ++i) {
      const double speed = *rc::gen::inRange(-75, 76) * 0.01;
      const double turn_rate = *rc::gen::inRange(-150, 151) * 0.01;
      steady.command(at, {speed, turn_rate});
      erratic.command(at, {speed, turn_rate});
      const nanoseconds next = at + nanoseconds(*rc::gen::inRange(1, 1'000'000'000));
      while (at < next) {
        at = std::min(next, at + nanoseconds(*rc::gen::inRange(1, 300'000'000)));
        erratic.advance(at);
        if (*rc::gen::arbitrary<bool>()) erratic.scan_at(at);
      }
    }
    const Scan one = steady.scan_at(at);
    const Scan other = erratic.scan_at(at);
    RC_ASSERT(std::memcmp(one.ranges.data(), other.ranges.data(), one.ranges.size() * sizeof(float)) == 0);
    RC_ASSERT(steady.truth() == erratic.truth());
    RC_ASSERT(steady.odometry_at(at).pose == erratic.odometry_at(at).pose);
    RC_ASSERT(steady.score().contacts.size() == erratic.score().contacts.size());
  });
}

TEST(World, TakesFarLessThanRealTime) {
  CrowdSpec spec;
  spec.movers = 12;
  World world(make_crowd(spec), WorldOptions());
  world.command(0ms, {0.3, 0.2});
  const auto begin = std::chrono::steady_clock::now();
  for (nanoseconds at{}; at < 10s; at += kSensorPeriod) world.scan_at(at);
  world.advance(10s);
  const double all = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  World unread(make_crowd(spec), WorldOptions());
  unread.command(0ms, {0.3, 0.2});
  const auto again = std::chrono::steady_clock::now();
  unread.advance(10s);
  const double alone = std::chrono::duration<double>(std::chrono::steady_clock::now() - again).count();
  fmt::print("1 s of the world takes {:.2f} ms with each scan, {:.3f} ms without\n", all * 100.0, alone * 100.0);
  EXPECT_EQ(world.truth(), unread.truth());
}

}  // namespace
}  // namespace ctn::navigation::world
