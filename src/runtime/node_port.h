// A node's end of the region (region.h): it waits for its trigger there and reports its runs there. All that a node
// does on the hot path is in this file, word_ring.h and report.h: atomics, one futex wait and at most two wakes a run
// (of an unscheduled node and a tail: one a follower, and of a tail one for its controller), no lock, no allocation, no
// call to the scheduler.
//
// A trigger carries a token: the number of the subchain's trigger that it goes back to. A head gets it from its
// controller, the others from their predecessor in the subchain when that ends a run with output. The tail (or a node
// that gives no output) hands it to the SignalCell, which is how the controller knows what is under way. The tail also
// counts its outputs there, and wakes the controllers of subchains that follow them.
//
// An unscheduled node that follows another has no subchain and no token: its word counts the outputs of the other,
// which raises the word and wakes the follower. Outputs that come while the follower is busy start it once more,
// however many they are. A process that writes there without a reason can wake the follower too often, and do no other
// harm. While the other node gives no output, or is missing, the follower waits.
//
// Age of data (record/ages.h): each output carries its origin, over a channel beside the value, else in the node's
// cell, which holds the origins of the newest outputs by number, so that number and origin belong together. A run's own
// is the oldest of the origins that it consumed. One may be missing, because more outputs came at once than the cell
// holds, or because another process wrote nonsense. Then that of what was consumed before is taken, which is older
// unless the predecessor reads its inputs only now and then; if there is none, the clock's zero.
//
// Order at the end of a run: report, then publish, then trigger. So a report is never later in its ring than the report
// of a run that consumed its output, which the collector relies on.
//
// CPU time of a run: where the node's own thread is its only one and comes straight back to wait, a run is counted from
// the end of the one before. So the time that it takes to pass on, to wait and to be woken is counted, and one reading
// of the thread's clock, the most expensive part of a report, serves both runs. A thread that comes back later has done
// something else in between: its run is counted from when it began to wait. Where other threads work for the node, and
// where it did not wait for a trigger, begin() reads the clocks. What a run waits: wait_watch.h.
//
// A run that is to work on several threads is timed, too: from its begin to its end, less what it waited and while the
// node's own thread was ready but others had its core, where the system tells. What kept the threads that help is in
// it.
//
// Units: Nanos. Thread safety: as each function says.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "base/run_access.h"
#include "catan/awaited.h"
#include "catan/run.h"
#include "graph/app.h"
#include "os/os.h"
#include "runtime/cpu_times.h"
#include "runtime/region.h"
#include "runtime/wait_watch.h"

namespace ctn::runtime {

class NodePort {
 public:
  // All references outlive it.
  NodePort(os::Os& os, const graph::Graph& graph, NodeId node, const Region& region);

  // --- before any thread runs ---
  // An input has a channel, which notes what is consumed. Without one, a run is taken to consume the predecessor's
  // newest output when it begins; a run of a queue node, all outputs since the run before.
  void set_channel(std::size_t input, ChannelBase& channel) { runs_.set_channel(input, channel); }

  // --- the node's own thread ---
  // Straight back is a thread that waits again this soon after the end of a run.
  static constexpr Nanos kStraightBack = std::chrono::microseconds{50};
  // Blocks until a trigger comes, or output of the node that this one follows; false: `stop` was called. For an
  // unscheduled node that follows none there is nothing to wait for: its thread has a period of its own.
  bool wait_for_trigger() { return runs_.await(false) == Awaited::kTrigger; }
  // The same, and returns at once while the subchain is let go of (incomplete_subchains.h). What triggers it then, a
  // run that was under way or a program without a server, is passed over.
  Awaited await() { return runs_.await(true); }
  // Blocks while it is let go of; false: `stop` was called.
  bool await_complete() { return runs_.await_complete(); }
  void begin(Run& run) { runs_.begin(run); }
  // Between begin() and end(): of an input without a channel, which outputs the run takes, where that is known. What
  // has not been given yet does not count.
  void take(Run& run, std::string_view from, std::uint64_t first, std::uint64_t last) {
    runs_.take(run, from, first, last);
  }
  void end(Run& run) { runs_.end(run); }

  // Of an unscheduled node that follows none. False: `stop` was called, which ends the wait.
  bool wait_until(TimePoint due);

  // --- any thread ---
  void stop();
  bool stopping() const { return shared_.stopping.load(std::memory_order_acquire); }

