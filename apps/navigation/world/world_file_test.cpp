#include "world_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include "grid.h"
#include "scene.h"

namespace ctn::navigation::world {
namespace {

using testing::HasSubstr;

const std::string kRoom =
    "catan_world: 1\n"
    "walls: [[[0, 0], [6, 0], [6, 4], [0, 4], [0, 0]]]\n";

std::string complaint(const std::string& text) {
  const auto read = parse_world(text, "w.yaml", ".");
  if (read) return "nothing";
  EXPECT_EQ(read.error().kind(), ErrorKind::kCaller);
  return read.error().message();
}

TEST(WorldFile, ReadsAllKeys) {
  const auto read = parse_world(
      "catan_world: 1\n"
      "name: a room\n"
      "bounds: [-1, -1, 7, 5]\n"
      "walls: [[[0, 0], [6, 0], [6, 4], [0, 4], [0, 0]]]\n"
      "blocks: [[[2, 2], [3, 2], [3, 3]]]\n"
      "robot: { at: [1, 1], heading: 90 }\n"
      "goal: [5, 3]\n"
      "movers:\n"
      "  - { path: [[4, 1], [5, 1]], speed: 0.5, size: [0.5, 0.3], heading: -45, pause: 2, phase: any }\n"
      "  - { path: [[1, 3], [2, 3.5], [1, 3.5]], speed: 1, radius: 0.2, closed: true, phase: 1.5 }\n",
      "w.yaml", ".");
  ASSERT_TRUE(read.ok()) << read.error().message();
  EXPECT_EQ(read->name, "a room");
  EXPECT_EQ(read->bounds, (Box{{-1, -1}, {7, 5}}));
  EXPECT_EQ(read->walls.size(), 7U);
  EXPECT_EQ(read->blocks.size(), 1U);
  EXPECT_NEAR(read->start.heading, std::numbers::pi / 2.0, 1e-12);
  EXPECT_EQ(read->goal, (Point{5, 3}));
  ASSERT_EQ(read->movers.size(), 2U);
  EXPECT_EQ(read->movers[0].width, 0.3);
  EXPECT_EQ(read->movers[0].pause, 2.0);
  EXPECT_FALSE(read->movers[0].phase.has_value());
  EXPECT_EQ(read->movers[1].radius, 0.2);
  EXPECT_TRUE(read->movers[1].closed);
  EXPECT_EQ(read->movers[1].phase, 1.5);
}

TEST(WorldFile, BoundsAreThoseOfTheWallsUnlessGiven) {
  const auto read = parse_world(kRoom + "robot: { at: [1, 1] }\nexplore: true\n", "w.yaml", ".");
  ASSERT_TRUE(read.ok()) << read.error().message();
  EXPECT_EQ(read->bounds, (Box{{0, 0}, {6, 4}}));
  EXPECT_TRUE(read->explore());
}

TEST(WorldFile, TellsAllMistakesAtOnceEachWithItsPlace) {
  const std::string told = complaint(
      "catan_world: 1\n"
      "walls: [[[0, 0], [6, zero]]]\n"
      "robt: { at: [1, 1] }\n"
      "goal: [5, 3, 1]\n"
      "movers:\n"
      "  - { path: [[4, 1]], speed: -1 }\n");
  EXPECT_THAT(told, HasSubstr("w.yaml:2:22: walls[0][1]: this should be a number, not 'zero'"));
  EXPECT_THAT(told, HasSubstr("w.yaml:3:1: robt: there is no such key"));
  EXPECT_THAT(told, HasSubstr("robot: where the robot starts is missing"));
  EXPECT_THAT(told, HasSubstr("w.yaml:4:7: goal: this should be a point"));
  EXPECT_THAT(told, HasSubstr("w.yaml:6:13: movers[0].path: this should be a list of 2 points or more"));
  EXPECT_THAT(told, HasSubstr("w.yaml:6:30: movers[0].speed: -1 is out of range"));
}

TEST(WorldFile, RefusesWhatIsNoWorld) {
  EXPECT_THAT(complaint(""), HasSubstr("this should be a map"));
  EXPECT_THAT(complaint("catan_world: [1\n"), HasSubstr("this is not YAML"));
  EXPECT_THAT(complaint("robot: { at: [1, 1] }\nexplore: true\n"), HasSubstr("begin with catan_world: 1"));
  EXPECT_THAT(complaint("catan_world: 2\n"), HasSubstr("2 is out of range"));
  EXPECT_THAT(complaint("catan_world: 1\nrobot: { at: [1, 1] }\nexplore: true\n"), HasSubstr("has no walls"));
  EXPECT_THAT(complaint(kRoom + "robot: { at: [1, 1] }\n"), HasSubstr("write goal: [x, y] or explore: true"));
  EXPECT_THAT(complaint(kRoom + "robot: { at: [1, 1] }\ngoal: [5, 3]\nexplore: true\n"), HasSubstr("has no goal"));
  EXPECT_THAT(complaint(kRoom + "name: a\nname: b\n"), HasSubstr("w.yaml:4:1: name: this key is here twice"));
  EXPECT_THAT(complaint(kRoom + "robot: { at: [.nan, 1] }\nexplore: true\n"), HasSubstr("should be a number"));
}

TEST(WorldFile, RefusesWhatDoesNotFit) {
  EXPECT_THAT(complaint(kRoom + "robot: { at: [7, 1] }\nexplore: true\n"),
              HasSubstr("w.yaml:3:14: robot.at: [7, 1] is outside the world; the world is from [0, 0] to [6, 4]"));
  EXPECT_THAT(complaint(kRoom + "robot: { at: [0.2, 1] }\nexplore: true\n"), HasSubstr("the robot starts in a wall"));
  EXPECT_THAT(complaint(kRoom + "robot: { at: [1, 1] }\ngoal: [5, 9]\n"), HasSubstr("goal: [5, 9] is outside"));
  EXPECT_THAT(complaint(kRoom + "robot: { at: [1, 1] }\ngoal: [5.9, 3]\n"), HasSubstr("the robot cannot get there"));
  EXPECT_THAT(complaint(kRoom + "bounds: [0, 0, 5, 4]\nrobot: { at: [1, 1] }\nexplore: true\n"),
              HasSubstr("there are walls outside these bounds"));
  const std::string with_robot = kRoom + "robot: { at: [1, 1] }\nexplore: true\n";
  EXPECT_THAT(complaint(with_robot + "movers: [{ path: [[1, 1.2], [5, 1]], speed: 1 }]\n"),
              HasSubstr("w.yaml:5:10: movers[0]: this mover may be where the robot starts"));
  EXPECT_THAT(complaint(with_robot + "movers: [{ path: [[5, 1.2], [1, 1.3]], speed: 1 }]\n"), "nothing");
  EXPECT_THAT(complaint(with_robot + "movers: [{ path: [[5, 1.2], [1, 1.3]], speed: 1, phase: any }]\n"),
              HasSubstr("this mover may be where the robot starts"));
  EXPECT_THAT(complaint(with_robot + "movers: [{ path: [[5, 1.2], [1, 9]], speed: 1 }]\n"), HasSubstr("outside"));
}

TEST(WorldFile, SaysWhatFileCannotBeRead) {
  const auto read = read_world("/nowhere/w.yaml");
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().kind(), ErrorKind::kEnvironment);
  EXPECT_THAT(read.error().message(), HasSubstr("/nowhere/w.yaml"));
}

TEST(WorldFile, TakesWallsFromAnImage) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "navigation_world_image";
  std::filesystem::create_directories(folder);
  // 8 x 6 pixels of half a metre: dark all round, and a dark 1 x 2 in the middle.
  std::ofstream(folder / "room.pgm") << "P2\n8 6\n255\n"
                                        "0 0 0 0 0 0 0 0\n"
                                        "0 255 255 255 255 255 255 0\n"
                                        "0 255 255 0 255 255 255 0\n"
                                        "0 255 255 0 255 255 255 0\n"
                                        "0 255 255 255 255 255 255 0\n"
                                        "0 0 0 0 0 0 0 0\n";
  const std::string text =
      "catan_world: 1\nimage: { file: room.pgm, metres_per_pixel: 0.5, origin: [-1, 2] }\n"
      "robot: { at: [0.0, 3.5] }\nexplore: true\n";
  const auto read = parse_world(text, "w.yaml", folder.string());
  ASSERT_TRUE(read.ok()) << read.error().message();
  EXPECT_EQ(read->bounds, (Box{{-1, 2}, {3, 5}}));
  EXPECT_EQ(read->walls.size(), 12U);  // three rectangles: outside, inside, and the one in the middle
  const Scene scene(*read, 1);
  std::vector<float> ray(1);
  scene.cast(read->start, 0.0, 1.0, 30.0, ray);
  EXPECT_NEAR(ray[0], 0.5, 1e-6);
  scene.cast({0, 2.75, 0}, 0.0, 1.0, 30.0, ray);
  EXPECT_NEAR(ray[0], 2.5, 1e-6);
  std::filesystem::remove_all(folder);
  EXPECT_THAT(complaint("catan_world: 1\nimage: { file: none.png, metres_per_pixel: 1 }\nrobot: { at: [0, 0] }\n"),
              HasSubstr("w.yaml:2:16: image.file: there is no image none.png"));
}

