// What an app's runs come to, live, simulated and afterwards: chains of the objective, nodes, edges with an age limit.
// A figure counts if all that it spans lies in the interval that is measured. For the period of a node that takes
// batches, a run counts that had at least one input; where an external node feeds it, which cannot be told, each does.
//
// `Samples` is where durations go, each by add(Nanos), and where summary_ms() comes from: all of them, the newest, or
// counts.
//
// Units: Nanos. Thread safety: none; one owner. Memory: that of the samples, and of record/lineage.h.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "base/time.h"
#include "catan/snapshot.h"
#include "graph/app.h"
#include "record/events.h"
#include "record/lineage.h"

namespace ctn::record {

struct Interval {
  TimePoint begin;
  TimePoint end = kNever;

  bool holds(TimePoint from, TimePoint to) const { return from >= begin && to <= end; }
};

inline bool counts_for_period(const Run& run, const graph::Graph& graph) {
  return !run.consumed.empty() || !graph.may_run_empty(run.node);
}

// Keeps all samples: figures are of the whole run, in memory that grows with it.
class AllSamples {
 public:
  void add(Nanos duration) { samples_.push_back(to_millis(duration).count()); }
  Summary summary_ms() const { return summarize(samples_); }

 private:
  std::vector<double> samples_;
};

template <class Samples>
struct MeasuredChain {
  const graph::Term* term;  // of the objective
  Samples response;
  Samples latency;
  Samples period;
  std::uint64_t over_bound = 0;  // response times above the term's
};

template <class Samples>
struct MeasuredNode {
  std::uint64_t runs = 0;
  std::uint64_t outputs = 0;  // runs that emitted
  Nanos cpu{0};               // of all runs
  Samples period;             // between the ends of consecutive runs that count
  Samples compute;            // CPU time of a run
  Samples wait;               // of a run
  bool waits = false;         // any of them did
};

// An edge with an age limit.
template <class Samples>
struct MeasuredEdge {
  const graph::Edge* edge;
  std::uint64_t runs = 0;   // whose input has an age
  std::uint64_t stale = 0;  // of these, older than the limit
  Samples age;              // when they began
};

template <class Samples>
class RunMetrics {
 public:
  // `app` outlives it.
  RunMetrics(const graph::App& app, Interval interval)
      : graph_(app.graph), interval_(interval), nodes_(app.graph.nodes().size()), tracks_(nodes_.size()) {
    for (const graph::Term& term : app.objective) {
      if (term.metric != graph::Metric::kResponseTime) continue;
      for (const NodeId node : term.path) tracks_[node.index()].chains.push_back(chains_.size());
      chains_.push_back({&term, {}, {}, {}});
      trackers_.emplace_back(app.graph, term.path);
    }
    for (const graph::Edge& edge : app.graph.edges()) {
      if (!edge.age_limit) continue;
      const std::vector<NodeId>& inputs = app.graph.node(edge.to).predecessors;
      const auto input = std::find(inputs.begin(), inputs.end(), edge.from) - inputs.begin();
      tracks_[edge.to.index()].limited.emplace_back(static_cast<std::size_t>(input), edges_.size());
      edges_.push_back({&edge, 0, 0, {}});
    }
  }

  // A run has ended; each after those that it consumed. Runs whose ages are not known count for no edge.
  void add(const Run& run) {
    add_to_node(run);
    add_to_edges(run);
    for (const std::size_t chain : tracks_[run.node.index()].chains) {
      for (const ChainSample& sample : trackers_[chain].add(run)) add_to_chain(chains_[chain], sample);
    }
  }

  // From now on an external node's clock ticks so.
  void set_clock(NodeId node, const Ticks& ticks) {
    for (const std::size_t chain : tracks_[node.index()].chains) trackers_[chain].set_clock(node, ticks);
  }

