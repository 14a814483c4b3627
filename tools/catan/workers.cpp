#include "workers.h"

#include <utility>

namespace ctn::tool {

Workers::Workers(os::Os& os, int count, std::function<Status()> join, std::function<void(Nanos)> work)
    : os_(os),
      join_(std::move(join)),
      work_(std::move(work)),
      joining_(static_cast<std::uint32_t>(count)),
      calls_(static_cast<std::size_t>(count)) {
  for (std::size_t index = 0; index < calls_.size(); ++index) {
    threads_.push_back(os_.spawn("catan-worker", [this, index] { live(index); }));
  }
}

Workers::~Workers() {
  stopping_.store(true, std::memory_order_release);
  for (std::atomic<std::uint32_t>& calls : calls_) {
    calls.fetch_add(1, std::memory_order_release);
    os_.wake(calls);
  }
}

void Workers::live(std::size_t index) {
  const Status joined = join_();
  {
    const std::lock_guard lock(mutex_);
    if (joined_) joined_ = joined;
  }
  if (joining_.fetch_sub(1, std::memory_order_acq_rel) == 1) os_.wake(joining_);
  for (std::uint32_t calls = 0;; ++calls) {
    os_.wait(calls_[index], calls, kNever);
    if (stopping_.load(std::memory_order_acquire)) return;
    work_(cpu_);
    if (working_.fetch_sub(1, std::memory_order_acq_rel) == 1) os_.wake(working_);
  }
}

void Workers::wait_until_zero(const std::atomic<std::uint32_t>& left) {
  for (;;) {
    const std::uint32_t now = left.load(std::memory_order_acquire);
    if (now == 0) return;
    os_.wait(left, now, kNever);
  }
}

Status Workers::joined() {
  wait_until_zero(joining_);
  const std::lock_guard lock(mutex_);
  return joined_;
}

void Workers::begin(int helpers, Nanos cpu) {
  cpu_ = cpu;
  working_.store(static_cast<std::uint32_t>(helpers), std::memory_order_release);
  for (std::size_t index = 0; index < static_cast<std::size_t>(helpers); ++index) {
    calls_[index].fetch_add(1, std::memory_order_release);
    os_.wake(calls_[index]);
  }
}

void Workers::finish() { wait_until_zero(working_); }

}  // namespace ctn::tool