  // --- without a scheduler: for one thread that is not the node's ---
  // Moves the node to `region` at its next trigger: another scheduler has taken over from one that is gone. The old
  // region is in use until the node has moved, see uses().
  // Its app is the node's own, maybe in other subchains; it outlives the use.
  void move_to(const Region& region, const graph::Graph& graph);
  bool uses(const Region& region) const;
  // Wakes the node if it has not noticed yet that it was moved: a write by another process at the same moment can make
  // it miss the wake. To be called now and then.
  void wake_if_moved() const;
  // The same at once, while no thread runs the node.
  void bind_to(const Region& region, const graph::Graph& graph);
  // Triggers the node, which is its subchain's head. False: the run before has not ended yet; the node is woken all the
  // same, in case that the process that triggered that run is gone and did not wake it.
  bool trigger_locally();
  // The run under way counts as ended: the program that was to end it is gone.
  void abandon_run();

 private:
  // What the node needs of a region.
  struct Binding {
    Binding(const graph::Graph& graph, NodeId node, const Region& region, std::uint64_t number);

    std::uint64_t number;  // of all bindings of the node; the first is 1
    const Region* region;
    NodeCell* own;
    std::vector<NodeCell*> predecessors;  // by input; null where it is external
    NodeCell* next = nullptr;             // in the subchain; null for its tail
    std::vector<NodeCell*> followers;     // of an unscheduled node
    SignalCell* signal = nullptr;         // null for an unscheduled node
    RingWriter reports;
  };

  // What the node's thread and others share. What `newest` points to stays. What `in_use` points to stays from when the
  // node, having written it, has found that it is the newest still: both sides write one and read the other, all of it
  // sequentially consistent, so that either the node sees a newer one, or the thread that makes another sees what is in
  // use. Until then it may be gone.
  struct Shared {
    std::atomic<bool> stopping{false};
    std::atomic<const Binding*> newest{nullptr};
    std::atomic<const Binding*> in_use{nullptr};  // a run may be under way in it
  };

  // The node's runs. What it holds is the node's thread's alone.
  class Runs {
   public:
    Runs(os::Os& os, const graph::Graph& graph, NodeId node, Shared& shared);

    void set_channel(std::size_t input, ChannelBase& channel) { edges_[input].channel = &channel; }
    // Goes by the newest binding from now on.
    void follow_move();
    // `asks`: it is to return when the subchain is let go of.
    Awaited await(bool asks);
    bool await_complete();
    void begin(Run& run);
    void take(Run& run, std::string_view from, std::uint64_t first, std::uint64_t last);
    void end(Run& run);

   private:
    void bind(const Binding& binding);
    // The node's word, once it is of the newest binding; empty: `stop` was called.
    std::optional<std::uint32_t> word_unless_stopped();
    bool is_let_go() const;
    void go_by(std::uint32_t word);
    void consume_newest(Run& run);
    void consume_newest(Run& run, std::size_t input, const NodeCell& predecessor);
    RunAccess::Origin settle_ages(Run& run);
    void pass_on(bool emits);
    int threads_planned() const;
    Nanos ready_time();
    bool has_other_threads() const;
    void read_other_threads();

    os::Os& os_;
    const NodeId id_;
    const graph::Node& node_;
    const bool is_source_;
    const bool paces_itself_;  // its thread says when it runs
    Shared& shared_;
    const Binding* binding_ = nullptr;         // gone, if it is not the one in use any more
    std::uint64_t bound_ = 0;                  // its number
    std::vector<RunAccess::InputEdge> edges_;  // by input
    std::vector<std::uint64_t> words_;         // one report, reused
    std::vector<std::uint64_t> taken_;         // by input: the newest run consumed so far, where there is no channel
    std::vector<RunAccess::Origin> origins_;   // by input: of what was consumed last
    RunAccess::Origin origin_ = RunAccess::kNoOrigin;  // found by the last run that consumed anything
    std::int32_t thread_ = 0;
    std::uint64_t token_ = 0;
    std::uint64_t number_ = 0;
    TimePoint begin_{};
    TimePoint end_{};             // of the run before
    bool has_waited_ = false;     // for the run that is to begin
    bool counted_early_ = false;  // from before its begin
    Nanos begin_cpu_{0};          // of its own thread
    CpuTimes others_;             // of the node's other threads, in the run under way
    Nanos begin_ready_{0};        // of its own thread, where the run is to work on several
    WaitWatch wait_;
    std::optional<Nanos> own_cpu_;  // of its own thread, where the next run is counted from; none: from its begin
  };

  void add_binding(const Region& region, const graph::Graph& graph);
  const Binding* in_use() const;
  const Binding& newest() const { return *shared_.newest.load(std::memory_order_acquire); }

  os::Os& os_;
  const NodeId node_;
  std::vector<std::unique_ptr<const Binding>> bindings_;  // all that are in use, and the newest
  std::uint64_t made_ = 0;
  Shared shared_;
  Runs runs_;
};

}  // namespace ctn::runtime
