#include "os/linux/child_process.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <string_view>
#include <thread>
#include <utility>

#include "os/linux/errno_text.h"
#include "os/linux/process.h"

namespace ctn::os {
namespace {

constexpr int kLostCode = 255;

std::string_view name_of(std::string_view entry) { return entry.substr(0, entry.find('=')); }

// Pointers to what the kernel copies; valid as long as the strings.
class StringArray {
 public:
  void add(const char* text) { pointers_.insert(pointers_.end() - 1, const_cast<char*>(text)); }
  char* const* get() { return pointers_.data(); }

 private:
  std::vector<char*> pointers_{nullptr};
};

StringArray merged_environment(const std::vector<std::string>& added) {
  StringArray all;
  for (char** ours = environ; ours != nullptr && *ours != nullptr; ++ours) {
    const auto replaces = [&](const std::string& entry) { return name_of(entry) == name_of(*ours); };
    if (std::none_of(added.begin(), added.end(), replaces)) all.add(*ours);
  }
  for (const std::string& entry : added) all.add(entry.c_str());
  return all;
}

// What a program expects to start with, whatever this one does with signals.
class PlainSignals {
 public:
  PlainSignals() {
    ::posix_spawnattr_init(&attributes_);
    sigset_t set{};
    sigemptyset(&set);
    ::posix_spawnattr_setsigmask(&attributes_, &set);
    sigfillset(&set);
    ::posix_spawnattr_setsigdefault(&attributes_, &set);
    ::posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~PlainSignals() { ::posix_spawnattr_destroy(&attributes_); }
  PlainSignals(const PlainSignals&) = delete;
  PlainSignals& operator=(const PlainSignals&) = delete;

  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_{};
};

// What is done with descriptors before the program begins.
class Redirections {
 public:
  Redirections() { ::posix_spawn_file_actions_init(&actions_); }
  ~Redirections() { ::posix_spawn_file_actions_destroy(&actions_); }
  Redirections(const Redirections&) = delete;
  Redirections& operator=(const Redirections&) = delete;

  // errno's number where it cannot be noted.
  int copy(int from, int to) { return ::posix_spawn_file_actions_adddup2(&actions_, from, to); }
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

Error cannot_start(const std::string& program, int error) {
  const std::string what = fmt::format("cannot start '{}': {}", program, errno_text(error));
  if (error == ENOENT) return Error::caller(what, "check its name, and that PATH has its folder");
  if (error == EACCES || error == ENOEXEC) return Error::caller(what, "name a program that may be executed");
  return Error::environment(what, "see what the system lacks: processes (`ulimit -u`), or memory");
}

}  // namespace

ChildProcess::ChildProcess(ProcessId process, Descriptor descriptor)
    : process_(process), descriptor_(std::move(descriptor)) {}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : process_(std::exchange(other.process_, ProcessId{})),
      descriptor_(std::move(other.descriptor_)),
      exit_(other.exit_) {}

ChildProcess::~ChildProcess() {
  if (process_ != ProcessId{}) end();
}

Result<ChildProcess> ChildProcess::start(const std::vector<std::string>& arguments,
                                         const std::vector<std::string>& environment, Output output) {
  if (arguments.empty() || arguments.front().empty()) return Error::caller("there is no program to start", "name one");
  StringArray words;
  for (const std::string& argument : arguments) words.add(argument.c_str());
  for (const std::string& entry : environment) {
    if (entry.find('=') == std::string::npos || name_of(entry).empty()) {
      return Error::caller(fmt::format("'{}' is no entry of an environment", entry), "write NAME=value");
    }
  }
  StringArray variables = merged_environment(environment);
  const PlainSignals signals;
  Redirections redirections;
  int error = output == Output::kErrors ? redirections.copy(STDERR_FILENO, STDOUT_FILENO) : 0;
  pid_t process = 0;
  if (error == 0) {
    error = ::posix_spawnp(&process, arguments.front().c_str(), redirections.get(), signals.get(), words.get(),
                           variables.get());
  }
  if (error != 0) return cannot_start(arguments.front(), error);
  return ChildProcess(ProcessId{process}, watch_process(ProcessId{process}));
}

std::optional<Exit> ChildProcess::wait() {
  if (exit_ || process_ == ProcessId{}) return exit_;
  int status = 0;
  pid_t found = -1;
  do {
    found = ::waitpid(static_cast<pid_t>(process_), &status, WNOHANG);
  } while (found < 0 && errno == EINTR);
  if (found == 0) return std::nullopt;
  if (found < 0) {
    exit_ = Exit{kLostCode, 0};
  } else if (WIFSIGNALED(status)) {
    exit_ = Exit{0, WTERMSIG(status)};
  } else {
    exit_ = Exit{WEXITSTATUS(status), 0};
  }
  return exit_;
}

// Its number is its own until wait() has collected how it ended.
Status ChildProcess::signal(int number) {
  if (wait() || process_ == ProcessId{}) return Done{};
  if (::kill(static_cast<pid_t>(process_), number) == 0 || errno == ESRCH) return Done{};
  const std::string what =
      fmt::format("cannot send signal {} to process {}: {}", number, static_cast<int>(process_), errno_text(errno));
  return errno == EINVAL ? Error::caller(what, "name a signal of this system")
                         : Error::environment(what, "run as root, or let the program keep its user");
}

void ChildProcess::end() {
  constexpr auto kTimeout = std::chrono::seconds(2);
  constexpr auto kPause = std::chrono::milliseconds(1);
  static_cast<void>(signal(SIGTERM));
  for (auto waited = std::chrono::milliseconds(0); waited < kTimeout && !wait(); waited += kPause) {
    std::this_thread::sleep_for(kPause);
  }
  if (wait()) return;
  // One that became another user cannot be made to end, and is not waited for.
  if (signal(SIGKILL).ok()) ::waitpid(static_cast<pid_t>(process_), nullptr, 0);
}

}  // namespace ctn::os
