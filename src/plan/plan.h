// A plan: which subchain gets which cores, in which form they are shared, and how often each subchain runs. A plain
// value: it can be compared, printed, stored and replayed, and knows nothing of threads. Whatever made it, `validate`
// (validate.h) proves it against the app; json.h writes and reads it.
//
// A core has one of two forms:
//   frames      subchains take turns, each in its slot of a frame (`slots`); one subchain alone owns the core instead
//   priorities  subchains pre-empt one another, each at a fixed priority (`members`)
//
// Units: Millis. Core numbers are indexes into the cores the planner was given, not CPU numbers.
// Thread safety: plain values.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "graph/app.h"

namespace ctn::plan {

enum class Quality { kOptimal, kFeasible };  // kFeasible: see `gap`

struct SubchainPlan {
  std::vector<int> cores;    // ascending; more than one: it owns them all
  Millis period{0};          // p
  Millis execution{0};       // L: from its head's begin to its tail's end, waits included
  std::optional<int> every;  // n: a trigger every n frames; none for a queue node
  double share = 1.0;        // f = slice / compute time
  Millis slice{0};           // CPU time in each frame
  int threads = 1;           // q
  Millis wait{0};            // of L: what a run waits, using no CPU

  friend bool operator==(const SubchainPlan&, const SubchainPlan&) = default;
};

struct Slot {
  SubchainId subchain;
  Millis offset{0};
  Millis slice{0};
  std::optional<int> every;
  int phase = 0;

  friend bool operator==(const Slot&, const Slot&) = default;
};

enum class Form { kFrames, kPriorities };
const char* to_string(Form form);

// Whose outputs trigger a subchain: another subchain's, or an unscheduled node's.
using Leader = std::variant<SubchainId, NodeId>;

// In place of time: a subchain is triggered by each `every`-th output of its leader.
struct After {
  Leader leader;
  int every = 1;  // >= 1

  // The one or the other; null where it is the other.
  const SubchainId* subchain() const { return std::get_if<SubchainId>(&leader); }
  const NodeId* node() const { return std::get_if<NodeId>(&leader); }

  friend bool operator==(const After&, const After&) = default;
};

// A subchain's place on a core of fixed priorities. While a run of it is under way it is not triggered; what comes due
// meanwhile is made up for by one trigger as soon as the run has ended.
struct Member {
  SubchainId subchain;
  int priority = 1;             // from 1, no two alike on a core; a higher one pre-empts
  Millis period{0};             // between two triggers by time; with a pause or `after`, at least
  Millis phase{0};              // triggers by time come at phase + k x period of the clock; in [0, period)
  std::optional<NodeId> clock;  // of others: its ticks, in place of the system's monotonic clock
  std::optional<Millis> pause;  // triggered so long after its own run has ended, in place of a phase
  std::optional<After> after;   // triggered by outputs, in place of time
  Millis budget{0};             // CPU time of a run; beyond it, it is demoted below the others until its next trigger

  friend bool operator==(const Member&, const Member&) = default;
};

struct CorePlan {
  Form form = Form::kFrames;
  Millis frame{0};
  Millis frame_min{0};  // no rate cap asks for longer frames than this (limits.h)
  graph::FrameMode frames = graph::FrameMode::kElastic;
  std::vector<Slot> slots;      // of frames
  std::vector<Member> members;  // of fixed priorities, the highest first
  Millis idle{0};

  friend bool operator==(const CorePlan&, const CorePlan&) = default;
};

// One response-time term of the objective, as predicted. In the order of the objective.
struct ChainPlan {
  std::vector<NodeId> path;
  Millis response{0};
  Millis latency{0};
  Millis period{0};
  double weight = 0.0;

  friend bool operator==(const ChainPlan&, const ChainPlan&) = default;
};

// One period term of the objective, as predicted.
struct NodePlan {
  NodeId node;
  Millis period{0};
  double weight = 0.0;

  friend bool operator==(const NodePlan&, const NodePlan&) = default;
};

// A bound that could not hold as asked.
struct RelaxedBound {
  std::string key;  // which bound, as in "objective[0].max" or "nodes.GL.min_rate"
  Millis asked{0};  // as a response time or a period
  Millis planned{0};

  friend bool operator==(const RelaxedBound&, const RelaxedBound&) = default;
};

// What a node was taken to cost, since it had not run when the plan was made.
struct AssumedCost {
  NodeId node;
  Millis cost{0};

  friend bool operator==(const AssumedCost&, const AssumedCost&) = default;
};

// How many of a node's runs were taken to come to one output, as measured.
struct RunsPerOutput {
  NodeId node;
  double runs = 1.0;

