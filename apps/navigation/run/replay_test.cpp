#include "run/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include <nlohmann/json.hpp>

namespace ctn::navigation::run {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;

world::WorldFile hall_with_mover() {
  world::WorldFile world;
  world.name = "a </script> hall";
  world.bounds = {{0, 0}, {20, 10}};
  world::add_block(world, {{0, 0}, {20, 0}, {20, 10}, {0, 10}});
  world.start = {1, 5, 0};
  world::MoverSpec mover;
  mover.path = {{2.5, 1}, {2.5, 9}};
  mover.speed = 1.0;
  mover.length = mover.width = 0.5;
  world.movers.push_back(mover);
  return world;
}

class ReplayTest : public ::testing::Test {
 protected:
  // Drives straight on for so long; the local map has one obstacle, in its second row.
  void drive_for(std::chrono::nanoseconds time) {
    auto local = std::make_shared<LocalMap>();
    local->stamp = 0ms;
    local->odometry.pose = {1, 5, 0};
    local->frame = {0, 0, 10, 10};
    local->clearance.assign(local->frame.cells(), 1.0F);
    local->clearance[13] = 0.0F;
    local->clearance[77] = 0.0F;
    drive_.move({0ms, {0.5, 0.1}, local});
    auto map = std::make_shared<GlobalMap>();
    map->frame = {0, 0, 4, 2};
    map->cells.assign(8, Cell::kFree);
    map->cells[7] = Cell::kObstacle;
    auto path = std::make_shared<Path>();
    path->points = {{1, 5}, {3.25, 5}};
    drive_.planned({0ms, path, map});
    for (std::chrono::nanoseconds at = kFramePeriod; at <= time; at += kFramePeriod) {
      drive_.advance(at);
      replay_.add(frame_of(drive_));
    }
    outcome_.world = world_.name;
    outcome_.findings = drive_.findings();
  }
  nlohmann::json data() const { return nlohmann::json::parse(replay_.data(outcome_)); }

  world::WorldFile world_ = hall_with_mover();
  Drive drive_{world_, 1};
  Replay replay_{world_, drive_.world().scene().movers(), 60.0};
  Outcome outcome_;
};

TEST_F(ReplayTest, HasAllFrames) {
  drive_for(2s);
  const auto json = data();
  EXPECT_EQ(json["times"].size(), 20U);
  EXPECT_EQ(json["times"][19], 2.0);
  EXPECT_EQ(json["poses"].size(), 60U);
  EXPECT_EQ(json["motions"][0], 500);
  EXPECT_EQ(json["motions"][1], 100);
  EXPECT_EQ(json["positions"].size(), 40U);
  EXPECT_EQ(json["positions"][39], 300) << "1 m/s from y = 1 m, after 2 s";
  EXPECT_EQ(json["movers"][0], nlohmann::json({50, 50, 0, 0}));
}

// Runs of equal cells and distances between obstacles, in base 32; the last digit of a number is one of the upper 32.
TEST_F(ReplayTest, KeepsWhatTheRobotKnowsOnceForEachTimeThatItChanges) {
  drive_for(2s);
  const auto json = data();
  ASSERT_EQ(json["locals"].size(), 1U);
  EXPECT_EQ(json["locals"][0]["cells"], "tAi") << "13, and 64 later";
  EXPECT_EQ(json["locals"][0]["w"], 10);
  EXPECT_THAT(json["locals"][0]["from"], ElementsAre(1.0, 5.0, 0.0));
  ASSERT_EQ(json["maps"].size(), 1U);
  EXPECT_EQ(json["maps"][0]["w"], 2) << "each cell is of 2 x 2";
  EXPECT_EQ(json["maps"][0]["runs"], "hhhi") << "one that is free, one with an obstacle";
  ASSERT_EQ(json["paths"].size(), 1U);
  EXPECT_THAT(json["paths"][0]["points"], ElementsAre(100, 500, 325, 500));
}

TEST_F(ReplayTest, IsOnePageThatNothingInItEnds) {
  drive_for(1s);
  const std::string path = ::testing::TempDir() + "navigation_replay_test.html";
  ASSERT_TRUE(replay_.write(outcome_, path).ok());
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  std::remove(path.c_str());
  const std::string page = text.str();
  EXPECT_EQ(page.find("a </script> hall"), std::string::npos);
  EXPECT_NE(page.find("a <\\/script> hall"), std::string::npos);
  EXPECT_EQ(page.find("@DATA@"), std::string::npos);
  EXPECT_EQ(page.find("http"), std::string::npos) << "it loads nothing";
  EXPECT_FALSE(replay_.write(outcome_, "/nowhere/replay.html").ok());
}

TEST(Replay, WithoutFramesIsAPageAllTheSame) {
  const Replay empty(hall_with_mover(), {}, 60.0);
  const auto json = nlohmann::json::parse(empty.data(Outcome{}));
  EXPECT_TRUE(json["times"].empty());
  EXPECT_TRUE(json["maps"].empty());
}

}  // namespace
}  // namespace ctn::navigation::run
