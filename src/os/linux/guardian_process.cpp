#include "os/linux/guardian_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <ctime>

#include "os/linux/kernel_calls.h"

namespace ctn::os {
namespace {

void close_range(unsigned first, unsigned last) {
  constexpr unsigned kMaxByHand = 1U << 16;
  if (first > last || ::syscall(SYS_close_range, first, last, 0U) == 0) return;
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  const auto end = static_cast<unsigned>(std::min<rlim_t>(limit.rlim_cur, kMaxByHand));
  for (unsigned number = first; number < end && number <= last; ++number) ::close(static_cast<int>(number));
}

// Standard input and output, too, are closed: a program that reads what the server writes is not to wait for us.
void close_all_but(int one, int other) {
  unsigned from = 0;
  for (const int kept : {std::min(one, other), std::max(one, other)}) {
    if (kept < 0) continue;
    const auto number = static_cast<unsigned>(kept);
    if (number > from) close_range(from, number - 1);
    from = number + 1;
  }
  close_range(from, ~0U);
}

void restore_all(const GuardianTable& table, const char* procfs) {
  KernelCalls kernel;
  for (const WatchedThread& watched : table.threads) {
    if (watched.published.load(std::memory_order_acquire) != 0) restore(kernel, procfs, watched.saved);
  }
}

// ---- Waiting

// How often, and how many times, what was saved is set again while a server comes to its end.
constexpr int kPassMs = 5;
constexpr int kPasses = 2000;

// The other end sends nothing: there is something to read when it is closed.
bool server_has_ended(int monitor_socket) {
  char byte = 0;
  const ssize_t count = ::read(monitor_socket, &byte, 1);
  return count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN);
}

// What tells that the server ends. Negative ones are passed over.
struct EndSources {
  int monitor_socket = -1;
  int server = -1;  // pidfd
  int death = -1;   // of the thread that forked us
};

enum class Seen { kNothing, kEnding, kEnded };

// kEnding: one thread of the server is gone; kEnded: all are, or the server closes its end. kNothing: so long a time
// has passed (ms; negative: any).
Seen wait_for_end(EndSources& signs, int timeout) {
  constexpr timespec kPause{0, 10'000'000};
  while (true) {
    std::array<pollfd, 3> sources = {
        {{signs.monitor_socket, POLLIN, 0}, {signs.server, POLLIN, 0}, {signs.death, POLLIN, 0}}};
    const int found = ::poll(sources.data(), sources.size(), timeout);
    if (found == 0) return Seen::kNothing;
    if (found < 0) {
      if (errno != EINTR) ::nanosleep(&kPause, nullptr);  // to spin up here would stop the machine
      if (timeout >= 0) return Seen::kNothing;
      continue;
    }
    if ((sources[1].revents & POLLIN) != 0) return Seen::kEnded;
    if (sources[0].revents != 0 && server_has_ended(signs.monitor_socket)) return Seen::kEnded;
    if (sources[1].revents != 0) signs.server = -1;
    if (sources[2].revents != 0) signs.death = -1;
    if ((sources[2].revents & POLLIN) != 0) return Seen::kEnding;
  }
}

// Readable once the thread that forked us is gone. The signal is one that no program sends by chance.
int watch_forker() {
  const int number = SIGRTMAX;
  sigset_t set{};
  sigemptyset(&set);
  sigaddset(&set, number);
  ::prctl(PR_SET_PDEATHSIG, number);
  return ::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
}

}  // namespace

void run_guardian(const GuardianTable& table, const char* procfs, int monitor_socket, int server) {
  ::prctl(PR_SET_NAME, "catan-guard");
  ::setsid();
  if (::chdir("/") != 0) ::_exit(1);  // holds no file system that someone may want to unmount
  close_all_but(monitor_socket, server);
  EndSources signs{monitor_socket, server, watch_forker()};
  KernelCalls().set_affinity(0, all_cpus());
  const char ready = 1;
  ::send(monitor_socket, &ready, 1, MSG_NOSIGNAL);
  Seen seen = wait_for_end(signs, -1);
  restore_all(table, procfs);
  // Its other threads may still be in calls that raise a thread, and come to their ends later than this one to its.
  for (int pass = 0; seen != Seen::kEnded && pass < kPasses; ++pass) {
    seen = wait_for_end(signs, kPassMs);
    restore_all(table, procfs);
  }
  ::_exit(0);
}

}  // namespace ctn::os
