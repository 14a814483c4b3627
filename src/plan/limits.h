// What an app asks of the period of each subchain, collected from its nodes, and which bounds may give way.
//
// A node's `max_rate` is a hard cap, and `min_rate` equal to it an exact rate (a display): the period is then given. A
// `min_rate` by itself and the `max` of a response time are bounds that may be relaxed, all by one factor. While an app
// runs, exact rates that cannot be met are relaxed with them: there is no one to refuse the app to any more. A plan
// that does so names at least one of them in `relaxed`; to it all of them are a cap and a bound.
//
// Units: Millis. Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/ids.h"
#include "base/ticks.h"
#include "base/time.h"
#include "graph/app.h"
#include "plan/plan.h"

namespace ctn::plan {

// How long a subchain that follows another goes without a trigger where there are no outputs: ten periods, and at least
// a second.
constexpr Nanos silence_limit(Nanos period) { return std::max<Nanos>(10 * period, std::chrono::seconds{1}); }

// The least time between two triggers of a subchain that follows outputs and is to be triggered every `period` at most,
// on average: in any time it is triggered once more than that says, at most. So one that came late, since its output
// did, does not make the next ones late where outputs come just once a period.
constexpr Nanos held_apart(Nanos period) { return period / 5 * 4; }

// So it is triggered at most `at_once + time / apart` times within any time, by each of the two.
struct Hold {
  int at_once;
  Nanos apart;
};
constexpr std::array<Hold, 2> holds_of_follower(Nanos period) { return {{{1, held_apart(period)}, {2, period}}}; }

struct PeriodLimits {
  Millis min{0};                   // p may be no shorter: the lowest max_rate of the nodes; 0: no cap
  std::optional<NodeId> capped;    // whose max_rate that is
  std::optional<Millis> exact;     // p must be just this
  std::optional<NodeId> exact_of;  // whose rate that is
};

// The limits of an `App` agree: no node's min_rate, exact or not, is above the max_rate of another of its subchain.
PeriodLimits period_limits(const graph::Graph& graph, SubchainId subchain);

// Of a subchain whose head awaits input (graph::Graph::awaits_input()): a shorter period than what feeds it has is of
// no use, since runs would wait for news.
struct UsefulPeriod {
  Millis min{0};  // between two outputs of that predecessor of the head which gives them most often; 0: any
  std::optional<NodeId> from;  // that one
};

// By SubchainId; of what feeds a head the limits count, not what a plan makes of it.
std::vector<UsefulPeriod> useful_periods(const graph::Graph& graph);

bool has_exact_rates(const graph::Graph& graph);
// The app but that its exact rates may be relaxed.
graph::App relaxing_exact_rates(const graph::App& app);
// Whether the plan relaxes exact rates of the app.
bool relaxes_exact_rates(const Plan& plan, const graph::App& app);
// The app as the plan takes it: with exact rates relaxed, if the plan relaxes any.
graph::App as_planned(const graph::App& app, const Plan& plan);

// A bound that may be relaxed: on a node's period (its min_rate) or on the response time of an objective's term.
struct SoftBound {
  std::string key;  // as in RelaxedBound
  Millis asked{0};
  std::optional<NodeId> node;       // of a min_rate
  std::optional<std::size_t> term;  // of a max: index into the objective
};

// Response times first, in the order of the objective, then nodes in theirs.
std::vector<SoftBound> soft_bounds(const graph::App& app);

// The shortest frame that keeps the caps of all that share the core, at the shares they have: CorePlan::frame_min.
Millis min_frame(const graph::Graph& graph, const Plan& plan, const CorePlan& core);
// Elastic frames may be shorter than that: a subchain whose cap is many frames long need not hold up the others to keep
// it. Its trigger is deferred to a later frame instead, by no more than one part in kDeferredFrom of its period: frames
// in which every slot is used to its end are that much shorter, or it runs every so many of them anyway. Precondition:
// the subchain has a slot of the core.
constexpr int kDeferredFrom = 10;
bool is_deferred(const graph::Graph& graph, const Plan& plan, const CorePlan& core, SubchainId subchain);
// The shortest frame that keeps the caps of those that are not deferred.
Millis min_elastic_frame(const graph::Graph& graph, const Plan& plan, const CorePlan& core);

// How many ticks of a clock a period lasts: a whole number of them, or of halves, thirds or quarters, but for the
// digits with which one writes periods and rates. None: neither, and then no subchain can keep a phase to the clock at
// such a period. Precondition: both are > 0.
std::optional<TickCount> ticks_of(Millis period, Millis clock);

// A subchain whose head takes all inputs since its last run: its share is free, because what counts is its average
// rate.
bool takes_batches(const graph::Graph& graph, SubchainId subchain);

}  // namespace ctn::plan
