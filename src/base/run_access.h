// The runtime's side of a Run: what its public face (include/catan/run.h) keeps to itself.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "catan/channel.h"
#include "catan/run.h"

namespace ctn {

class RunAccess {
 public:
  using Input = Run::Input;
  using InputEdge = Run::InputEdge;
  // What a value goes back to: the begin of the oldest source run (record/ages.h).
  using Origin = Run::Origin;
  static constexpr Origin kNoOrigin = Run::kNoOrigin;

  // Makes `run` ready for its next execution, with `inputs` inputs of which nothing is consumed yet.
  static void reset(Run& run, std::uint64_t number, std::size_t inputs) {
    run.number_ = number;
    run.mode_ = 0;
    run.emits_ = true;
    static_cast<void>(take_charge(run));
    run.inputs_.assign(inputs, Input{});
  }

  static void set_node(Run& run, NodeId node) { run.node_ = static_cast<std::uint32_t>(node.index()); }
  static void set_threads(Run& run, int threads) { run.threads_ = threads; }

  // For age(): when it begins, and its inputs by predecessor. `edges` outlives the run.
  static void begin(Run& run, TimePoint begin, const std::vector<InputEdge>& edges) {
    run.begin_ = begin.time_since_epoch();
    run.edges_ = &edges;
  }
  // What a run before it took last.
  static void set_taken_before(Run& run, std::size_t input, Origin origin) { run.inputs_[input].origin = origin; }
  // Consumes what is newest in the channels of inputs that have an age limit, queues aside: whether a run is stale is
  // then settled when it begins.
  static void take_limited(Run& run) {
    for (const InputEdge& edge : *run.edges_) {
      if (edge.channel != nullptr && !edge.queue && edge.max_age != Run::kNoInput) edge.channel->take_origin(run);
    }
  }

  static void consume(Run& run, std::size_t input, std::uint64_t first, std::uint64_t last, Origin origin) {
    run.inputs_[input] = {first, last, origin};
  }

  // From now on only runs of these two nodes may use it.
  static void connect(ChannelBase& channel, NodeId producer, NodeId consumer) {
    channel.producer_ = static_cast<std::uint32_t>(producer.index());
    channel.consumer_ = static_cast<std::uint32_t>(consumer.index());
  }
  // No run may.
  static void leave_unconnected(ChannelBase& channel) { channel.producer_ = channel.consumer_ = Run::kNoNode; }

  struct Misuse {
    std::optional<NodeId> node;  // none: a run of no node
    bool writes = false;
  };
  // The first use of the channel by a run that may not; told once. By one thread at a time.
  static std::optional<Misuse> take_misuse(ChannelBase& channel) {
    const std::uint64_t noted = channel.misuse_.load(std::memory_order_relaxed);
    if (noted >= ChannelBase::kToldMisuse) return std::nullopt;
    channel.misuse_.store(ChannelBase::kToldMisuse, std::memory_order_relaxed);
    const bool known = noted >> 1U != Run::kNoNode;
    return Misuse{known ? std::optional(NodeId(noted >> 1U)) : std::nullopt, (noted & 1U) != 0};
  }

  // What the run was charged since this was last asked; none: nothing.
  struct Charge {
    std::optional<Nanos> cpu;  // >= 0
    Nanos refused{0};          // below 0: the first charge that was
  };
  static Charge take_charge(Run& run) {
    return {std::exchange(run.charged_, std::nullopt), std::exchange(run.refused_charge_, Nanos{0})};
  }

  static std::uint32_t mode(const Run& run) { return run.mode_; }
  static bool emits(const Run& run) { return run.emits_; }
  static std::span<const Input> inputs(const Run& run) { return run.inputs_; }

  // Of what the run has consumed; none: nothing.
  static Origin oldest_consumed(const Run& run) {
    Origin oldest = kNoOrigin;
    for (const Input& input : run.inputs_) {
      if (input.first != 0) oldest = oldest == kNoOrigin ? input.origin : std::min(oldest, input.origin);
    }
    return oldest;
  }
  // Once the function has returned: a run gives no output where it consumed what is older than an edge with `on_stale:
  // skip` allows.
  static void skip_if_stale(Run& run) {
    for (std::size_t input = 0; input < run.inputs_.size(); ++input) {
      const InputEdge& edge = (*run.edges_)[input];
      if (edge.skips && run.inputs_[input].origin != kNoOrigin && run.age_of(run.inputs_[input]) > edge.max_age) {
        run.emits_ = false;
      }
    }
  }

  // Publishes what the run wrote, or discards it where the run skipped its output. `origin`: of its output.
  static void finish_writes(Run& run, Origin origin = Origin{0}) {
    for (ChannelBase* channel : run.written_) {
      if (run.emits_) {
        channel->publish(run.number_, origin);
      } else {
        channel->discard();
      }
    }
    run.written_.clear();
  }
};

}  // namespace ctn
