// From runs to the terms of the objective, as record/lineage.h and record/run_metrics.h define them, but on the fly and
// at a few nanoseconds a run: no run is remembered, each output just carries the begins of the source runs that it
// descends from. One, unless a queue node took a batch on the way.
//
// Chains that begin alike share their beginnings: what is followed is the prefixes of chains, each once. A prefix ends
// in a node, and what is known of it is from which source runs the node's newest output descends (given), and its run
// under way (held).
//
// Units: TimePoint, Nanos. Thread safety: ChainPrefixes is immutable; Lineage has one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/ids.h"
#include "base/ticks.h"
#include "base/time.h"
#include "graph/app.h"

namespace ctn::trial {

// As a queue channel's (catan/channel.h): outputs that find so many waiting are lost.
constexpr std::size_t kQueueCapacity = 4096;

// The prefixes of an app's chains: made once, used by every trial.
class ChainPrefixes {
 public:
  struct Prefix {
    NodeId node;
    int before = -1;                // the prefix that this one extends by its node; -1: the node is the source
    std::optional<NodeId> clock{};  // of a source: the external node with a clock before it
    bool queue = false;             // the node takes all outputs since its last run, and is not the source
    bool many = false;              // so does it, or a node before it: outputs may descend from several source runs
    bool extended = false;          // by a node that takes the newest output
    std::vector<int> queues;        // prefixes that extend it by a queue node
    std::vector<int> terms;         // that end here: indexes into the objective
  };

  // External nodes are passed over, but for clocks where chains begin and end.
  explicit ChainPrefixes(const graph::App& app);

  const std::vector<Prefix>& all() const { return prefixes_; }
  // Those that end in the node.
  const std::vector<int>& of(NodeId node) const { return of_node_[node.index()]; }

 private:
  int find_or_add(const graph::Graph& graph, NodeId node, int before, std::optional<NodeId> clock);

  std::vector<Prefix> prefixes_;
  std::vector<std::vector<int>> of_node_;
};

// What is measured of one term.
struct TermSamples {
  double sum = 0.0;  // ns
  std::size_t count = 0;
  std::vector<double> values;  // ns; only if they are wanted
};

class Lineage {
 public:
  // A response time or period counts if it begins at `warm_from` or later. `clocks`, by NodeId: those of external nodes
  // that tick. `prefixes` and `app` outlive it.
  Lineage(const graph::App& app, const ChainPrefixes& prefixes, std::vector<Ticks> clocks, TimePoint warm_from,
          Nanos before_ticks, bool keep_values);

  // A run of the node takes its inputs.
  void begin(NodeId node, TimePoint now);
  // It has ended.
  void end(NodeId node, TimePoint now, bool emitted);

  // By the terms of the objective.
  const std::vector<TermSamples>& terms() const { return terms_; }
  std::vector<TermSamples>& terms() { return terms_; }

 private:
  using Prefix = ChainPrefixes::Prefix;
  using Sources = std::vector<TimePoint>;  // begins of source runs, ascending
  static constexpr TimePoint kNone = TimePoint::min();

  struct Batches {  // of a prefix in which a node takes batches
    Sources held;
    Sources given;
    Sources waiting;  // at its queue node
    std::size_t outputs_waiting = 0;
  };
  struct End {                  // of a term
    TimePoint reached = kNone;  // the newest source run that has reached it
    Ticks clock;                // that it ends with; without a period: none
    // Of such a one.
    TimePoint newest = kNone;  // source run that has come
    Sources waiting;           // for the next tick: what the newest output brought
    TimePoint tick = kNone;    // that it waits for
  };
  struct PeriodTerms {  // of a node
    std::vector<int> terms;
    bool may_run_empty = false;  // such runs do not count
    bool fed = false;            // outputs wait for it
    bool had_input = true;       // the run under way
    TimePoint last_end = kNone;  // of a run that counts
  };

  void add_period_term(const graph::Graph& graph, NodeId node, int term);
  void take(std::size_t index, const Prefix& prefix);
  void give(std::size_t index, const Prefix& prefix, TimePoint now);
  void give_many(std::size_t index, const Prefix& prefix, TimePoint now);
  void put_in_queue(Batches& queue, const TimePoint* first, const TimePoint* last);
  void reach_end(const Prefix& prefix, const TimePoint* first, const TimePoint* last, TimePoint now);
  void reach(int term, TimePoint source, TimePoint now);
  void wait_for_tick(int term, const TimePoint* first, const TimePoint* last, TimePoint now);
  void add(int term, TimePoint from, TimePoint to);

  const ChainPrefixes& prefixes_;
  std::vector<Ticks> clocks_;  // by NodeId
  Nanos before_ticks_;
  TimePoint warm_from_;
  bool keep_values_;
  std::vector<TimePoint> held_;                  // by prefix
  std::vector<TimePoint> given_;                 // by prefix
  std::vector<Batches> batches_;                 // by prefix; used where `many`
  std::vector<End> ends_;                        // by term
  std::vector<PeriodTerms> periods_;             // by node
  std::vector<std::vector<std::size_t>> feeds_;  // by node: those it feeds that have such terms and may run empty
  std::vector<TermSamples> terms_;
};

}  // namespace ctn::trial
