#include "os/linux/listener.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <vector>

#include "os/linux/forked_process.h"
#include "os/linux/local_address.h"
#include "os/testing/requires_real_time.h"

namespace ctn::os {
namespace {

using testing::HasSubstr;

class ListenerTest : public testing::Test {
 protected:
  ListenerTest() {
    std::string name = (std::filesystem::temp_directory_path() / "catan-listen-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    path_ = folder_ + "/run/app";
  }
  ~ListenerTest() override { std::filesystem::remove_all(folder_); }

  // Why it cannot be opened.
  Error error_at(const std::string& path) {
    const auto listener = Listener::open(path, 0600);
    return listener.ok() ? Error::caller("none", "") : listener.error();
  }
  mode_t mode_of(const std::string& path) {
    struct stat file {};
    EXPECT_EQ(::lstat(path.c_str(), &file), 0);
    return file.st_mode & 07777;
  }
  bool is_there(const std::string& path) { return std::filesystem::exists(std::filesystem::symlink_status(path)); }

  std::string folder_;
  std::string path_;
};

TEST_F(ListenerTest, MakesItsFolderAndSetsWhoMayConnect) {
  const mode_t before = ::umask(077);
  const auto listener = Listener::open(path_, 0660);
  ::umask(before);
  ASSERT_TRUE(listener.ok()) << listener.error().message();
  EXPECT_EQ(mode_of(folder_ + "/run"), 0755U);
  EXPECT_EQ(mode_of(path_), 0660U);
  EXPECT_EQ(listener->path(), path_);
}

TEST_F(ListenerTest, FolderThatIsThereStaysAsItIs) {
  ASSERT_EQ(::mkdir((folder_ + "/run").c_str(), 0700), 0);
  EXPECT_TRUE(Listener::open(path_, 0660).ok());
  EXPECT_EQ(mode_of(folder_ + "/run"), 0700U);
}

TEST_F(ListenerTest, RemovesItsSocketAndNoOthers) {
  {
    auto listener = Listener::open(path_, 0600).value();
    const Listener moved = std::move(listener);
    EXPECT_TRUE(is_there(path_));
  }
  EXPECT_FALSE(is_there(path_));
  {
    const auto listener = Listener::open(path_, 0600).value();
    ASSERT_EQ(::unlink(path_.c_str()), 0);
    std::ofstream(path_) << "another's";
  }
  EXPECT_TRUE(is_there(path_));
}

TEST_F(ListenerTest, TakesThePlaceOfOneThatWasKilled) {
  const SyncPipe ready;
  ForkedProcess killed([&] {
    const auto listener = Listener::open(path_, 0600);
    ready.send();
    return ::pause();
  });
  ASSERT_TRUE(ready.receive());
  const Error running = error_at(path_);
  EXPECT_EQ(running.kind(), ErrorKind::kEnvironment);
  EXPECT_THAT(running.message(), HasSubstr("another server is running there"));
  killed.end(SIGKILL);
  EXPECT_TRUE(is_there(path_));
  const auto listener = Listener::open(path_, 0600);
  ASSERT_TRUE(listener.ok()) << listener.error().message();
  EXPECT_TRUE(Connection::connect(path_).ok());
}

// Guards: it failed where few files may be open, since a client that has no descriptor left is told that instead.
TEST_F(ListenerTest, OneThatHangsIsRunning) {
  constexpr rlim_t kEnough = 1024;  // 128 may wait, with two descriptors each
  rlimit files{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &files), 0);
  CATAN_REQUIRE(files.rlim_max >= kEnough, "needs 1024 open files: raise the limit (`ulimit -Hn`)");
  files.rlim_cur = std::max(files.rlim_cur, kEnough);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &files), 0);
  const auto hangs = Listener::open(path_, 0600).value();
  std::vector<Connection> waiting;
  while (waiting.size() < 10'000) {
    auto next = Connection::connect(path_);
    if (!next.ok()) {
      EXPECT_THAT(next.error().message(), HasSubstr("too many are waiting"));
      break;
    }
    waiting.push_back(std::move(*next));
  }
  EXPECT_GE(waiting.size(), 128U);
  EXPECT_LT(waiting.size(), 300U);
  EXPECT_THAT(error_at(path_).message(), HasSubstr("another server is running there"));
}

