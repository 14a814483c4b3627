#include "picture.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "crowd.h"

namespace ctn::navigation::world {
namespace {

TEST(Picture, IsWritten) {
  const auto path = std::filesystem::path(testing::TempDir()) / "navigation_world.png";
  World world(make_crowd({}), WorldOptions());
  world.advance(std::chrono::seconds(1));
  ASSERT_TRUE(write_picture(world, path.string()).ok());
  EXPECT_GT(std::filesystem::file_size(path), 5000U);
  std::filesystem::remove(path);
}

TEST(Picture, SaysWhyItCannotBe) {
  World world(make_crowd({}), WorldOptions());
  const Status nowhere = write_picture(world, "/nowhere/a.png");
  ASSERT_FALSE(nowhere.ok());
  EXPECT_EQ(nowhere.error().kind(), ErrorKind::kEnvironment);
  const Status unknown = write_picture(world, "a.world");
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().kind(), ErrorKind::kCaller);
}

}  // namespace
}  // namespace ctn::navigation::world
