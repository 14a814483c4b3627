#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <sstream>
#include <thread>

#include "command_test.h"
#include "os/linux/descendants.h"

namespace ctn::test {

std::string read_all(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

namespace {

// Sanitizers make plans ten times as slow.
#ifdef CATAN_SANITIZED
constexpr std::chrono::seconds kLimit{120};
#else
constexpr std::chrono::seconds kLimit{20};
#endif
constexpr std::chrono::seconds kBeforeLimit{2};

std::string first_line(const std::string& path) {
  std::ifstream stream(path);
  std::string line;
  std::getline(stream, line);
  return line;
}

// Name, place in the kernel, system call with its arguments, and scheduling of each thread below this process: what can
// be known of a command that hangs without a debugger.
std::string threads_below() {
  namespace fs = std::filesystem;
  std::string text;
  for (const os::ProcessId process : os::descendants()) {
    std::error_code gone;
    for (const fs::directory_entry& thread :
         fs::directory_iterator(fmt::format("/proc/{}/task", static_cast<int>(process)), gone)) {
      const std::string folder = thread.path().string();
      text += fmt::format("{} {}: in {}, call {}, stat {}\n", folder, first_line(folder + "/comm"),
                          first_line(folder + "/wchan"), first_line(folder + "/syscall"), first_line(folder + "/stat"));
    }
  }
  return text;
}

// Says on stderr what a command is doing that is about to exceed the limit. Until the end of the scope.
class LimitWatch {
 public:
  LimitWatch() : thread_([this] { watch(); }) {}
  ~LimitWatch() {
    {
      const std::lock_guard lock(mutex_);
      done_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  LimitWatch(const LimitWatch&) = delete;
  LimitWatch& operator=(const LimitWatch&) = delete;

 private:
  void watch() {
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, kLimit - kBeforeLimit, [this] { return done_; })) return;
    fmt::print(stderr, "the command has not ended after {} s:\n{}", (kLimit - kBeforeLimit).count(), threads_below());
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool done_ = false;
  std::thread thread_;
};

}  // namespace

Outcome run_catan(const std::string& arguments, const std::string& folder) {
  // CTest runs each test as a process of its own, several at a time.
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string base = ::testing::TempDir() + "catan_" + test->test_suite_name() + "_" + test->name();
  for (char& c : base) c = c == '/' && &c > base.data() + ::testing::TempDir().size() ? '_' : c;
  const std::string command = "cd '" + folder + "' && timeout " + std::to_string(kLimit.count()) +
                              " '" CATAN_COMMAND "' " + arguments + " > '" + base + ".out' 2> '" + base +
                              ".err' < /dev/null";
  int status = 0;
  {
    const LimitWatch watch;
    status = std::system(command.c_str());
  }
  Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_all(base + ".out"),
                  read_all(base + ".err")};
  std::remove((base + ".out").c_str());
  std::remove((base + ".err").c_str());
  return outcome;
}

}  // namespace ctn::test
