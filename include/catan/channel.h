// How a node's output reaches a successor in the same process: one channel an edge, one writer, one reader.
//
// Wait-free on both sides: a thread that is pre-empted inside a call never holds up the other, whatever their
// priorities. What a run writes is published when the run ends (and never, if the run skips its output); what a run
// reads is noted as consumed by it, which is how Catan knows which input an output goes back to.
//
//   Channel<T>       the newest value (input: latest). Three buffers; T must be default-constructible and movable.
//   QueueChannel<T>  every value, in order (input: queue). Bounded; when it is full the newest is dropped and counted.
//
// Thread safety: write by the producer's run, read by the consumer's run, nothing else. In the run of another node a
// write does nothing and a read gives nothing; a notice says so (`channel-misuse`, once a channel).
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "catan/run.h"

namespace ctn {

class ChannelBase {
 public:
  // `input`: which of the consumer's inputs this is.
  explicit ChannelBase(std::uint32_t input) : input_(input) {}
  virtual ~ChannelBase() = default;
  ChannelBase(const ChannelBase&) = delete;
  ChannelBase& operator=(const ChannelBase&) = delete;

  // Values lost because the reader did not keep up; always 0 for a latest channel, which loses nothing that counts.
  virtual std::uint64_t dropped() const { return 0; }

 protected:
  // Whether it is the run of the node that writes here, or of the one that reads. If it is not, nothing may be done;
  // the mistake is noted.
  bool may_write(const Run& run) {
    const bool may = run.node_ == producer_ || producer_ == kAnyNode;
    if (!may) note_misuse(run, true);
    return may;
  }
  bool may_read(const Run& run) {
    const bool may = (run.node_ == consumer_ || consumer_ == kAnyNode) && input_ < run.inputs_.size();
    if (!may) note_misuse(run, false);
    return may;
  }
  void stage(Run& run) { run.written_.push_back(this); }
  // What a value goes back to (Run::age()).
  using Origin = Run::Origin;
  void consume(Run& run, std::uint64_t first, std::uint64_t last, Origin origin) const {
    run.inputs_[input_] = {first, last, origin};
  }
  Origin consumed_origin(const Run& run) const { return run.inputs_[input_].origin; }

 private:
  friend class Run;
  friend class RunAccess;
  virtual void publish(std::uint64_t run_number, Origin origin) = 0;
  virtual void discard() = 0;
  // What the run takes goes back to; Run::age() says which values those are.
  virtual Origin take_origin(Run& run) = 0;

  // The first mistake is kept until it is told.
  static constexpr std::uint64_t kNoMisuse = ~std::uint64_t{0};
  static constexpr std::uint64_t kToldMisuse = kNoMisuse - 1;
  void note_misuse(const Run& run, bool writes) {
    std::uint64_t none = kNoMisuse;
    misuse_.compare_exchange_strong(none, std::uint64_t{run.node_} << 1U | (writes ? 1U : 0U),
                                    std::memory_order_relaxed);
  }

  static constexpr std::uint32_t kAnyNode = Run::kNoNode - 1;
  std::uint32_t input_;
  std::uint32_t producer_ = kAnyNode;
  std::uint32_t consumer_ = kAnyNode;
  std::atomic<std::uint64_t> misuse_{kNoMisuse};  // the node, and a bit: whether it writes
};

// Makes a channel of whatever type: for those who open channels by name.
using MakeChannel = std::unique_ptr<ChannelBase> (*)(std::uint32_t input);

template <class C>
std::unique_ptr<ChannelBase> make_channel(std::uint32_t input) {
  return std::make_unique<C>(input);
}

template <class T>
class Channel final : public ChannelBase {
 public:
  using ChannelBase::ChannelBase;

  // A second write in one run replaces the first.
  void write(Run& run, T value) {
    if (!may_write(run)) return;
    buffers_[back_].value = std::move(value);
    if (!staged_) stage(run);
    staged_ = true;
  }

