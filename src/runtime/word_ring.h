// A bounded queue of fixed-size records from one thread to one other, wait-free on both sides: how nodes and
// controllers report without ever waiting for the reader of the reports.
//
// A record is a row of 64-bit words. The queue itself is plain memory (RingHeader and the words), so that it can lie
// between two processes; its two ends are objects of their own. The reader believes nothing that it finds there: it
// keeps its position to itself, and takes no more than the queue can hold, whatever the memory says.
//
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

// All zero at first.
struct RingHeader {
  alignas(64) std::atomic<std::uint64_t> pushed{0};
  alignas(64) std::atomic<std::uint64_t> drained{0};
  alignas(64) std::atomic<std::uint64_t> lost{0};
};

class RingWriter {
 public:
  // Precondition: words.size() is a multiple of `words_per_record`. Both outlive it.
  RingWriter(RingHeader& header, std::span<std::uint64_t> words, std::size_t words_per_record)
      : header_(&header), words_(words), stride_(words_per_record), capacity_(words.size() / words_per_record) {}

  // False: full, and the record is lost, which is counted. Precondition: record.size() == words_per_record.
  bool push(std::span<const std::uint64_t> record) const {
    assert(record.size() == stride_);
    const std::uint64_t pushed = header_->pushed.load(std::memory_order_relaxed);
    if (pushed - header_->drained.load(std::memory_order_acquire) >= capacity_) {
      header_->lost.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    std::copy(record.begin(), record.end(), words_.begin() + static_cast<std::ptrdiff_t>(pushed % capacity_ * stride_));
    header_->pushed.store(pushed + 1, std::memory_order_release);
    return true;
  }

 private:
  RingHeader* header_;
  std::span<std::uint64_t> words_;
  std::size_t stride_;
  std::size_t capacity_;
};

class RingReader {
 public:
  RingReader(RingHeader& header, std::span<const std::uint64_t> words, std::size_t words_per_record)
      : header_(&header),
        words_(words),
        stride_(words_per_record),
        capacity_(words.size() / words_per_record),
        record_(words_per_record) {}

  // Calls take(span of the record's words) for each record pushed before the call, oldest first. The words are the
  // reader's own copy. Returns how many.
  template <class Take>
  std::size_t drain(Take&& take) {
    const std::uint64_t pushed = header_->pushed.load(std::memory_order_acquire);
    if (pushed - drained_ > capacity_) {  // no producer of ours does that
      ++broken_;
      drained_ = pushed;
      header_->drained.store(drained_, std::memory_order_release);
      return 0;
    }
    const auto count = static_cast<std::size_t>(pushed - drained_);
    for (; drained_ != pushed; ++drained_) {
      const auto at = words_.begin() + static_cast<std::ptrdiff_t>(drained_ % capacity_ * stride_);
      std::copy(at, at + static_cast<std::ptrdiff_t>(stride_), record_.begin());
      header_->drained.store(drained_ + 1, std::memory_order_release);
      take(std::span<const std::uint64_t>(record_));
    }
    return count;
  }

  std::uint64_t lost() const { return header_->lost.load(std::memory_order_relaxed); }
  // How often the queue made no sense and was emptied unread.
  std::uint64_t broken() const { return broken_; }

 private:
  RingHeader* header_;
  std::span<const std::uint64_t> words_;
  std::size_t stride_;
  std::size_t capacity_;
  std::vector<std::uint64_t> record_;
  std::uint64_t drained_ = 0;
  std::uint64_t broken_ = 0;
};

// A queue with memory of its own, between threads of one process.
class WordRing {
 public:
  WordRing(std::size_t capacity, std::size_t words_per_record)
      : words_(capacity * words_per_record),
        writer_(header_, words_, words_per_record),
        reader_(header_, words_, words_per_record) {}
  WordRing(const WordRing&) = delete;
  WordRing& operator=(const WordRing&) = delete;

  bool push(std::span<const std::uint64_t> record) { return writer_.push(record); }
  template <class Take>
  std::size_t drain(Take&& take) {
    return reader_.drain(std::forward<Take>(take));
  }
  std::uint64_t lost() const { return reader_.lost(); }

 private:
  RingHeader header_;
  std::vector<std::uint64_t> words_;
  RingWriter writer_;
  RingReader reader_;
};

}  // namespace ctn::runtime
