// Threads that help a node's own with its runs: each does the same amount of work at the same time.
//
// Thread safety: begin and finish from one thread, in turn.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "os/os.h"

namespace ctn::tool {

class Workers {
 public:
  // Each thread calls `join` first, and then `work` whenever it is to. `os` and what the functions use outlive it.
  Workers(os::Os& os, int count, std::function<Status()> join, std::function<void(Nanos)> work);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int count() const { return static_cast<int>(threads_.size()); }
  // What the first `join` that failed gave. Waits until all have called it.
  Status joined();

  // `helpers` of them (1 to count) call work(cpu); finish() waits until they have.
  void begin(int helpers, Nanos cpu);
  void finish();

 private:
  void live(std::size_t index);
  void wait_until_zero(const std::atomic<std::uint32_t>& left);

  os::Os& os_;
  std::function<Status()> join_;
  std::function<void(Nanos)> work_;
  Nanos cpu_{0};
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint32_t> joining_;
  std::atomic<std::uint32_t> working_{0};
  std::deque<std::atomic<std::uint32_t>> calls_;  // by worker: how often it was called
  std::mutex mutex_;
  Status joined_ = Done{};
  std::vector<std::unique_ptr<os::Thread>> threads_;
};

}  // namespace ctn::tool
