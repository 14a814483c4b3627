// An ordinary program that wants all the CPU time it can get: burns until the end of the scope.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <utility>

#include "os/fake/fake_os.h"

namespace ctn::os {

// Made and destroyed by threads of `os`. The destructor joins: it returns once the thread has had the rest of its last
// `piece`, so never while a higher level leaves it no CPU. It starts on its maker's CPUs, at the ordinary level, and
// takes CPUs and level of its own when it first runs.
class BusyThread {
 public:
  BusyThread(FakeOs& os, const std::string& name, const CpuSet& cpus, Level level = Level::kOrdinary,
             Nanos piece = std::chrono::milliseconds(1))
      : thread_(os.spawn(name, [this, &os, cpus, level, piece] {
          ready_ = os.set_affinity(os.current_thread(), cpus).ok() && os.set_level(os.current_thread(), level).ok();
          while (!stop_) os.burn(piece);
        })) {}
  ~BusyThread() {
    stop_ = true;
    thread_->join();
  }
  BusyThread(const BusyThread&) = delete;
  BusyThread& operator=(const BusyThread&) = delete;

  // It has run, and has the CPUs and the level that were asked.
  bool ready() const { return ready_; }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<bool> ready_{false};
  std::unique_ptr<Thread> thread_;
};

}  // namespace ctn::os