TEST_F(ListenerTest, LeavesAloneWhatIsNoSocketOfItsKind) {
  ASSERT_TRUE(Listener::open(path_, 0600).ok());  // makes the folder
  std::ofstream(path_) << "precious";
  const Error file = error_at(path_);
  EXPECT_EQ(file.kind(), ErrorKind::kCaller);
  EXPECT_THAT(file.message(), HasSubstr("something else is there"));
  EXPECT_EQ(std::filesystem::file_size(path_), 8U);
  std::filesystem::remove(path_);

  std::filesystem::create_symlink("/etc/passwd", path_);
  EXPECT_EQ(error_at(path_).kind(), ErrorKind::kCaller);
  std::filesystem::remove(path_);

  const Descriptor stream(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const auto address = local_address(path_).value();
  ASSERT_EQ(::bind(stream.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(::listen(stream.number(), 1), 0);
  EXPECT_THAT(error_at(path_).message(), HasSubstr("belongs to another program"));
  EXPECT_TRUE(is_there(path_));
}

// Guards: the advice was to name another path.
TEST_F(ListenerTest, WithoutAFileDescriptorLeftItSaysToRaiseTheLimit) {
  ForkedProcess limited([&] {
    const rlimit none{0, 0};
    if (::setrlimit(RLIMIT_NOFILE, &none) != 0) return 2;
    const Error error = error_at(path_);
    const bool advised = error.message().find("raise the limit of open files (`ulimit -n`)") != std::string::npos;
    return advised && error.kind() == ErrorKind::kEnvironment ? 0 : 1;
  });
  EXPECT_EQ(limited.join(), 0);
}

TEST_F(ListenerTest, PlacesWhereItCannotBeSaySo) {
  EXPECT_THAT(error_at(folder_ + "/none/below/app").message(), HasSubstr("is missing"));
  std::ofstream(folder_ + "/file") << "x";
  EXPECT_EQ(error_at(folder_ + "/file/app").kind(), ErrorKind::kEnvironment);
  EXPECT_EQ(error_at(folder_).kind(), ErrorKind::kCaller);  // a folder
  CATAN_REQUIRE(::getuid() == 0, "needs root, to become another user: run it as root");
  ASSERT_EQ(::chmod(folder_.c_str(), 0755), 0);
  ForkedProcess stranger([&] {
    if (!become_nobody()) return 2;
    const bool both = error_at(folder_ + "/app").message().find("not permitted") != std::string::npos &&
                      error_at(folder_ + "/run/app").message().find("not permitted") != std::string::npos;
    return both ? 0 : 1;
  });
  EXPECT_EQ(stranger.join(), 0);
}

TEST_F(ListenerTest, NobodyCanKeepItFromStarting) {
  ASSERT_TRUE(Listener::open(path_, 0600).ok());  // makes the folder
  const Descriptor held(::open((folder_ + "/run").c_str(), O_RDONLY | O_CLOEXEC));
  ASSERT_EQ(::flock(held.number(), LOCK_EX), 0);
  EXPECT_TRUE(Listener::open(path_, 0600).ok());
}

TEST_F(ListenerTest, WithoutDescriptorsClientsAreTurnedAwayNotLeftWaiting) {
  ForkedProcess server([&] {
    auto listener = Listener::open(path_, 0600).value();
    const auto first = Connection::connect(path_);
    const auto second = Connection::connect(path_);
    if (!first.ok() || !second.ok()) return 1;
    Descriptor highest(::dup(0));
    const rlimit none{static_cast<rlim_t>(highest.number()), static_cast<rlim_t>(highest.number())};
    highest.reset();
    if (::setrlimit(RLIMIT_NOFILE, &none) != 0) return 2;
    for (int client = 0; client < 2; ++client) {
      const auto refused = listener.accept();
      if (refused.ok() || refused.error().message().find("turned a client away") == std::string::npos) return 3;
    }
    const auto client = listener.accept();
    Message message;
    const bool closed = first->receive(message) == Arrival::kClosed && second->receive(message) == Arrival::kClosed;
    return client.ok() && !client->has_value() && closed ? 0 : 4;
  });
  EXPECT_EQ(server.join(), 0);
}

}  // namespace
}  // namespace ctn::os
