// The thread of a server that the guardian monitors: its end is the server's. Inside os/linux only.
//
// A process that is killed is gone only when each of its threads has had a CPU to end on, which takes an ordinary
// thread a second where real-time threads of others keep all CPUs busy. This thread is above all levels, so it ends at
// once, and the kernel tells the children that it forked (PR_SET_PDEATHSIG).
//
// Thread safety: one thread at a time.
#pragma once

#include <array>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace ctn::os {

// Above all levels of os.h; the second, for where the first is not permitted, with the highest of them.
extern const std::array<int, 2> kPrioritiesAboveAll;

class MonitoredThread {
 public:
  // Throws std::system_error when the system has no thread left.
  MonitoredThread();
  ~MonitoredThread();
  MonitoredThread(const MonitoredThread&) = delete;
  MonitoredThread& operator=(const MonitoredThread&) = delete;

  // Has the thread do something, and waits for that.
  void call(std::function<void()> task);

 private:
  void serve();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::function<void()> task_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace ctn::os
