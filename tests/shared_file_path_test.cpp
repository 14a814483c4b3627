#include "shared_file_path.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "os/testing/requires_real_time.h"

namespace ctn::tool {
namespace {

class SharedFilePath : public testing::Test {
 protected:
  SharedFilePath() {
    if (::mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("no folder " + folder_);
    ::setenv("XDG_RUNTIME_DIR", folder_.c_str(), 1);
  }
  ~SharedFilePath() override {
    ::unsetenv("XDG_RUNTIME_DIR");
    std::filesystem::remove_all(folder_);
  }
  // Of a socket in a folder that this user may not write in.
  std::string elsewhere() const { return fmt::format("{}/catan-{}-nowhere-robot.sock.runs", folder_, ::geteuid()); }

  std::string folder_ = testing::TempDir() + "catan-shared-XXXXXX";
};

TEST_F(SharedFilePath, LiesBesideTheSocketWhereThatIsAllowed) {
  const std::string socket = folder_ + "/robot.sock";
  EXPECT_EQ(shared_file_path(socket, ".runs"), socket + ".runs");
  std::ofstream(socket + ".runs") << "there";
  EXPECT_EQ(shared_file_path(socket, ".runs"), socket + ".runs");
}

TEST_F(SharedFilePath, IsTheUsersOwnWhereNot) {
  EXPECT_EQ(shared_file_path("/nowhere/robot.sock", ".runs"), elsewhere());
  ::unsetenv("XDG_RUNTIME_DIR");
  EXPECT_EQ(shared_file_path("/nowhere/robot.sock", ".runs"),
            fmt::format("/dev/shm/catan-{}-nowhere-robot.sock.runs", ::geteuid()));
}

TEST_F(SharedFilePath, ALinkIsNotFollowed) {
  const std::string socket = folder_ + "/robot.sock";
  std::ofstream(folder_ + "/other") << "of another program";
  std::filesystem::create_symlink(folder_ + "/other", socket + ".runs");
  EXPECT_NE(shared_file_path(socket, ".runs"), socket + ".runs");
}

TEST_F(SharedFilePath, AFileOfAnotherUserIsNotTaken) {
  CATAN_REQUIRE(::geteuid() == 0, "needs root, to make a file of another user");
  const std::string socket = folder_ + "/robot.sock";
  std::ofstream(socket + ".runs") << "of another user";
  constexpr uid_t kSomebody = 65534;
  ASSERT_EQ(::chown((socket + ".runs").c_str(), kSomebody, kSomebody), 0);
  EXPECT_NE(shared_file_path(socket, ".runs"), socket + ".runs");
}

}  // namespace
}  // namespace ctn::tool
