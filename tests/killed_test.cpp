// What is left of a scheduled application that is killed: nothing at a real-time level, whatever the signal, and a
// record that can be read. The application is the real face tracker.
#include <dirent.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "os/linux/linux_os.h"
#include "os/testing/requires_real_time.h"
#include "record/reader.h"

namespace ctn {
namespace {

using std::chrono::milliseconds;

class KilledTest : public ::testing::Test {
 protected:
  void SetUp() override {
    CATAN_REQUIRE_REAL_TIME(*os_);
    const std::string cpu = std::to_string(os_->affinity(os_->current_thread())->cpus().front());
    pid_ = ::fork();
    ASSERT_GE(pid_, 0);
    if (pid_ == 0) {
      const int null = ::open("/dev/null", O_WRONLY);
      ::dup2(null, STDOUT_FILENO);
      ::dup2(null, STDERR_FILENO);
      ::execl(FACE_TRACKING, FACE_TRACKING, "--scheduler", "catan", "--cpus", cpu.c_str(), "--seconds", "60",
              "--record", record_.c_str(), "--json", nullptr);
      ::_exit(127);
    }
  }
  void TearDown() override {
    if (pid_ > 0 && !reaped_) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    for (const char* ending : {"", "-wal", "-shm", "-journal"}) std::filesystem::remove(record_ + ending);
  }

  // Threads of the process that are above the ordinary level.
  std::vector<os::ThreadId> raised() const {
    std::vector<os::ThreadId> raised;
    const Result<std::vector<os::ThreadId>> threads = os_->threads(os::ProcessId{pid_});
    if (!threads) return raised;
    for (const os::ThreadId thread : *threads) {
      const Result<os::Level> level = os_->level(thread);
      if (level && *level != os::Level::kOrdinary) raised.push_back(thread);
    }
    return raised;
  }

  // Four nodes and the controller of their subchain.
  bool wait_until_scheduled() const {
    for (int tries = 0; tries < 600; ++tries) {
      if (raised().size() >= 5) return true;
      std::this_thread::sleep_for(milliseconds{50});
    }
    return false;
  }

  std::size_t recorded_runs() const {
    std::size_t runs = 0;
    const auto reader = record::Reader::open(record_);
    if (reader) static_cast<void>(reader->each_run([&](const record::Run&) { ++runs; }));
    return runs;
  }
  // It is written about once a second.
  bool wait_until_recorded() const {
    for (int tries = 0; tries < 300 && recorded_runs() == 0; ++tries) std::this_thread::sleep_for(milliseconds{50});
    return recorded_runs() > 0;
  }

  int reap() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    reaped_ = true;
    return status;
  }

  void expect_gone(const std::vector<os::ThreadId>& threads) const {
    for (const os::ThreadId thread : threads) {
      EXPECT_FALSE(os_->level(thread).ok()) << "thread " << static_cast<int>(thread) << " is still there";
    }
  }

  std::unique_ptr<os::Os> os_ = os::make_linux_os();
  std::string record_ = ::testing::TempDir() + "catan-killed-" + std::to_string(::getpid()) + ".db";
  pid_t pid_ = -1;
  bool reaped_ = false;
};

TEST_F(KilledTest, BySigkillLeavesNoThreadAndAReadableRecord) {
  ASSERT_TRUE(wait_until_scheduled() && wait_until_recorded());
  const std::size_t before = recorded_runs();
  const std::vector<os::ThreadId> threads = raised();
  ASSERT_EQ(::kill(pid_, SIGKILL), 0);
  const int status = reap();
  EXPECT_TRUE(WIFSIGNALED(status));
  expect_gone(threads);
  const auto reader = record::Reader::open(record_);
  ASSERT_TRUE(reader.ok()) << reader.error().message();
  EXPECT_FALSE(reader->ending().closed);
  EXPECT_GE(recorded_runs(), before) << "nothing that was written is lost";
}

TEST_F(KilledTest, BySigtermEndsInOrder) {
  ASSERT_TRUE(wait_until_scheduled() && wait_until_recorded());
  const std::size_t before = recorded_runs();
  const std::vector<os::ThreadId> threads = raised();
  ASSERT_EQ(::kill(pid_, SIGTERM), 0);
  const int status = reap();
  ASSERT_TRUE(WIFEXITED(status)) << "it handles the signal";
  EXPECT_EQ(WEXITSTATUS(status), 128 + SIGTERM);
  expect_gone(threads);
  const auto reader = record::Reader::open(record_);
  ASSERT_TRUE(reader.ok()) << reader.error().message();
  EXPECT_TRUE(reader->ending().closed);
  EXPECT_GE(recorded_runs(), before);
}

}  // namespace
}  // namespace ctn
