#include "os/linux/background.h"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/random.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <vector>

#include "os/linux/errno_text.h"

namespace ctn::os {
namespace {

constexpr int kYieldingNice = 5;
constexpr int kLastNice = 10;

// Of the calling thread: Linux takes it for the process.
void raise_nice(int to) {
  if (::getpriority(PRIO_PROCESS, 0) < to) static_cast<void>(::setpriority(PRIO_PROCESS, 0, to));  // always allowed
}

void lower_limit(int resource, std::uint64_t max) {
  rlimit limit{};
  // glibc gives the resources a type of their own.
  const auto which = static_cast<decltype(RLIMIT_NOFILE)>(resource);
  if (::getrlimit(which, &limit) != 0) return;
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_cur, max);
  limit.rlim_max = std::min<rlim_t>(limit.rlim_max, max);
  static_cast<void>(::setrlimit(which, &limit));
}

}  // namespace

void yield_to_others() { raise_nice(kYieldingNice); }

void yield_to_all() { raise_nice(kLastNice); }

void limit_resources(std::uint64_t open_files, std::uint64_t memory_bytes) {
  lower_limit(RLIMIT_NOFILE, open_files);
#ifndef CATAN_SANITIZED  // sanitizers map terabytes
  lower_limit(RLIMIT_AS, memory_bytes);
#else
  static_cast<void>(memory_bytes);
#endif
}

bool end_with(ProcessId parent) {
  if (::prctl(PR_SET_PDEATHSIG, SIGTERM) != 0) return false;
  return ::getppid() == static_cast<pid_t>(parent);
}

Result<std::string> random_digits(std::size_t bytes) {
  std::vector<unsigned char> random(bytes);
  for (std::size_t place = 0; place < bytes;) {
    const ssize_t got = ::getrandom(random.data() + place, bytes - place, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      return Error::environment("there are no random numbers: " + errno_text(errno), "name a file with --token-file");
    }
    place += static_cast<std::size_t>(got);
  }
  std::string text;
  for (const unsigned char byte : random) text += fmt::format("{:02x}", byte);
  return text;
}

}  // namespace ctn::os
