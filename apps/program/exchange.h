// How values pass between a world's thread and the nodes' threads, which may have real-time priorities: without locks,
// so that neither waits for the other.
//
//   Newest<T>     one writer, one reader, who sees the newest value
//   Events<T>     one writer, one reader, who takes all in order; full: the newest is lost, and counted
//
// Thread safety: as said; the writer calls write(), the reader the rest.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

namespace ctn::program {

template <class T>
class Newest {
 public:
  void write(T value) {
    values_[back_] = std::move(value);
    back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }
  // What T() is until there is one. Valid until the next call.
  const T& read() {
    if ((middle_.load(std::memory_order_acquire) & kFresh) != 0) {
      front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    }
    return values_[front_];
  }

 private:
  static constexpr std::uint32_t kIndex = 3;
  static constexpr std::uint32_t kFresh = 4;
  std::array<T, 3> values_{};
  std::atomic<std::uint32_t> middle_{1};
  std::uint32_t back_ = 0;   // the writer's
  std::uint32_t front_ = 2;  // the reader's
};

template <class T>
class Events {
 public:
  static constexpr std::size_t kCapacity = 1024;

  void write(T value) {
    const std::uint64_t written = written_.load(std::memory_order_relaxed);
    if (written - taken_.load(std::memory_order_acquire) == kCapacity) {
      lost_.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    values_[written % kCapacity] = std::move(value);
    written_.store(written + 1, std::memory_order_release);
  }
  std::optional<T> take() {
    const std::uint64_t taken = taken_.load(std::memory_order_relaxed);
    if (taken == written_.load(std::memory_order_acquire)) return std::nullopt;
    std::optional<T> value = std::move(values_[taken % kCapacity]);
    taken_.store(taken + 1, std::memory_order_release);
    return value;
  }
  std::uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }

 private:
  std::array<T, kCapacity> values_{};
  std::atomic<std::uint64_t> written_{0};
  std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::uint64_t> lost_{0};
};

}  // namespace ctn::program
