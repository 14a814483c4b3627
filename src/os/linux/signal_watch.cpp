#include "os/linux/signal_watch.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <utility>

#include "os/linux/errno_text.h"

namespace ctn::os {
namespace {

sigset_t set_of(const std::vector<int>& signals) {
  sigset_t set{};
  sigemptyset(&set);
  for (const int number : signals) sigaddset(&set, number);
  return set;
}

bool may_be_watched(int number) {
  sigset_t set{};
  sigemptyset(&set);
  return number != SIGKILL && number != SIGSTOP && sigaddset(&set, number) == 0;
}

}  // namespace

SignalWatch::SignalWatch(Descriptor descriptor, std::vector<int> blocked)
    : descriptor_(std::move(descriptor)), blocked_(std::move(blocked)) {}

SignalWatch::~SignalWatch() {
  if (!descriptor_.valid()) return;
  while (next()) continue;
  const sigset_t set = set_of(blocked_);
  ::pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

Result<SignalWatch> SignalWatch::start(const std::vector<int>& signals) {
  for (const int number : signals) {
    if (!may_be_watched(number)) {
      return Error::caller(fmt::format("signal {} cannot be watched", number), "name one that can be blocked");
    }
  }
  const sigset_t set = set_of(signals);
  Descriptor descriptor(::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!descriptor.valid()) {
    return Error::environment("cannot watch for signals: " + errno_text(errno),
                              "raise the limit of open files (`ulimit -n`)");
  }
  sigset_t before{};
  ::pthread_sigmask(SIG_BLOCK, &set, &before);
  std::vector<int> blocked;
  for (const int number : signals) {
    if (sigismember(&before, number) == 0) blocked.push_back(number);
  }
  return SignalWatch(std::move(descriptor), std::move(blocked));
}

std::optional<int> SignalWatch::next() {
  signalfd_siginfo found{};
  ssize_t count = -1;
  do {
    count = ::read(descriptor_.number(), &found, sizeof found);
  } while (count < 0 && errno == EINTR);
  if (count != static_cast<ssize_t>(sizeof found)) return std::nullopt;
  return static_cast<int>(found.ssi_signo);
}

}  // namespace ctn::os
