// For tests: a copy of this process that runs a function and ends with what that returns. Killed at the end of the
// scope. For tests that have no other threads when they fork.
#pragma once

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <optional>

#include "os/os.h"

namespace ctn::os {

class ForkedProcess {
 public:
  template <class Body>
  explicit ForkedProcess(Body body) : number_(::fork()) {
    if (number_ == 0) ::_exit(static_cast<int>(body()));
  }
  ~ForkedProcess() {
    if (number_ > 0) end(SIGKILL);
  }
  ForkedProcess(const ForkedProcess&) = delete;
  ForkedProcess& operator=(const ForkedProcess&) = delete;

  pid_t number() const { return number_; }
  ProcessId process() const { return ProcessId{number_}; }

  // What it returned, or minus the signal that ended it.
  int join() {
    int status = 0;
    ::waitpid(number_, &status, 0);
    number_ = 0;
    return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
  }
  int end(int signal) {
    ::kill(number_, signal);
    return join();
  }

 private:
  pid_t number_;
};

// In a copy that root made: goes on as the user who may do nothing. False: it cannot.
inline bool become_nobody() {
  constexpr unsigned kNobody = 65534;
  return ::setgid(kNobody) == 0 && ::setuid(kNobody) == 0;
}

// A pipe by which one process waits for a value from another: made before the fork, so that both have it.
class SyncPipe {
 public:
  SyncPipe() {
    if (::pipe(ends_) != 0) ::abort();
  }
  ~SyncPipe() {
    ::close(ends_[0]);
    ::close(ends_[1]);
  }
  SyncPipe(const SyncPipe&) = delete;
  SyncPipe& operator=(const SyncPipe&) = delete;

  void send(int value = 0) const { static_cast<void>(::write(ends_[1], &value, sizeof value) < 0); }
  // Waits for a value, for ten seconds at most. None: no value came.
  std::optional<int> receive() const {
    pollfd source{ends_[0], POLLIN, 0};
    int value = 0;
    if (::poll(&source, 1, 10'000) != 1 || ::read(ends_[0], &value, sizeof value) != sizeof value) return std::nullopt;
    return value;
  }

 private:
  int ends_[2] = {-1, -1};
};

}  // namespace ctn::os
