// From runs to the latency, period and response time of a chain; the same code live, simulated and afterwards.
//
// It follows, run by run, which source run each run of the chain's nodes descends from (through `Run::consumed`). For a
// source run i(k) that reached the chain's end, its output is the first run of the last node that descends from it, and
//   latency(k)       = end of that output - begin of i(k)
//   response time(k) = end of that output - begin of i(k-1), i(k-1) being the source run before it that reached the end
//   period(k)        = end of that output - end of i(k-1)'s output
// Source runs that were dropped on the way, or overtaken by a newer one, count for nothing. A run of a queue node
// descends from every run in its batch, and so does whatever uses its output: all of them reach the end with it. A run
// that emitted nothing is no one's input, and at the chain's end it is no output.
//
// Clocks of others. Where an external node with a clock (`period`) ends the chain, an output ends at the first tick
// that is not before the end of its run; of the outputs that end at one tick only the newest counts that brought a new
// source run, and those that it overtook never reached the end. Where one begins the chain, a source run begins at the
// last tick that is not after its begin, and only the first of several that begin at one tick counts. A clock of which
// nothing is known (set_clock()) is passed over. A sample is complete once an output of a later tick has come.
//
// How: each node of the chain keeps which runs of the node before it its last kHorizon runs consumed. An output is
// traced back through them, stopping at runs that an earlier output was traced to; so a run is visited once, however
// often it is used.
//
// Units: Nanos. Thread safety: none; one owner. Memory: kHorizon runs of each node of the chain. A source run that
// reaches the end only after one of the chain's nodes has run kHorizon times more counts as dropped.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/ticks.h"
#include "base/time.h"
#include "graph/app.h"
#include "record/events.h"

namespace ctn::record {

struct ChainSample {
  std::uint64_t source_run = 0;
  TimePoint begin{};  // of the source run
  TimePoint end{};    // of its output
  Nanos latency{0};
  std::optional<Nanos> period;    // none for the first
  std::optional<Nanos> response;  // none for the first
  friend bool operator==(const ChainSample&, const ChainSample&) = default;
};

class ChainTracker {
 public:
  static constexpr std::size_t kHorizon = 8192;  // 8 s of a node that runs at 1 kHz

  // `path` as in the objective; external nodes in it are passed over, but for their clocks. Where one stands between
  // two nodes of ours, it is not reported what was consumed through it: the later node is taken to have consumed what
  // the earlier one had emitted by the time it began (the newest output; all since its last run, for a queue node).
  ChainTracker(const graph::Graph& graph, std::span<const NodeId> path);

  // Takes the next run; runs of one node in the order of their numbers, and a run after those it consumed. Returns the
  // samples that it completes, oldest first: none or one, more only where a queue node batched. Runs of nodes that are
  // not in the chain are passed over. Runs that never came count as dropped; nothing that comes is harmful.
  std::vector<ChainSample> add(const Run& run);

  // The way of the sample that add() has just returned with that source run: the numbers of the runs by which it
  // reached the end, one a node of the chain that is not external, the first node's first. Empty: one of them is not
  // known.
  std::vector<std::uint64_t> path_of(std::uint64_t source_run) const;

  // From now on that external node's clock ticks so. Of nodes that neither begin nor end the chain it makes no
  // difference.
  void set_clock(NodeId node, const Ticks& ticks);

 private:
  // What must be known of a run until all that descends from it is settled.
  struct Step {
    std::uint64_t number = 0;  // 0: none yet
    std::uint64_t first = 0;   // consumed runs of the node before; 0: none. Unused for the chain's source
    std::uint64_t last = 0;
    TimePoint begin{};
    TimePoint end{};
    bool emitted = false;
    bool traced = false;  // an output was traced to it already: all it descends from is settled
  };
  struct Stage {  // one node of the chain
    NodeId node;
    bool behind_external = false;  // what it consumed is inferred
    bool queue = false;
    std::uint64_t newest = 0;
    std::uint64_t taken = 0;  // behind_external: the newest run of the stage before that it took
    std::vector<Step> steps;  // by number modulo kHorizon; grows as needed up to it

    Step* find(std::uint64_t number);
    const Step* find(std::uint64_t number) const;
    Step& put(std::uint64_t number);
  };
  struct Range {
    std::uint64_t first = 0;
    std::uint64_t last = 0;
  };

  // A clock that begins or ends the chain.
  struct Clock {
    std::optional<NodeId> node;  // none: there is no such
    std::optional<Ticks> ticks;  // none: not known
  };
  struct Source {
    std::uint64_t number = 0;
    TimePoint begin{};
  };

  Range consumed(std::size_t stage, const Run& run);
  Range inferred(std::size_t stage, const Run& run);
  std::vector<Source> trace_to_source(const Step& output);
  struct Trace {
    std::uint64_t source_run = 0;
    std::vector<std::uint64_t> path;
    std::size_t steps_left = 4 * kHorizon;  // a foreign record may have every run consume all others
  };
  std::strong_ordering trace(std::size_t stage, std::uint64_t number, Trace& of) const;
  void reach_end(const std::vector<Source>& sources, TimePoint end, std::vector<ChainSample>& samples);
  void wait_for_tick(std::vector<Source> sources, TimePoint end, std::vector<ChainSample>& samples);
  ChainSample sample(const Source& source, TimePoint end);

  std::vector<Stage> stages_;
  std::vector<std::optional<std::size_t>> stage_of_;  // by NodeId
  std::optional<ChainSample> previous_;
  Clock first_;
  Clock last_;
  std::vector<Source> waiting_;  // for the end's next tick: what the newest output brought
  std::optional<TimePoint> waiting_until_;
};

}  // namespace ctn::record
