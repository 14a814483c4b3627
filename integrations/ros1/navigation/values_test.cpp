#include "ros1/navigation/values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "ros1/navigation/testing/over_the_wire.h"

namespace ctn::navigation::ros1 {
namespace {

using namespace std::chrono_literals;

void expect_same(const Odometry& a, const Odometry& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.pose, b.pose);
  EXPECT_EQ(a.velocity, b.velocity);
}

void expect_same_scan(const Scan& a, const Scan& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.field, b.field);
  EXPECT_EQ(a.max_range, b.max_range);
  EXPECT_EQ(a.ranges, b.ranges);
}

const Odometry kOdometry{1'234'567'890'123ns, {1.0 / 3.0, -7.5, 9.0}, {0.75, -0.1}};

CleanScan some_scan(std::chrono::nanoseconds stamp) {
  CleanScan scan;
  scan.stamp = stamp;
  scan.ranges = {1.5F, std::numeric_limits<float>::infinity(), 0.1F};
  scan.odometry = kOdometry;
  scan.points = {{0.1, 0.2}, {-1.0 / 3.0, 4.0}};
  return scan;
}

Localization some_localization() {
  Localization localization;
  localization.stamp = 60ms;
  localization.correction = {0.1, 0.2, 0.3};
  localization.loops = 3;
  localization.newest = std::make_shared<const CleanScan>(some_scan(60ms));
  localization.keyframes = std::make_shared<const std::vector<Keyframe>>(
      std::vector<Keyframe>{{{1, 2, 3}, std::make_shared<const CleanScan>(some_scan(20ms)), true},
                            {{4, 5, 6}, std::make_shared<const CleanScan>(some_scan(40ms)), false}});
  return localization;
}

TEST(Values, ScansAreWhatTheyWere) {
  const run::Reading reading{some_scan(20ms), kOdometry};
  const run::Reading read = over_the_wire(reading);
  expect_same_scan(read.scan, reading.scan);
  expect_same(read.odometry, kOdometry);

  const CleanScan clean = over_the_wire(some_scan(20ms));
  expect_same_scan(clean, some_scan(20ms));
  expect_same(clean.odometry, kOdometry);
  EXPECT_EQ(clean.points, some_scan(20ms).points);
}

TEST(Values, ALocalMapIsWhatItWas) {
  LocalMap map;
  map.stamp = 80ms;
  map.odometry = kOdometry;
  map.frame = {-3, 4, 2, 3};
  map.clearance = {0, 1, 2, 3, 4, 5};
  map.moving = {{{1, 2}, 0.3, {0.4, 0.5}, {0, 1}, 0.6, std::numeric_limits<double>::infinity(), 2.0, 0.1}};
  const Surroundings read = over_the_wire(surroundings_of(map, nullptr));
  ASSERT_TRUE(read.map);
  EXPECT_EQ(read.map->stamp, 80ms);
  expect_same(read.map->odometry, kOdometry);
  expect_same(read.odometry, kOdometry);
  EXPECT_EQ(read.map->frame, map.frame);
  EXPECT_EQ(read.map->clearance, map.clearance);
  EXPECT_TRUE(read.map->static_clearance.empty()) << "nothing moves";
  ASSERT_EQ(read.map->moving.size(), 1U);
  const MovingObstacle& moving = read.map->moving[0];
  EXPECT_EQ(moving.centre, (Point{1, 2}));
  EXPECT_EQ(moving.velocity, (Point{0.4, 0.5}));
  EXPECT_EQ(moving.course, (Point{0, 1}));
  EXPECT_EQ(moving.ahead, std::numeric_limits<double>::infinity());
  EXPECT_EQ((std::array{moving.radius, moving.pace, moving.behind, moving.unseen}), (std::array{0.3, 0.6, 2.0, 0.1}));
  EXPECT_FALSE(over_the_wire(Surroundings{}).map);
}

