// An application as Catan understands it: graph, objective, order, stealing, scheduler options. A value, made only by
// `build_app` (build.h), which checks every invariant below; code that has an `App` need not check again.
//
// Invariants: node and subchain names are unique and not empty; edges form a DAG; each node is external, unscheduled or
// in exactly one subchain; a subchain is a path of edges, of nodes that are neither external nor unscheduled; every
// chain of the objective is a path with at least one node that is not external, and an external node that ticks is its
// first or its last; a follower is unscheduled, and is fed by the node that it follows, which is unscheduled too; an
// edge with an age limit joins nodes that are not external, and the limit is above 0; a subchain that is triggered by
// arrival alone has an unscheduled node that feeds its head; an exclusive group has two nodes or more, none of them
// external, and no node is in two of them; weights are finite and >= 0, and add up to 1e100 at most; min_rate <=
// max_rate, for the nodes of a subchain taken together; kinds of cores have unique names, one core or more, and a
// finite speed > 0.
//
// Words: see docs/architecture.md. Units: in the types. Thread safety: immutable once built.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/ids.h"
#include "base/time.h"

namespace ctn::graph {

// kLatest: a run takes the newest output of each predecessor. kQueue: it takes all since its last run.
enum class InputKind { kLatest, kQueue };

// What may trigger a subchain. kArrival: outputs of an unscheduled node that feeds its head. kAny: these, time, or
// outputs of another subchain, as is best.
enum class TriggerBy { kAny, kTime, kArrival };
const char* to_string(TriggerBy trigger);  // as the app file has it

// That work for one run of a node.
inline constexpr int kMaxThreads = 64;

// Nothing is triggered more often, whatever a plan says: nodes that cost next to nothing would otherwise keep their
// controller, which outranks everything, busy without end.
inline constexpr Nanos kShortestPeriod = std::chrono::microseconds{100};
inline constexpr Rate kHighestTriggerRate = Rate::every(Millis{kShortestPeriod});

struct Node {
  std::string name;
  InputKind input = InputKind::kLatest;
  std::vector<std::string> modes;  // names of its modes; empty: one mode
  bool external = false;           // hardware or another program: no thread of ours, costs nothing
  bool unscheduled = false;        // runs by itself, above all that is scheduled
  // Unscheduled nodes, always: how often they run. External nodes that have a clock: how often that ticks.
  std::optional<Nanos> period;
  std::optional<NodeId> follows;       // unscheduled nodes without a period of their own: whose output sets them off
  std::optional<Nanos> output_period;  // emits less often than it runs; planned with, and done without code
  std::optional<Rate> min_rate;
  std::optional<Rate> max_rate;
  bool relaxes_exact_rate = false;      // where min_rate is max_rate: the first may be relaxed like any other
  std::optional<Rate> fallback_rate;    // set by hand, for where Catan sets none (cut.h)
  int max_threads = 1;                  // how many cores one run can use
  TriggerBy trigger = TriggerBy::kAny;  // heads of subchains: theirs
  // A run of it begins only once a predecessor's new output has come since its last run began: its program calls it for
  // messages alone. Of what Catan triggers; see Graph::awaits_input().
  bool needs_input = false;
  std::optional<SubchainId> subchain;    // none: external or unscheduled
  std::optional<std::size_t> exclusive;  // the exclusive group that it is in, by its index in App::exclusive
  std::vector<NodeId> predecessors;      // in the order the edges were written
  std::vector<NodeId> successors;

