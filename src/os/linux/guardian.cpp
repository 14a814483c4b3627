#include "os/linux/guardian.h"

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
#include <utility>
#include <vector>

#include "os/linux/descriptor.h"
#include "os/linux/errno_text.h"
#include "os/linux/guardian_process.h"
#include "os/linux/kernel_calls.h"
#include "os/linux/monitored_thread.h"
#include "os/linux/process.h"
#include "os/thread_limit.h"

namespace ctn::os {
namespace {

constexpr int kTimeoutMs = 2000;

Error cannot_start_guardian(int error, std::string hint) {
  return Error::environment("cannot start a guardian: " + errno_text(error), std::move(hint));
}

// Memory that stays shared across a fork.
class SharedTable {
 public:
  SharedTable() {
    void* const memory = ::mmap(nullptr, sizeof(GuardianTable), PROT_READ | PROT_WRITE,
                                MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
    if (memory != MAP_FAILED) table_ = new (memory) GuardianTable;
  }
  ~SharedTable() {
    if (table_ != nullptr) ::munmap(table_, sizeof(GuardianTable));
  }
  SharedTable(const SharedTable&) = delete;
  SharedTable& operator=(const SharedTable&) = delete;

  GuardianTable* get() const { return table_; }

 private:
  GuardianTable* table_ = nullptr;
};

// By its parent, because on a busy machine it might not get so far by itself.
void put_above_all(pid_t guardian) {
  KernelCalls kernel;
  for (const int priority : kPrioritiesAboveAll) {
    if (kernel.set_policy(guardian, {SCHED_FIFO, priority, true}) == 0) return;
  }
}

class LinuxGuardian : public Guardian {
 public:
  explicit LinuxGuardian(LinuxRoots roots) : roots_(std::move(roots)) {}
  ~LinuxGuardian() override {
    if (!entries_.empty()) static_cast<void>(ensure_running_locked());
    end_guardian();
  }

  // Once, before all else.
  Status start();

  bool watch(const SavedScheduling& before) override;
  void forget(ThreadId thread) override;
  Status ensure_running() override;
  int replaced() const override;

 private:
  Status ensure_running_locked();
  Status fork_guardian();
  bool await_ready() const;
  void end_guardian();

  LinuxRoots roots_;
  mutable std::mutex mutex_;
  SharedTable table_;
  std::map<ThreadId, std::size_t> entries_;
  std::vector<std::size_t> free_entries_;
  pid_t guardian_pid_ = 0;     // 0: none
  Descriptor monitor_socket_;  // when it is closed, the guardian acts
  int replaced_ = 0;
  MonitoredThread monitored_thread_;  // forks the guardian
};

Status LinuxGuardian::start() {
  if (table_.get() == nullptr) return cannot_start_guardian(ENOMEM, "free memory");
  for (std::size_t place = kMaxWatched; place-- > 0;) free_entries_.push_back(place);
  if (Status forked = fork_guardian(); !forked.ok()) return forked;
  if (await_ready()) return Done{};
  return Error::environment(
      "a guardian was started but ended at once",
      "let this process have children that outlive it (a container's filter or limit forbids it)");
}

Status LinuxGuardian::fork_guardian() {
  std::array<int, 2> ends{-1, -1};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return cannot_start_guardian(errno, "raise the limit of open files (`ulimit -n`)");
  }
  Descriptor ours(ends[0]);
  const Descriptor theirs(ends[1]);
  const Descriptor server = watch_process(ProcessId{::getpid()});
  pid_t child = -1;
  int error = 0;
  monitored_thread_.call([&] {
    child = ::fork();
    if (child == 0) run_guardian(*table_.get(), roots_.procfs.c_str(), theirs.number(), server.number());
    error = errno;
    if (child > 0) put_above_all(child);
  });
  if (child < 0)
    return cannot_start_guardian(error, "raise the limit of processes (`ulimit -u`, or the control group's)");
  guardian_pid_ = child;
  monitor_socket_ = std::move(ours);
  return Done{};
}

// One that is only slow counts as ready: it acts when it gets there.
bool LinuxGuardian::await_ready() const {
  pollfd source{monitor_socket_.number(), POLLIN, 0};
  if (::poll(&source, 1, kTimeoutMs) <= 0) return true;
  char ready = 0;
  return ::recv(monitor_socket_.number(), &ready, 1, MSG_DONTWAIT) == 1;
}

// Its end of the socket is closed when it is done. Before that, the byte that said it was ready may still be there.
void LinuxGuardian::end_guardian() {
  if (guardian_pid_ == 0) return;
  ::shutdown(monitor_socket_.number(), SHUT_WR);
  for (bool open = true; open;) {
    pollfd source{monitor_socket_.number(), POLLIN, 0};
    const int found = ::poll(&source, 1, kTimeoutMs);
    if (found == 0) ::kill(guardian_pid_, SIGKILL);  // another program has stopped it
    char byte = 0;
    if (found >= 0) open = ::recv(monitor_socket_.number(), &byte, 1, 0) == 1;
  }
  ::waitpid(guardian_pid_, nullptr, 0);
  guardian_pid_ = 0;
}

Status LinuxGuardian::ensure_running() {
  const std::lock_guard lock(mutex_);
  return ensure_running_locked();
}

Status LinuxGuardian::ensure_running_locked() {
  if (guardian_pid_ != 0 && ::waitpid(guardian_pid_, nullptr, WNOHANG) == 0) return Done{};
  guardian_pid_ = 0;
  Status forked = fork_guardian();
  if (forked.ok()) ++replaced_;
  return forked;
}

int LinuxGuardian::replaced() const {
  const std::lock_guard lock(mutex_);
  return replaced_;
}

// The new entry is published before an old one of the thread goes, so that there is always one.
bool LinuxGuardian::watch(const SavedScheduling& before) {
  const std::lock_guard lock(mutex_);
  if (!ensure_running_locked().ok()) return false;
  if (start_time(before.thread, roots_) != before.started || free_entries_.empty()) return false;
  const std::size_t place = free_entries_.back();
  WatchedThread& entry = table_.get()->threads.at(place);
  entry.saved = to_saved_thread(before);
  if (to_cpu_set(entry.saved.cpus) != before.affinity) return false;
  entry.published.store(1, std::memory_order_release);
  free_entries_.pop_back();
  const auto [known, is_new] = entries_.try_emplace(before.thread, place);
  if (!is_new) {
    const std::size_t old = std::exchange(known->second, place);
    table_.get()->threads.at(old).published.store(0, std::memory_order_release);
    free_entries_.push_back(old);
  }
  return true;
}

void LinuxGuardian::forget(ThreadId thread) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(thread);
  if (found == entries_.end()) return;
  table_.get()->threads.at(found->second).published.store(0, std::memory_order_release);
  free_entries_.push_back(found->second);
  entries_.erase(found);
}

}  // namespace

Result<std::unique_ptr<Guardian>> start_guardian(const LinuxRoots& roots) {
  auto guardian = std::make_unique<LinuxGuardian>(roots);
  const Status started = within_thread_limit([&guardian] { return guardian->start(); });
  if (!started.ok()) return started.error();
  return std::unique_ptr<Guardian>(std::move(guardian));
}

}  // namespace ctn::os