// GP and NC look for the robot relative to a keyframe.
TEST(Values, AFixHasTheNewestScanAndWhereKeyframesAre) {
  const Fix read = over_the_wire(Fix{some_localization(), kOdometry});
  const Localization& localization = read.localization;
  EXPECT_EQ(localization.stamp, 60ms);
  EXPECT_EQ(localization.correction, (Pose{0.1, 0.2, 0.3}));
  EXPECT_EQ(localization.loops, 3U);
  ASSERT_TRUE(localization.newest);
  EXPECT_EQ(localization.newest->points, some_scan(60ms).points);
  ASSERT_EQ(localization.keyframes->size(), 2U);
  const Anchor anchor{1, {1.5, 2, 3}};
  EXPECT_EQ(localization.pose_on(anchor, kOdometry), some_localization().pose_on(anchor, kOdometry));

  Localization without;
  without.keyframes = std::make_shared<const std::vector<Keyframe>>();
  EXPECT_FALSE(over_the_wire(Fix{without, {}}).localization.newest);
}

TEST(Values, KeyframesHaveTheirScans) {
  const Localization whole = some_localization();
  const Localization read = over_the_wire(KeyframesMessage{whole}).localization;
  ASSERT_EQ(read.keyframes->size(), 2U);
  for (std::size_t index = 0; index < 2; ++index) {
    const Keyframe& expected = (*whole.keyframes)[index];
    const Keyframe& keyframe = (*read.keyframes)[index];
    EXPECT_EQ(keyframe.pose, expected.pose);
    EXPECT_EQ(keyframe.outdated, expected.outdated);
    expect_same_scan(*keyframe.scan, *expected.scan);
  }
  // The same map comes of it.
  EXPECT_EQ(GlobalMapper().run(read).map->cells, GlobalMapper().run(whole).map->cells);
}

TEST(Values, MapPathAndCommandAreWhatTheyWere) {
  GlobalMap map;
  map.stamp = 1s;
  map.frame = {1, -2, 2, 2};
  map.cells = {Cell::kFree, Cell::kObstacle, Cell::kUnknown, Cell::kFree};
  map.anchor = {7, {1, 2, 3}};
  const GlobalMap map_read = over_the_wire(map);
  EXPECT_EQ(map_read.stamp, 1s);
  EXPECT_EQ(map_read.frame, map.frame);
  EXPECT_EQ(map_read.cells, map.cells);
  EXPECT_EQ(map_read.anchor.keyframes, 7U);
  EXPECT_EQ(map_read.anchor.newest, (Pose{1, 2, 3}));

  const Path path{Path::Outcome::kNoWay, 2s, {{1, 2}, {3, 4}}, true, {7, {1, 2, 3}}};
  const Path path_read = over_the_wire(path);
  EXPECT_EQ(path_read.outcome, Path::Outcome::kNoWay);
  EXPECT_EQ(path_read.stamp, 2s);
  EXPECT_EQ(path_read.points, path.points);
  EXPECT_TRUE(path_read.to_goal);
  EXPECT_EQ(path_read.anchor.newest, (Pose{1, 2, 3}));

  const Command command{3s, false, true, true, {1, 2}, {{3, 4}, {5, 6}}, 7.5};
  const Command command_read = over_the_wire(command);
  EXPECT_EQ(command_read.stamp, 3s);
  EXPECT_FALSE(command_read.stop);
  EXPECT_TRUE(command_read.look_around);
  EXPECT_TRUE(command_read.arrived);
  EXPECT_EQ(command_read.carrot, (Point{1, 2}));
  EXPECT_EQ(command_read.beyond, command.beyond);
  EXPECT_EQ(command_read.distance_left, 7.5);
}

TEST(Values, WhatIsCutOffIsRefused) {
  const ros::SerializedMessage whole = ros::serialization::serializeMessage(over_the_wire(some_scan(20ms)));
  const auto before = static_cast<std::uint32_t>(whole.message_start - whole.buf.get());
  for (std::uint32_t length = 0; length < whole.num_bytes - before; length += 3) {
    ros::serialization::IStream stream(whole.message_start, length);
    CleanScan read;
    EXPECT_THROW(ros::serialization::deserialize(stream, read), ros::serialization::StreamOverrunException) << length;
  }
}

TEST(Values, ProgramsOfOtherDefinitionsDoNotConnect) {
  namespace traits = ros::message_traits;
  EXPECT_EQ(std::string(traits::md5sum<Path>()).size(), 32U);
  EXPECT_STRNE(traits::md5sum<Path>(), traits::md5sum<Command>());
  EXPECT_STREQ(traits::datatype<Fix>(), "catan_navigation/Localization");
  EXPECT_THAT(traits::definition<GlobalMap>(), testing::HasSubstr("\nMSG: catan_navigation/Pose2\n"));
}

}  // namespace
}  // namespace ctn::navigation::ros1
