#include "os/linux/whole_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace ctn::os {
namespace {

using Existing = WholeFile::Existing;
using Files = std::vector<std::unique_ptr<WholeFile>>;

class WholeFileTest : public ::testing::Test {
 protected:
  WholeFileTest() {
    std::string pattern = (std::filesystem::temp_directory_path() / "catan-whole-XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
  }
  ~WholeFileTest() override { std::filesystem::remove_all(folder); }

  std::string path(const std::string& name) const { return folder + "/" + name; }
  std::string content(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::unique_ptr<WholeFile> begin(const std::string& name, const std::string& text, Existing existing) const {
    Result<std::unique_ptr<WholeFile>> file = WholeFile::create(path(name), existing);
    EXPECT_TRUE(file.ok()) << file.error().message();
    EXPECT_TRUE((*file)->write(text).ok());
    return std::move(*file);
  }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) all.push_back(entry.path().filename());
    return all;
  }

  std::string folder;
};

TEST_F(WholeFileTest, HasItsNameWhenItIsFinished) {
  Files files;
  files.push_back(begin("a", "half", Existing::kStays));
  EXPECT_FALSE(std::filesystem::exists(path("a")));
  EXPECT_TRUE(files.front()->write(" and half").ok());
  EXPECT_TRUE(WholeFile::finish(files).ok());
  files.clear();
  EXPECT_EQ(content("a"), "half and half");
  EXPECT_EQ(names(), std::vector<std::string>{"a"});
}

TEST_F(WholeFileTest, LeavesNothingWhereItIsGivenUp) {
  begin("a", "half", Existing::kStays).reset();
  EXPECT_EQ(names(), std::vector<std::string>{});
}

TEST_F(WholeFileTest, WhatAKilledProgramLeftIsTakenOver) {
  std::ofstream(path("a.unfinished")) << "much more than there will be";
  Files files;
  files.push_back(begin("a", "mine", Existing::kStays));
  EXPECT_TRUE(WholeFile::finish(files).ok());
  EXPECT_EQ(content("a"), "mine");
  EXPECT_FALSE(std::filesystem::exists(path("a.unfinished")));
}

TEST_F(WholeFileTest, OneAtATimeWritesIt) {
  Files files;
  files.push_back(begin("a", "first", Existing::kIsReplaced));
  const auto second = WholeFile::create(path("a"), Existing::kIsReplaced);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().kind(), ErrorKind::kCaller);
  EXPECT_NE(second.error().message().find("another program"), std::string::npos);
  EXPECT_TRUE(WholeFile::finish(files).ok());
  // Its lock is that of the file under the final name now, and keeps nobody from writing the next one.
  EXPECT_TRUE(replace_file(path("a"), "second").ok());
  EXPECT_EQ(content("a"), "second");
}

TEST_F(WholeFileTest, WhatIsThereStays) {
  std::ofstream(path("a")) << "there";
  const auto refused = WholeFile::create(path("a"), Existing::kStays);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(content("a"), "there");
}

TEST_F(WholeFileTest, AllOrNone) {
  Files files;
  for (const char* name : {"a", "b", "c"}) files.push_back(begin(name, name, Existing::kStays));
  std::ofstream(path("b")) << "came in between";
  const Status finished = WholeFile::finish(files);
  ASSERT_FALSE(finished.ok());
  EXPECT_EQ(finished.error().kind(), ErrorKind::kCaller);
  files.clear();
  EXPECT_EQ(names(), std::vector<std::string>{"b"});
  EXPECT_EQ(content("b"), "came in between");
}

TEST_F(WholeFileTest, AFileThatIsReplacedKeepsItsPlaceAndItsPermissions) {
  std::ofstream(path("real")) << "before";
  ASSERT_EQ(::chmod(path("real").c_str(), 0640), 0);
  std::filesystem::create_symlink(path("real"), path("link"));
  EXPECT_TRUE(replace_file(path("link"), "after").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(path("link")));
  EXPECT_EQ(content("real"), "after");
  struct stat is {};
  ASSERT_EQ(::stat(path("real").c_str(), &is), 0);
  EXPECT_EQ(is.st_mode & 07777U, 0640U);
}

TEST_F(WholeFileTest, WhatIsNoFileIsWrittenAsItIs) {
  EXPECT_TRUE(replace_file("/dev/null", "nothing").ok());
  EXPECT_FALSE(std::filesystem::exists("/dev/null.unfinished"));
  EXPECT_EQ(replace_file("/dev/full", "too much").error().kind(), ErrorKind::kEnvironment);
  EXPECT_EQ(replace_file(folder, "a folder").error().kind(), ErrorKind::kEnvironment);
  EXPECT_EQ(replace_file(path("no/folder"), "none").error().kind(), ErrorKind::kEnvironment);
}

}  // namespace
}  // namespace ctn::os