  const std::vector<MeasuredChain<Samples>>& chains() const { return chains_; }  // in the order of the objective
  const std::vector<MeasuredEdge<Samples>>& edges() const { return edges_; }  // with an age limit, as the app has them
  const MeasuredNode<Samples>& node(NodeId node) const { return nodes_[node.index()]; }

  // The same edges, by name.
  std::vector<AgeSnapshot> ages(const graph::Graph& graph) const {
    std::vector<AgeSnapshot> ages;
    for (const MeasuredEdge<Samples>& edge : edges_) {
      const graph::AgeLimit& limit = *edge.edge->age_limit;
      ages.push_back({graph.node(edge.edge->from).name, graph.node(edge.edge->to).name,
                      to_millis(limit.max_age).count(), limit.on_stale == graph::OnStale::kSkip, edge.runs, edge.stale,
                      edge.age.summary_ms()});
    }
    return ages;
  }

  // The app's objective at what was measured: of means. None where a term that weighs was not. `app`: as it was made
  // of.
  std::optional<double> objective(const graph::App& app) const {
    double sum = 0.0;
    std::size_t chain = 0;
    for (const graph::Term& term : app.objective) {
      const bool of_chain = term.metric == graph::Metric::kResponseTime;
      const Samples& measured = of_chain ? chains_[chain++].response : nodes_[term.path.front().index()].period;
      if (term.weight == 0.0) continue;
      const Summary summary = measured.summary_ms();
      if (summary.count == 0) return std::nullopt;
      sum += term.weight * summary.mean;
    }
    return sum;
  }

 private:
  struct Track {
    std::vector<std::size_t> chains;                           // that the node is in
    std::vector<std::pair<std::size_t, std::size_t>> limited;  // an input by predecessor, and which of edges_ it is
    std::optional<TimePoint> last_end;                         // of a run that counts for the period
  };

  void add_to_node(const Run& run) {
    MeasuredNode<Samples>& node = nodes_[run.node.index()];
    Track& track = tracks_[run.node.index()];
    if (counts_for_period(run, graph_)) {
      if (track.last_end && interval_.holds(*track.last_end, run.end)) node.period.add(run.end - *track.last_end);
      track.last_end = run.end;
    }
    if (!interval_.holds(run.begin, run.end)) return;
    ++node.runs;
    node.outputs += run.emitted ? 1U : 0U;
    node.cpu += run.cpu;
    node.compute.add(run.cpu);
    node.wait.add(run.wait);
    node.waits = node.waits || run.wait > Nanos{0};
  }

  // Whenever its source was: what counts is that the run had old data.
  void add_to_edges(const Run& run) {
    if (!interval_.holds(run.begin, run.end)) return;
    for (const auto& [input, index] : tracks_[run.node.index()].limited) {
      if (input >= run.ages.size() || run.ages[input] == kNoAge) continue;
      MeasuredEdge<Samples>& edge = edges_[index];
      ++edge.runs;
      edge.stale += run.ages[input] > edge.edge->age_limit->max_age ? 1U : 0U;
      edge.age.add(run.ages[input]);
    }
  }

  void add_to_chain(MeasuredChain<Samples>& chain, const ChainSample& sample) {
    if (interval_.holds(sample.begin, sample.end)) chain.latency.add(sample.latency);
    if (sample.response && interval_.holds(sample.end - *sample.response, sample.end)) {
      chain.response.add(*sample.response);
      if (chain.term->max.value_or(Nanos{0}) > Nanos{0} && *sample.response > *chain.term->max) ++chain.over_bound;
    }
    if (sample.period && interval_.holds(sample.end - *sample.period, sample.end)) chain.period.add(*sample.period);
  }

  const graph::Graph& graph_;
  Interval interval_;
  std::vector<MeasuredChain<Samples>> chains_;
  std::vector<ChainTracker> trackers_;  // by chain
  std::vector<MeasuredNode<Samples>> nodes_;
  std::vector<MeasuredEdge<Samples>> edges_;
  std::vector<Track> tracks_;  // by NodeId
};

}  // namespace ctn::record