TEST(WorldFile, TheCaseStudysAreRight) {
  const auto small = read_world(std::string(NAVIGATION_WORLDS) + "/map1.yaml");
  ASSERT_TRUE(small.ok()) << small.error().message();
  EXPECT_EQ(small->bounds, (Box{{0, 0}, {16, 12}}));
  EXPECT_EQ(small->movers.size(), 3U);
  EXPECT_TRUE(Grid(*small, 0.1).path_exists(position(small->start), *small->goal, kRobotSide));
  const auto large = read_world(std::string(NAVIGATION_WORLDS) + "/map2.yaml");
  ASSERT_TRUE(large.ok()) << large.error().message();
  EXPECT_EQ(large->bounds, (Box{{0, 0}, {46, 26}}));
  EXPECT_TRUE(large->explore());
  // The robot can enter each of the twelve rooms.
  const Grid grid(*large, 0.1);
  for (const double x : {4.0, 11.5, 19.0, 25.0, 36.5, 44.0}) {
    EXPECT_TRUE(grid.path_exists(position(large->start), {x, 7.0}, 0.45)) << x;
    EXPECT_TRUE(grid.path_exists(position(large->start), {x, 19.0}, 0.45)) << x;
  }
}

}  // namespace
}  // namespace ctn::navigation::world
