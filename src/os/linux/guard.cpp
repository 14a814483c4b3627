#include "os/linux/guard.h"

#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <map>
#include <mutex>
#include <new>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "os/linux/descriptor.h"
#include "os/linux/guardian.h"
#include "os/linux/kernel_calls.h"
#include "os/linux/process.h"
#include "os/linux/sentinel.h"

namespace ctn::os {
namespace {

constexpr int kPatienceMs = 2000;

Error cannot_guard(int error, std::string mend) {
  return Error::environment("cannot start a guardian: " + std::generic_category().message(error), std::move(mend));
}

// Memory that stays shared across a fork.
class SharedTable {
 public:
  SharedTable() {
    void* const memory =
        ::mmap(nullptr, sizeof(GuardTable), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
    if (memory != MAP_FAILED) table_ = new (memory) GuardTable;
  }
  ~SharedTable() {
    if (table_ != nullptr) ::munmap(table_, sizeof(GuardTable));
  }
  SharedTable(const SharedTable&) = delete;
  SharedTable& operator=(const SharedTable&) = delete;

  GuardTable* get() const { return table_; }

 private:
  GuardTable* table_ = nullptr;
};

bool fill(WatchedThread& entry, ThreadId thread, std::uint64_t started, const SavedScheduling& before) {
  entry.thread = static_cast<std::int32_t>(thread);
  entry.started = started;
  entry.policy = before.policy;
  entry.priority = before.priority;
  entry.nice = before.nice;
  entry.reset_on_fork = before.reset_on_fork ? 1 : 0;
  entry.cpus = {};
  for (const int cpu : before.affinity.cpus()) {
    const auto number = static_cast<std::size_t>(cpu);
    if (cpu < 0 || number >= kMaxGuardedCpu) return false;
    entry.cpus.at(number / 64) |= std::uint64_t{1} << number % 64;
  }
  return true;
}

// By its parent, because on a busy machine it might not get so far by itself.
void put_above_all(pid_t guardian) {
  KernelCalls kernel;
  for (const int priority : kPrioritiesAboveAll) {
    if (kernel.set_policy(guardian, {SCHED_FIFO, priority, true}) == 0) return;
  }
}

class LinuxGuard : public Guard {
 public:
  explicit LinuxGuard(LinuxRoots roots) : roots_(std::move(roots)) {}
  ~LinuxGuard() override {
    if (!places_.empty()) static_cast<void>(tend_locked());
    end_guardian();
  }

  // Once, before all else.
  Status start();

  bool watch(ThreadId thread, const SavedScheduling& before) override;
  void forget(ThreadId thread) override;
  Status tend() override;
  int replaced() const override;

 private:
  Status tend_locked();
  Status fork_guardian();
  bool await_ready() const;
  void end_guardian();