  // The newest value at the first read of this run, the same again at later ones; null until there is one. Valid until
  // the run ends.
  const T* read(Run& run) {
    if (!may_read(run)) return nullptr;
    if (read_in_ != run.number()) {
      read_in_ = run.number();
      if ((middle_.load(std::memory_order_acquire) & kFresh) != 0) {
        front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
      }
    }
    const Buffer& newest = buffers_[front_];
    if (newest.run == 0) return nullptr;
    consume(run, newest.run, newest.run, newest.origin);
    return &newest.value;
  }

 private:
  struct Buffer {
    T value{};
    std::uint64_t run = 0;  // which run wrote it; 0: none yet
    Origin origin{0};
  };
  static constexpr std::uint32_t kIndex = 3;
  static constexpr std::uint32_t kFresh = 4;

  void publish(std::uint64_t run_number, Origin origin) override {
    staged_ = false;
    buffers_[back_].run = run_number;
    buffers_[back_].origin = origin;
    back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }
  void discard() override { staged_ = false; }
  Origin take_origin(Run& run) override {
    read(run);
    return consumed_origin(run);
  }

  std::array<Buffer, 3> buffers_{};
  std::atomic<std::uint32_t> middle_{1};
  alignas(64) std::uint32_t back_ = 0;  // the writer's
  bool staged_ = false;
  alignas(64) std::uint32_t front_ = 2;  // the reader's
  std::uint64_t read_in_ = 0;
};

template <class T>
class QueueChannel final : public ChannelBase {
 public:
  static constexpr std::size_t kCapacity = 4096;

  explicit QueueChannel(std::uint32_t input) : ChannelBase(input), items_(kCapacity) {}

  // May be called several times in a run; all its values are published together.
  void write(Run& run, T value) {
    if (!may_write(run)) return;
    if (pending_.empty()) stage(run);
    pending_.push_back(std::move(value));
  }

  // The next value that was published before this call; none when all are taken.
  std::optional<T> take(Run& run) {
    if (!may_read(run)) return std::nullopt;
    const std::uint64_t taken = taken_.load(std::memory_order_relaxed);
    if (taken == published_.load(std::memory_order_acquire)) return std::nullopt;
    Item& item = items_[taken % kCapacity];
    if (taking_in_ != run.number()) {
      taking_in_ = run.number();
      first_taken_ = item.run;
      oldest_taken_ = item.origin;
    }
    oldest_taken_ = std::min(oldest_taken_, item.origin);
    consume(run, first_taken_, item.run, oldest_taken_);
    std::optional<T> value = std::move(item.value);
    taken_.store(taken + 1, std::memory_order_release);
    return value;
  }

  std::uint64_t dropped() const override { return dropped_.load(std::memory_order_relaxed); }

 private:
  struct Item {
    T value{};
    std::uint64_t run = 0;
    Origin origin{0};
  };

  void publish(std::uint64_t run_number, Origin origin) override {
    std::uint64_t published = published_.load(std::memory_order_relaxed);
    for (T& value : pending_) {
      if (published - taken_.load(std::memory_order_acquire) == kCapacity) {
        dropped_.fetch_add(1, std::memory_order_relaxed);
        continue;
      }
      items_[published % kCapacity] = {std::move(value), run_number, origin};
      published_.store(++published, std::memory_order_release);
    }
    pending_.clear();
  }
  void discard() override { pending_.clear(); }
  Origin take_origin(Run& run) override {
    const std::uint64_t taken = taken_.load(std::memory_order_relaxed);
    const bool waits = taken != published_.load(std::memory_order_acquire);
    return taking_in_ != run.number() && waits ? items_[taken % kCapacity].origin : consumed_origin(run);
  }

  std::vector<Item> items_;
  std::vector<T> pending_;  // the writer's, until its run ends
  std::atomic<std::uint64_t> dropped_{0};
  alignas(64) std::atomic<std::uint64_t> published_{0};
  alignas(64) std::atomic<std::uint64_t> taken_{0};
  std::uint64_t taking_in_ = 0;  // the reader's
  std::uint64_t first_taken_ = 0;
  Origin oldest_taken_{0};
};

}  // namespace ctn