  // Of an unscheduled node: between two of its outputs.
  Nanos outputs_apart() const { return std::max(*period, output_period.value_or(Nanos{0})); }
  // What it takes from others, and what it gives them, counts at the ticks of a clock that is not ours.
  bool is_external_clock() const { return external && period; }
  // Phases can be kept to it: it ticks, or begins its runs by a timer of its own.
  bool has_clock() const { return is_external_clock() || (unscheduled && period && !follows); }
};

// What becomes of a run whose input is older than its edge allows. Such a run is counted and reported in any case.
// kRun: nothing else happens. kSkip: it gives no output.
enum class OnStale { kRun, kSkip };

// How old the source may be of what a run takes over an edge (record/ages.h says what its age is).
struct AgeLimit {
  Nanos max_age{0};
  OnStale on_stale = OnStale::kRun;
  friend bool operator==(const AgeLimit&, const AgeLimit&) = default;
};

struct Edge {
  NodeId from;
  NodeId to;
  std::optional<AgeLimit> age_limit{};
  friend bool operator==(const Edge&, const Edge&) = default;
};

struct Subchain {
  std::string name;
  std::vector<NodeId> nodes;  // in the order they run; never empty
  bool implicit = false;      // one node that no subchain named, under its own name

  NodeId head() const { return nodes.front(); }
  NodeId tail() const { return nodes.back(); }
};

enum class Metric { kResponseTime, kPeriod };

// One term of the objective: weight x (a chain's response time | a node's period), in milliseconds.
struct Term {
  Metric metric = Metric::kResponseTime;
  std::vector<NodeId> path;  // kResponseTime: the chain; kPeriod: the one node
  double weight = 0.0;
  std::optional<Nanos> max;  // bound on a response time
};

// One step of a chain as the planner's formulas see it: the longest stretch of consecutive nodes of one subchain, or an
// unscheduled node by itself, or an external node that ticks, which costs nothing. Other external nodes are no element.
struct ChainElement {
  std::optional<SubchainId> subchain;  // none: an unscheduled node, or one that ticks
  std::vector<NodeId> nodes;           // never empty
  bool follows = false;                // of an unscheduled node: it runs as soon as that of the element before has
};

class Graph {
 public:
  std::span<const Node> nodes() const { return nodes_; }
  std::span<const Edge> edges() const { return edges_; }
  std::span<const Subchain> subchains() const { return subchains_; }
  const Node& node(NodeId id) const { return nodes_[id.index()]; }
  const Subchain& subchain(SubchainId id) const { return subchains_[id.index()]; }

  std::optional<NodeId> find_node(std::string_view name) const;
  std::optional<SubchainId> find_subchain(std::string_view name) const;
  bool has_edge(NodeId from, NodeId to) const;
  // None also where there is no such edge.
  std::optional<AgeLimit> age_limit(NodeId from, NodeId to) const;

  // Whether all that a run of the node takes is known: it is fed, and by no external node.
  bool knows_inputs(NodeId id) const;
  // A run of the node may find nothing, and that is known: it takes batches.
  bool may_run_empty(NodeId id) const { return node(id).input == InputKind::kQueue && knows_inputs(id); }

  // A run of the node that is triggered without news waits for some: it needs input, and when input comes is known.
  // That is not so where nothing feeds it, or an external node without a clock: these may have given something at any
  // time.
  bool awaits_input(NodeId id) const;

  // The longest output period of the nodes of its subchain up to it: no two of its outputs are closer together, since a
  // run of it follows outputs of those before. Of a node in no subchain its own. 0: none has any.
  Nanos output_period_up_to(NodeId id) const;
  // That of the node before it in its subchain: no two of its runs are closer together. 0: as output_period_up_to().
  Nanos output_period_before(NodeId id) const;

  // All nodes, predecessors before successors; ties in the order written.
  std::span<const NodeId> topological_order() const { return topological_; }

  // The row of elements of a chain; its length is what the formulas call n. Precondition: `path` follows edges.
  std::vector<ChainElement> chain_elements(std::span<const NodeId> path) const;

  // The same graph but that this node's rate has no lower bound: to ask what the bound is worth. A bound less breaks no
  // invariant.
  Graph without_min_rate(NodeId id) const;

  // The same graph but for the lowest rate of this node; none: no bound. Precondition: it is not above the max_rate of
  // any node of its subchain.
  Graph with_min_rate(NodeId id, std::optional<Rate> min_rate) const;

  // The same graph but that these nodes need input, and no others. Precondition: none of them is external.
  Graph needing_input(std::span<const NodeId> needing) const;

  // The same graph but that exact rates (min_rate = max_rate) may be relaxed, as any min_rate may: to plan where they
  // cannot be met.
  Graph relaxing_exact_rates() const;