  LinuxRoots roots_;
  mutable std::mutex mutex_;
  SharedTable table_;
  std::map<ThreadId, std::size_t> places_;
  std::vector<std::size_t> free_places_;
  pid_t guardian_ = 0;   // 0: none
  Descriptor lifeline_;  // when it is closed, the guardian acts
  int replaced_ = 0;
  Sentinel sentinel_;  // forks the guardian
};

Status LinuxGuard::start() {
  if (table_.get() == nullptr) return cannot_guard(ENOMEM, "free memory");
  for (std::size_t place = kMaxWatched; place-- > 0;) free_places_.push_back(place);
  if (Status forked = fork_guardian(); !forked.ok()) return forked;
  if (await_ready()) return Done{};
  return Error::environment(
      "a guardian was started but ended at once",
      "let this process have children that outlive it (a container's filter or limit forbids it)");
}

Status LinuxGuard::fork_guardian() {
  std::array<int, 2> ends{-1, -1};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return cannot_guard(errno, "raise the limit of open files (`ulimit -n`)");
  }
  Descriptor ours(ends[0]);
  const Descriptor theirs(ends[1]);
  const Descriptor server = watch_process(ProcessId{::getpid()});
  pid_t child = -1;
  int error = 0;
  sentinel_.call([&] {
    child = ::fork();
    if (child == 0) stand_guard(*table_.get(), roots_.procfs.c_str(), theirs.number(), server.number());
    error = errno;
    if (child > 0) put_above_all(child);
  });
  if (child < 0) return cannot_guard(error, "raise the limit of processes (`ulimit -u`, or the control group's)");
  guardian_ = child;
  lifeline_ = std::move(ours);
  return Done{};
}

// One that is only slow counts as ready: it acts when it gets there.
bool LinuxGuard::await_ready() const {
  pollfd source{lifeline_.number(), POLLIN, 0};
  if (::poll(&source, 1, kPatienceMs) <= 0) return true;
  char ready = 0;
  return ::recv(lifeline_.number(), &ready, 1, MSG_DONTWAIT) == 1;
}

// Its end of the lifeline is closed when it is done. Before that, the byte that said it was ready may still be there.
void LinuxGuard::end_guardian() {
  if (guardian_ == 0) return;
  ::shutdown(lifeline_.number(), SHUT_WR);
  for (bool open = true; open;) {
    pollfd source{lifeline_.number(), POLLIN, 0};
    const int found = ::poll(&source, 1, kPatienceMs);
    if (found == 0) ::kill(guardian_, SIGKILL);  // somebody has stopped it
    char byte = 0;
    if (found >= 0) open = ::recv(lifeline_.number(), &byte, 1, 0) == 1;
  }
  ::waitpid(guardian_, nullptr, 0);
  guardian_ = 0;
}

Status LinuxGuard::tend() {
  const std::lock_guard lock(mutex_);
  return tend_locked();
}

Status LinuxGuard::tend_locked() {
  if (guardian_ != 0 && ::waitpid(guardian_, nullptr, WNOHANG) == 0) return Done{};
  guardian_ = 0;
  Status forked = fork_guardian();
  if (forked.ok()) ++replaced_;
  return forked;
}

int LinuxGuard::replaced() const {
  const std::lock_guard lock(mutex_);
  return replaced_;
}

// The new entry is published before an old one of the thread goes, so that there is always one.
bool LinuxGuard::watch(ThreadId thread, const SavedScheduling& before) {
  const std::lock_guard lock(mutex_);
  if (!tend_locked().ok()) return false;
  const auto started = start_time(thread, roots_);
  if (!started || free_places_.empty()) return false;
  const std::size_t place = free_places_.back();
  WatchedThread& entry = table_.get()->threads.at(place);
  if (!fill(entry, thread, *started, before)) return false;
  entry.published.store(1, std::memory_order_release);
  free_places_.pop_back();
  const auto [known, is_new] = places_.try_emplace(thread, place);
  if (!is_new) {
    const std::size_t old = std::exchange(known->second, place);
    table_.get()->threads.at(old).published.store(0, std::memory_order_release);
    free_places_.push_back(old);
  }
  return true;
}

void LinuxGuard::forget(ThreadId thread) {
  const std::lock_guard lock(mutex_);
  const auto found = places_.find(thread);
  if (found == places_.end()) return;
  table_.get()->threads.at(found->second).published.store(0, std::memory_order_release);
  free_places_.push_back(found->second);
  places_.erase(found);
}

}  // namespace

Result<std::unique_ptr<Guard>> start_guard(const LinuxRoots& roots) try {
  auto guard = std::make_unique<LinuxGuard>(roots);
  if (Status started = guard->start(); !started.ok()) return started.error();
  return std::unique_ptr<Guard>(std::move(guard));
} catch (const std::system_error& no_thread) {
  return cannot_guard(no_thread.code().value(), "raise the limit of threads (`ulimit -u`, or the control group's)");
}

}  // namespace ctn::os