  friend bool operator==(const RunsPerOutput&, const RunsPerOutput&) = default;
};

// How many items a run of a queue node was taken to have at most, where it costs more with each (batches.h).
struct Batch {
  NodeId node;
  int items = 0;

  friend bool operator==(const Batch&, const Batch&) = default;
};

// What is to be expected on average: plans are cut for a high percentile of the compute times, most runs cost less, and
// elastic frames hand on what they leave. A figure is at most the planned one, unless that is for typical times, or is
// a period under fixed priorities: where runs differ much, triggers are missed while a long one lasts.
struct Expectation {
  struct Timing {
    Millis period{0};
    Millis execution{0};

    friend bool operator==(const Timing&, const Timing&) = default;
  };
  struct Chain {
    Millis response{0};
    Millis latency{0};
    Millis period{0};

    friend bool operator==(const Chain&, const Chain&) = default;
  };
  double objective = 0.0;
  std::vector<Timing> subchains;  // by SubchainId
  std::vector<Chain> chains;      // in the order of Plan::chains

  friend bool operator==(const Expectation&, const Expectation&) = default;
};

struct Plan {
  std::string planner;  // who made it: "auto", "paper", or a method of baselines/, as "davare"
  Quality quality = Quality::kOptimal;
  double gap = 0.0;  // proven distance from the optimum, as a fraction of the objective
  Millis solve_time{0};
  double objective = 0.0;  // the weighted sum, in ms
  double slack = 0.0;      // fraction of a core left to ordinary threads
  double relax_factor = 1.0;
  std::vector<RelaxedBound> relaxed;
  std::vector<SubchainPlan> subchains;  // by SubchainId
  std::vector<CorePlan> cores;          // by core number
  std::vector<ChainPlan> chains;
  std::vector<NodePlan> nodes;
  std::vector<AssumedCost> assumed;     // by NodeId; made while an app runs: of scheduled nodes that had not run
  std::vector<RunsPerOutput> outputs;   // by NodeId: of nodes that were seen not to give one in every run
  std::vector<Batch> batches;           // by NodeId; of nodes whose runs cost more with each item
  bool for_typical = false;             // promises are for what runs typically cost, not for the planned percentile
  std::optional<Expectation> expected;  // where typical compute times are known as well as the percentile

  friend bool operator==(const Plan&, const Plan&) = default;
};

// What promises are for, in documents: "typical" or "percentile".
inline const char* promises_for(bool typical) { return typical ? "typical" : "percentile"; }

// Where a subchain has a fixed priority; null where it has none. Precondition: it has a core of the plan's.
const Member* member_of(const Plan& plan, SubchainId subchain);

// A core of each.
std::vector<int> first_cores(std::span<const SubchainPlan> subchains);

// From the begin of one run to that of the next, at most, where that is longer than the period: of a subchain that
// takes batches in frames, which has runs in bursts, or now after more and now after fewer frames. Not where that has
// what runs wait in it.
std::optional<Millis> longest_gap(std::span<const CorePlan> cores, const SubchainPlan& subchain);

// What a subchain is expected to have, or where nothing is expected what it is promised, which may be many times as
// long: for code that has to go on, or to wait, for about a period.
Expectation::Timing usual_timing(const Plan& plan, SubchainId subchain);
// The same of a node's period; `node` is one of the plan's.
Millis usual_period(const graph::Graph& graph, const Plan& plan, const NodePlan& node);

// Chains that are expected to take longer than they are promised, by their places in Plan::chains: by more than a
// hundredth, which may be what scheduling costs. What promises leave out (the load of unscheduled nodes) is too much
// for them to hold there. None where nothing is expected, or promises are for typical compute times.
std::vector<std::size_t> chains_above_promise(const Plan& plan);

// Whether a subchain takes turns with others on its core. Precondition: it has a core of the plan's.
inline bool shares_core(const Plan& plan, const SubchainPlan& subchain) {
  return !plan.cores[static_cast<std::size_t>(subchain.cores.front())].slots.empty();
}

// Whether frames are fixed where a subchain is, by the app or by the plan; it then keeps to its period if it owns its
// cores. Precondition: as above.
inline bool has_fixed_frames(const graph::App& app, std::span<const CorePlan> cores, const SubchainPlan& subchain) {
  return app.scheduler.frames == graph::FrameMode::kFixed ||
         cores[static_cast<std::size_t>(subchain.cores.front())].frames == graph::FrameMode::kFixed;
}

}  // namespace ctn::plan
