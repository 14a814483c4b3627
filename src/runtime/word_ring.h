// A bounded queue of fixed-size records from one thread to one other, wait-free on both sides: how nodes and trigger
// threads report without ever waiting for whoever reads the reports.
//
// A record is a row of 64-bit words. Storage is one flat block, so that it can lie in memory shared between processes.
// Thread safety: one producer, one consumer.
#pragma once

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ctn::runtime {

class WordRing {
 public:
  WordRing(std::size_t capacity, std::size_t words_per_record)
      : capacity_(capacity), stride_(words_per_record), words_(capacity * words_per_record) {}

  // False: full, and the record is lost; `lost()` counts it. Precondition: record.size() == words_per_record.
  bool push(std::span<const std::uint64_t> record) {
    assert(record.size() == stride_);
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == capacity_) {
      lost_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    std::copy(record.begin(), record.end(), at(head));
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  // Calls take(span of the record's words) for each record pushed before the call, oldest first. Returns how many.
  template <class Take>
  std::size_t drain(Take&& take) {
    const std::uint64_t head = head_.load(std::memory_order_acquire);
    std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    const auto count = static_cast<std::size_t>(head - tail);
    for (; tail != head; ++tail) {
      take(std::span<const std::uint64_t>(at(tail), stride_));
      tail_.store(tail + 1, std::memory_order_release);
    }
    return count;
  }

  std::uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }

 private:
  std::uint64_t* at(std::uint64_t index) { return words_.data() + (index % capacity_) * stride_; }

  std::size_t capacity_;
  std::size_t stride_;
  std::vector<std::uint64_t> words_;
  alignas(64) std::atomic<std::uint64_t> head_{0};
  alignas(64) std::atomic<std::uint64_t> tail_{0};
  alignas(64) std::atomic<std::uint64_t> lost_{0};
};

}  // namespace ctn::runtime
