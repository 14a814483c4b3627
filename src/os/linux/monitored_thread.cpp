#include "os/linux/monitored_thread.h"

#include <pthread.h>
#include <sched.h>

#include <csignal>
#include <utility>

#include "os/linux/kernel_calls.h"
#include "os/os.h"

namespace ctn::os {

const std::array<int, 2> kPrioritiesAboveAll = {static_cast<int>(fixed_level(kFixedLevels - 1)) + 1,
                                                static_cast<int>(Level::kDispatcher)};

MonitoredThread::MonitoredThread() : thread_([this] { serve(); }) {}

MonitoredThread::~MonitoredThread() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void MonitoredThread::call(std::function<void()> task) {
  std::unique_lock lock(mutex_);
  task_ = std::move(task);
  changed_.notify_all();
  changed_.wait(lock, [this] { return !task_; });
}

void MonitoredThread::serve() {
  sigset_t all{};
  sigfillset(&all);  // handlers are other threads' business
  ::pthread_sigmask(SIG_SETMASK, &all, nullptr);
  ::pthread_setname_np(::pthread_self(), "catan-monitored");
  KernelCalls kernel;
  for (const int priority : kPrioritiesAboveAll) {
    if (kernel.set_policy(0, {SCHED_FIFO, priority, true}) == 0) break;
  }
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ending_ || task_; });
    if (ending_) return;
    task_();
    task_ = nullptr;
    changed_.notify_all();
  }
}

}  // namespace ctn::os
