// The scheduler's end of a node's part of the region (region.h): its threads, its trigger, its reports. The node may be
// of another process, and what it writes may be anything; what the scheduler must rely on stands here.
//
// Units: Nanos. Thread safety: threads may be added and removed at any time, from any thread, while controllers visit
// them. Removing one waits until no visit is under way, so that what a visitor does to a thread has been done by then.
// trigger() and is_triggered() are for the controller that holds the subchain, the rest for the housekeeping thread.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "graph/app.h"
#include "os/os.h"
#include "record/events.h"
#include "runtime/region.h"
#include "runtime/report.h"

namespace ctn::runtime {

class NodeLink {
 public:
  // All references outlive it.
  NodeLink(os::Os& os, const graph::Graph& graph, NodeId node, const Region& region);

  NodeId node() const { return node_; }

  // --- threads ---
  // The node's program sees in the region which threads the server may have raised, and lowers them where the server
  // was killed. So it sees a thread before anything is done to it, and until that has been undone.
  // Announced: the program sees it, visits do not. False: there is no room for another.
  bool announce_thread(os::ThreadId thread);
  // Of one that was announced, and then not added.
  void withdraw_thread(os::ThreadId thread);
  // Announces it, too, where that was not done. False: there is no room for another.
  bool add_thread(os::ThreadId thread);
  // `restore` is called with each that was there, when no visit sees it any more. Not from a visit.
  using Restore = std::function<void(os::ThreadId)>;
  void remove_thread(os::ThreadId thread, const Restore& restore);
  void remove_all_threads(const Restore& restore);
  std::vector<os::ThreadId> threads() const;
  bool has(os::ThreadId thread) const;
  // The same without a copy.
  template <class Visit>
  void for_each_thread(Visit&& visit) const {
    for_each_slot([&](std::size_t, os::ThreadId thread) { visit(thread); });
  }
  // With their CPU clocks; without threads whose clock could not be made.
  template <class Visit>
  void for_each_clock(Visit&& visit) const {
    for_each_slot([&](std::size_t index, os::ThreadId thread) {
      if (os::CpuClock* const clock = clocks_[index].get()) visit(thread, *clock);
    });
  }
  // Counts threads that were added.
  std::uint32_t threads_joined() const { return joined_.load(std::memory_order_acquire); }

  // --- triggers ---
  void trigger(std::uint64_t token);
  // Without a trigger: it looks again what is said of its subchain.
  void wake();
  // Whether this is the node's newest trigger. The node may have written it.
  bool is_triggered(std::uint64_t token) const;

  // --- reports ---
  // Calls take(record::Run) for each run reported so far, oldest first.
  template <class Take>
  void drain(Take&& take) {
    reports_.drain([&](std::span<const std::uint64_t> words) { take(decode_report(node_, predecessors_, words)); });
  }
  std::uint64_t lost_reports() const { return reports_.lost(); }
  std::uint64_t broken_rings() const { return reports_.broken(); }

 private:
  template <class Visit>
  void for_each_slot(Visit&& visit) const {
    // Sequentially consistent on both sides: either the visitor sees that a thread is gone, or the thread that removes
    // it sees the visitor.
    visitors_.fetch_add(1, std::memory_order_seq_cst);
    const std::size_t count = used_.load(std::memory_order_acquire);
    for (std::size_t index = 0; index < count; ++index) {
      const std::int32_t thread = threads_[index].load(std::memory_order_seq_cst);
      if (thread != 0) visit(index, os::ThreadId{thread});
    }
    visitors_.fetch_sub(1, std::memory_order_seq_cst);
  }
  enum class Place : std::uint8_t { kFree, kAnnounced, kAdded, kLeaving };

  template <class IsMeant>
  void remove_if(const IsMeant& is_meant, const Restore& restore);
  // Under the lock.
  std::optional<std::size_t> announced_at(os::ThreadId thread) const;
  std::optional<std::size_t> announce(os::ThreadId thread);
  void publish_threads();
  void wait_for_visitors() const;

  os::Os& os_;
  NodeId node_;
  std::vector<NodeId> predecessors_;
  NodeCell& cell_;
  RingReader reports_;
  std::mutex mutex_;  // of callers that change the threads
  // Under the lock: what is at each place, and whose it is unless it is free.
  std::array<Place, NodeCell::kMaxThreads> places_{};
  std::array<std::int32_t, NodeCell::kMaxThreads> owners_{};
  std::array<std::atomic<std::int32_t>, NodeCell::kMaxThreads> threads_{};  // that were added, for visits; 0: none
  // Theirs. One that is leaving has its clock until no visit sees it any more.
  std::array<std::unique_ptr<os::CpuClock>, NodeCell::kMaxThreads> clocks_;
  std::atomic<std::size_t> used_{0};  // none was added from here on
  std::atomic<std::uint32_t> joined_{0};
  mutable std::atomic<std::uint32_t> visitors_{0};
};

// The nodes of a subchain and its signal, as a controller sees them.
struct SubchainLinks {
  std::vector<NodeLink*> nodes;  // in the order they run
  SignalCell* signal = nullptr;

  // Triggers the head with this number. A run that has not begun has not ended, whatever the region says; otherwise
  // this run would count as ended at once. But a program that triggers its nodes itself, as long as it does not know
  // that the server goes on, may have used the number just before: that run counts as this one, since the node does not
  // see a trigger of the number that it is at.
  void trigger(std::uint64_t number) const;
};

// By NodeId; null for an external node.
using Links = std::vector<std::unique_ptr<NodeLink>>;
Links links_of(os::Os& os, const graph::Graph& graph, const Region& region);
// By SubchainId.
std::vector<SubchainLinks> subchain_links(const graph::Graph& graph, const Links& links, const Region& region);

}  // namespace ctn::runtime
