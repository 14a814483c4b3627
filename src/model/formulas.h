// The planner's formulas, each by itself (docs/planner.md; paper sections 5.1 and 5.2).
//
// Units: Millis; slack is a fraction in [0, 1). Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <optional>
#include <span>

#include "base/time.h"
#include "model/cost.h"

namespace ctn::model {

// A subchain that owns k cores, at its best number of threads a node.
struct OwnedCores {
  int threads = 1;      // q
  Millis period{0};     // p(q)
  Millis execution{0};  // L(q)
};

// With k cores and q threads a node: p(q) = max(max_j (c^q_j / u + w_j), sum_j (c^q_j / u + w_j) / floor(k / q)) and
// L(q) = sum_j (c^q_j + w_j), where u = 1 - slack and w_j is what a run of the node waits. It uses no core meanwhile,
// but no more runs overlap than there are cores for all of their threads: one that came back from its wait would find
// its core taken else, and L(q) would hold no longer. Precondition: 1 <= threads <= cores.
OwnedCores owned_cores_with(const graph::Graph& graph, SubchainId subchain, const CostTable& costs, int cores,
                            int threads, double slack);

// The q in 1..k with the least L(q) + p(q); the smaller q where two are equal. Precondition: cores >= 1.
OwnedCores owned_cores(const graph::Graph& graph, SubchainId subchain, const CostTable& costs, int cores, double slack);

// What slots are longer than their slices (dispatch/shared_core_schedule.h).
constexpr Millis kShortWait{0.2};

// A subchain that shares a core: it has a share f of each frame T, a slice of CPU time.
struct SharedCore {
  Millis frame{0};
  double share = 1.0;
  Millis slice{0};
  Millis wait{0};  // of a run
};
struct SharedTiming {
  Millis period{0};
  Millis execution{0};
};

// p = L = T / f. Only a subchain that takes batches may have an f that is not 1 / n. Then p is a mean (longest_gap()),
// and a run may begin within a slot, right after the one before: it ends in the n-th slot after that one, n = 1 / f
// rounded up, and so takes L = n T + c - n slice. Where f > 1 there are several runs in the slot of a frame, of which
// the last may be left over to the next.
// A run that waits for w in all leaves some of its slots unused, gets as much in later ones, and holds up the next run:
// p = L = n T + w + T + slice, which holds wherever in its slots it waits, and also where frames are shorter. With an
// exact rate the period is given, and a short wait of the only run in a slot has room there: p = T / f, and L is longer
// by w.
SharedTiming shared_core(const SharedCore& on, bool exact_rate);

// From the begin of one run to that of the next, at most, of a subchain that takes batches and does not wait: it has a
// run as soon as the shares of frames add up to one. Precondition: share > 0.
Millis longest_gap(Millis frame, double share);

// Triggered at `phase` and each `period` after, of one clock.
struct Grid {
  Nanos phase{0};
  Nanos period{0};  // > 0
};

// How long an output of the first waits for a run of the second.
struct InputWait {
  Millis last{0};  // the last one before that run, at most
  Millis more{0};  // another one, at most so much longer
};
// Of which one's period is a whole multiple of the other's.
class InStep {
 public:
  // None where neither is: then an output may wait for anything up to the second's period.
  static std::optional<InStep> of(const Grid& first, const Grid& second);

  // A run of the first ends `execution` after its trigger, at most. `below`: the second cannot run before the first,
  // triggered before it, has ended, and then finds its output even if it was triggered meanwhile. Triggers that are
  // closer together than kTogether may come in either order.
  InputWait wait(Millis execution, bool below) const;

 private:
  Millis shorter_{0};  // of the periods
  Millis apart_{0};    // from a trigger of the first to the next of the second, if both had that period
  Millis more_{0};     // as InputWait's
};
constexpr Millis kTogether{0.05};

// By how much more two outputs of a node may be apart than its runs, since it, or one before it in its subchain, has an
// `output_period`. Each run that ends before that is over gives no output, and the next one may end a period, and what
// a run takes, after it is: so all of these are between two outputs, P + p + L.
struct LeftOut {
  Millis periods{0};  // P
  double runs = 0.0;  // so many times L

  Millis most(Millis execution) const { return periods + runs * execution; }
};
LeftOut left_out(const graph::Graph& graph, const CostTable& costs, const graph::Subchain& subchain, NodeId node);
// The same of an unscheduled node.
LeftOut left_out(const graph::Node& unscheduled);

// By how much more than on average outputs of the subchain's last node may be apart for that; 0: it is for nothing.
Millis outputs_late(const graph::Graph& graph, const CostTable& costs, const graph::Subchain& subchain, Millis period,
                    Millis execution);

// One element of a chain, as planned.
struct ElementTiming {
  Millis period{0};              // p
  Millis execution{0};           // L
  Millis output_period{0};       // the longest of its nodes; 0: none has any
  std::optional<Millis> wait{};  // of its input, at most, or of what the first one senses; none: p
  double runs_per_output = 1.0;  // of its last node
  Millis left_out{0};            // that two outputs may be apart beyond runs_per_output * p, at most

  // On average.
  Millis outputs_apart() const { return std::max(period * runs_per_output, output_period); }
};

struct ChainTiming {
  Millis latency{0};  // L_1 + sum_{x >= 2} (p_x + L_x); in place of p_x its wait, where that is given
  Millis period{
      0};  // of outputs: max p_x, with runs per output, + all that is left out + what the first waits beyond p
  Millis response{0};  // latency + period
};

// Precondition: at least one element.
ChainTiming chain_timing(std::span<const ElementTiming> elements);

}  // namespace ctn::model
