#include "program/text_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <string>

namespace ctn::program {
namespace {

namespace fs = std::filesystem;

class ReplaceFile : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directory(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  const fs::path folder_ =
      fs::path(::testing::TempDir()) / ::testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(ReplaceFile, LeavesNothingElse) {
  const std::string path = folder_ / "run-1.json";
  const std::string bytes("a\0b\n", 4);
  ASSERT_TRUE(replace_file(path, "what was there, which is longer"));
  ASSERT_TRUE(replace_file(path, bytes));
  EXPECT_EQ(text_of_file(path), bytes);
  EXPECT_EQ(files(), 1U);
}

TEST_F(ReplaceFile, WhatCannotBeWrittenIsAsItWas) {
  EXPECT_FALSE(replace_file(folder_ / "nowhere" / "run-1.json", "text"));
  const fs::path in_the_way = folder_ / "run-1.json";
  fs::create_directories(in_the_way / "a");
  EXPECT_FALSE(replace_file(in_the_way, "text"));
  EXPECT_TRUE(fs::is_directory(in_the_way));
  EXPECT_EQ(files(), 1U);
}

}  // namespace
}  // namespace ctn::program
