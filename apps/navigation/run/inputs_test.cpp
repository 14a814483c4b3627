#include "run/inputs.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace ctn::navigation::run {
namespace {

class InputsTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }

  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / ("navigation_inputs_" + std::to_string(getpid()));
};

// A batch went on with another image behind the same world file.
TEST_F(InputsTest, AWorldsImageIsOneOfThem) {
  Options options;
  options.world_file = write("world.yaml", "catan_world: 1\nimage: { file: room.pgm, metres_per_pixel: 0.5 }\n");
  write("room.pgm", "one");
  const auto before = inputs_of(options, nullptr);
  ASSERT_TRUE(before.contains("image"));
  EXPECT_EQ(inputs_of(options, nullptr), before);
  write("room.pgm", "another");
  const auto after = inputs_of(options, nullptr);
  EXPECT_NE(after.at("image"), before.at("image"));
  EXPECT_EQ(after.at("world"), before.at("world"));
}

TEST_F(InputsTest, AWorldWithoutAnImageHasNone) {
  Options options;
  for (const char* text : {"catan_world: 1\n", "image: none\n", "image: [1\n", ""}) {
    options.world_file = write("world.yaml", text);
    EXPECT_FALSE(inputs_of(options, nullptr).contains("image")) << text;
  }
}

}  // namespace
}  // namespace ctn::navigation::run