  // The same graph in other subchains. Precondition: they keep the invariants above, and the same nodes are in them.
  Graph with_subchains(std::vector<Subchain> subchains) const;

  // "scan -> LM -> LP".
  std::string path_name(std::span<const NodeId> path) const;

 private:
  friend class AppBuilder;
  std::vector<Node> nodes_;
  std::vector<Edge> edges_;
  std::vector<Subchain> subchains_;
  std::vector<NodeId> topological_;
};

enum class FrameMode { kElastic, kFixed };

// The planner behind the scheduler `catan`: Catan's own planner, or the paper's.
enum class PlannerKind { kAuto, kPaper };

// How cores may be shared where Catan's own planner plans: whichever way is best, in frames alone, or by fixed
// priorities alone.
enum class ScheduleKind { kAuto, kFrames, kPriorities };

struct SchedulerOptions {
  // Fraction of a core in [0, 1); none: what the machine needs, 6 % where it cannot be asked.
  std::optional<double> slack;
  FrameMode frames = FrameMode::kElastic;
  Nanos min_slice = std::chrono::milliseconds{1};
  int window = 50;           // runs an estimate looks back on, >= 1
  double percentile = 95.0;  // in (0, 100]
  Nanos bootstrap = std::chrono::seconds{2};
  Nanos bootstrap_cost = std::chrono::milliseconds{5};
  Nanos replan = std::chrono::seconds{1};
  PlannerKind planner = PlannerKind::kAuto;
  ScheduleKind schedule = ScheduleKind::kAuto;
};

constexpr double kDefaultSlack = 0.06;

// Nodes whose runs never overlap, since their program does not let them: callbacks of one spinner, users of one mutex.
// One that has to wait raises the one that it waits for to its own level; of several that want to run, the highest is
// next.
struct ExclusiveGroup {
  std::string name;
  std::vector<NodeId> nodes;  // as written

  friend bool operator==(const ExclusiveGroup&, const ExclusiveGroup&) = default;
};

struct StealOptions {
  std::vector<SubchainId> priority;  // every subchain once, highest rank first
  std::vector<SubchainId> off;       // those that never steal
};

// Cores that are alike. `speed` says how fast they are, compared with a core of speed 1, for which compute times are
// given.
struct CoreKind {
  std::string name;
  int count = 1;
  double speed = 1.0;

  friend bool operator==(const CoreKind&, const CoreKind&) = default;
};

struct App {
  std::string name;
  Graph graph;
  std::vector<CoreKind> core_kinds;  // empty: all cores are alike, however many. Else cores are numbered kind by kind
  std::vector<ExclusiveGroup> exclusive;
  std::vector<Term> objective;
  std::vector<SubchainId> order;  // every subchain once: the order of slots in a frame
  StealOptions steal;
  SchedulerOptions scheduler;

  // How many kinds of cores there are; 1 where the app says nothing of them.
  std::size_t kinds() const { return core_kinds.empty() ? 1 : core_kinds.size(); }
  // The kind that a core is of. Precondition: core >= 0, and, where the app lists its cores, below core_count().
  std::size_t kind_of(int core) const;
  // How many cores the app lists; none where it says nothing of them.
  std::optional<int> core_count() const;
  // How many of the first `cores` are of each kind.
  std::vector<int> cores_by_kind(int cores) const;

  // The sum of the weights of all terms that a subchain's nodes take part in: its rank where no order was written.
  double weight_of(SubchainId subchain) const;
  // Whether it bounds a response time, or how seldom a node runs.
  bool has_bounds() const;
  // Other subchains with a node that is in an exclusive group with one of its own; in the order of their numbers.
  std::vector<SubchainId> excluded_by(SubchainId subchain) const;
  // By subchain: those, and those with a node in an exclusive group with one of theirs, and so on; itself left out. As
  // their runs do not overlap, they gain little by several cores, and are to stay on one.
  std::vector<std::vector<SubchainId>> joined_by_exclusion() const;
};

}  // namespace ctn::graph
