// A node's connection to the runtime: it waits for its trigger there and reports its runs there. All that the hot path
// touches is in this file and word_ring.h: atomics, one futex wait and at most two wakes a run, no lock, no allocation.
//
// A trigger carries a token: the number of the subchain's trigger that it goes back to. A head gets it from its trigger
// thread, the others from their predecessor in the subchain when that ends a run with output. The tail (or whoever
// gives no output) hands it to `SubchainSignal`, which is how the trigger thread knows what is under way.
//
// Order at the end of a run: report, then publish, then trigger. So a report is never later in its ring than the report
// of a run that consumed its output, which the collector relies on.
//
// Units: Nanos. Thread safety: as each function says.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "catan/run.h"
#include "graph/app.h"
#include "os/os.h"
#include "record/events.h"
#include "runtime/word_ring.h"

namespace ctn::runtime {

// What a controller (controller.h) sleeps on.
struct Attention {
  alignas(64) std::atomic<std::uint32_t> word{0};

  // Wakes it, for it to look at everything anew.
  void nudge(os::Os& os);
};

// Between the nodes of a subchain and the controller that holds it.
struct SubchainSignal {
  std::atomic<std::uint64_t> completed{0};       // the newest token whose run has ended
  std::atomic<Attention*> listener{nullptr};     // who holds the subchain
  std::atomic<bool> wants_completions{false};    // only then is the holder woken when a run ends
  std::atomic<std::uint32_t> threads_joined{0};  // counts threads that joined a node later

  // Called by nodes.
  void complete(os::Os& os, std::uint64_t token);
  // A thread has joined one of the subchain's nodes: its holder is to give it its level.
  void thread_joined(os::Os& os);
};

class NodePort {
 public:
  static constexpr std::size_t kReports = 4096;
  static constexpr std::size_t kMaxThreads = 64;

  NodePort(os::Os& os, const graph::Graph& graph, NodeId node);

  // --- wiring, before any thread runs ---
  // Which port feeds input `slot`; null where the predecessor is external.
  void connect_input(std::size_t slot, const NodePort* predecessor) { predecessors_[slot] = predecessor; }
  // Whether input `slot` has a channel, which then notes what is consumed; else a run consumes the newest output at its
  // begin.
  void set_channel(std::size_t slot) { has_channel_[slot] = true; }
  void connect_subchain(NodePort* next, SubchainSignal* signal) {
    next_ = next;
    signal_ = signal;
  }

  // --- the node's own thread ---
  // Blocks until a trigger comes; false: `stop` was called.
  bool wait_for_trigger();
  void begin(Run& run);
  void end(Run& run);

  // --- any thread ---
  void trigger(std::uint64_t token);
  void stop();
  bool stopping() const { return stopping_.load(std::memory_order_acquire); }
  // The newest run that gave output; 0: none.
  std::uint64_t newest_output() const { return newest_output_.load(std::memory_order_acquire); }
  // The node's threads: its own first. False: there is no room for another.
  bool add_thread(os::ThreadId thread);
  std::vector<os::ThreadId> threads() const;
  // The same without a copy.
  template <class Visit>
  void for_each_thread(Visit&& visit) const {
    const std::size_t count = std::min(thread_count_.load(std::memory_order_acquire), kMaxThreads);
    for (std::size_t index = 0; index < count; ++index) {
      const std::int32_t thread = threads_[index].load(std::memory_order_acquire);
      if (thread != 0) visit(os::ThreadId{thread});
    }
  }

  // --- the collector ---
  // Calls take(record::Run) for each run reported so far, oldest first.
  template <class Take>
  void drain(Take&& take) {
    reports_.drain([&](std::span<const std::uint64_t> words) { take(decode(words)); });
  }
  std::uint64_t lost_reports() const { return reports_.lost(); }

 private:
  static constexpr std::size_t kFixedWords = 5;  // number, begin, end, cpu, mode and emitted

  record::Run decode(std::span<const std::uint64_t> words) const;
  void report(const Run& run, TimePoint end, Nanos cpu);
  Nanos cpu_time_of_all_threads();

  os::Os& os_;
  NodeId node_;
  std::vector<NodeId> predecessor_ids_;
  std::vector<const NodePort*> predecessors_;
  std::vector<bool> has_channel_;
  NodePort* next_ = nullptr;
  SubchainSignal* signal_ = nullptr;
  WordRing reports_;
  std::vector<std::uint64_t> encoded_;  // one report, reused
  std::array<std::atomic<std::int32_t>, kMaxThreads> threads_{};
  std::atomic<std::size_t> thread_count_{0};
  std::atomic<bool> stopping_{false};

  // The node's own.
  std::uint64_t token_ = 0;
  std::uint64_t number_ = 0;
  TimePoint begin_{};
  Nanos begin_cpu_{0};

  alignas(64) std::atomic<std::uint32_t> word_{
      0};  // low half of the newest token; changes with every trigger and on stop
  alignas(64) std::atomic<std::uint64_t> newest_output_{0};
};

// The nodes of a subchain and its signal, as a controller sees them.
struct SubchainPorts {
  std::vector<NodePort*> ports;  // in the order they run
  SubchainSignal* signal = nullptr;
};

}  // namespace ctn::runtime
