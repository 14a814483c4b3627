// What a running app does at present, as plain data: what `catan top` and the live page show. live_view.h makes it,
// json.h writes it; docs/top.md says what its figures mean.
//
// Units: milliseconds, seconds and hertz where the names say so; `cores` and `busy` are CPU time divided by time.
// Figures are of the window, the last seconds (Picture::window_s), unless they say otherwise. Thread safety: plain
// values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/statistics.h"

namespace ctn::view {

// kStalled: the session shows no sign of life, though its process is there. kKilled: the process is gone without having
// ended the session.
enum class State { kRunning, kStalled, kEnded, kKilled };
const char* to_string(State state);  // "running", "stalled", "ended", "killed"

// How subchains share a core, as the plan has it: one owns it, they take turns in frames, or they pre-empt one another
// by fixed priorities. kNone: the plan does not use the core, or there is no plan.
enum class Sharing { kNone, kOwned, kFrames, kPriorities };
const char* to_string(Sharing sharing);  // "none", "owned", "frames", "priorities"

struct CoreUse {
  std::string name;             // of a subchain, or of an unscheduled node
  bool planned = false;         // the plan in force puts it there
  double cores = 0.0;           // CPU time of its runs that ended there, over time
  std::optional<double> slots;  // where subchains take turns: part of the time that lay in its slots
};

struct Core {
  std::optional<int> cpu;   // none: no run has shown yet which CPU this core of the plan is
  std::optional<int> core;  // its number in the plan; none: the plan does not use it
  Sharing sharing = Sharing::kNone;
  std::optional<double> frame_ms;  // how long one round is planned to take
  double busy = 0.0;
  std::vector<CoreUse> uses;  // those that the plan puts there, in its order, then others
};

struct Subchain {
  std::string name;
  std::vector<std::string> nodes;
  double weight = 0.0;     // of the terms that its nodes take part in
  std::vector<int> cores;  // of the plan; empty: there is no plan
  Sharing sharing = Sharing::kNone;
  std::optional<int> priority;  // where it has a fixed one
  std::optional<double> share;  // where it takes turns: which part of its compute time one slot is long
  std::optional<double> expected_period_ms;
  std::optional<double> promised_period_ms;
  std::optional<double> promised_execution_ms;  // from the begin of its head's run to the end of its tail's
  std::optional<double> budget_ms;              // CPU time that one run of all its nodes is planned at
  std::uint64_t runs = 0;                       // through all its nodes, or up to one that gave no output
  Summary period_ms;                            // between completions
  Summary used_ms;                              // CPU time of such a run
  Summary execution_ms;
  std::uint64_t late = 0;      // executions that took longer than was promised when they began
  std::uint64_t overruns = 0;  // runs that were demoted, since they used more than their budget
  Summary trigger_late_ms;     // sent - due
  std::uint64_t stole = 0;     // how often it went on in the slot of another
  double stole_ms = 0.0;
  std::uint64_t stolen = 0;  // how often another subchain went on in its slot
  double stolen_ms = 0.0;
  std::optional<double> silent_ms;  // since a run of one of its nodes ended; none: none has ended
  bool absent = false;              // see Node
};

// A histogram: how many samples are in each of equal intervals from the smallest to the largest.
struct Distribution {
  double from_ms = 0.0;
  double width_ms = 0.0;  // of an interval; 0: all samples are equal, and in the first one
  std::vector<std::uint64_t> counts;
};

// How many responses were late by one cause of docs/why.md.
struct LateBy {
  std::string cause;  // "pre-empted"
  std::uint64_t count = 0;
  friend bool operator==(const LateBy&, const LateBy&) = default;
};

// A response time of the objective.
struct Chain {
  std::string path;
  std::vector<std::string> nodes;
  double weight = 0.0;
  std::optional<double> bound_ms;
  std::optional<double> expected_ms;  // by the plan in force: on average
  std::optional<double> promised_ms;  // and at worst, at the costs that its promises are for
  std::optional<double> newest_ms;    // the last response, however old
  Summary response_ms;
  Summary latency_ms;
  Summary period_ms;
  std::uint64_t over_bound = 0;
  std::uint64_t over_promise = 0;      // longer than was promised when they began
  std::vector<LateBy> late_by;         // those over the bound, without a bound over the promise; most frequent first
  std::vector<LateBy> late_by_in_all;  // the same since viewing began; the newest ones have no cause yet
  std::vector<std::optional<double>> worst_ms;  // of each of the last 60 s, the oldest first; none: no response
  Distribution distribution;                    // of the response times
};

// A node that is not external. It is absent, which is not there or hanging, while the app runs and no run of it has
// ended for ten of its periods (the expected or the measured one, whichever is longer) and for at least a second; where
// none has ended, since the start.
struct Node {
  std::string name;
  std::optional<std::size_t> subchain;  // index; none: it is unscheduled
  std::optional<double> weight;         // of its period, where the objective has it
  std::uint64_t runs = 0;
  double rate_hz = 0.0;
  std::optional<double> expected_hz;
  Summary period_ms;
  Summary compute_ms;  // CPU time of a run
  Summary wait_ms;     // of a run; empty: no run waited
  double cores = 0.0;
  std::optional<double> silent_ms;  // since it ended a run; none: it has ended none
  bool absent = false;
};

struct RelaxedBound {
  std::string bound;  // "objective[0].max"
  double asked_ms = 0.0;
  double planned_ms = 0.0;
};

struct AssumedCost {
  std::string node;
  double cost_ms = 0.0;
};

struct PlanInForce {
  double at_s = 0.0;   // since the start
  std::string reason;  // as the record has it
  std::string planner;
  bool for_typical = false;  // promises are made for typical costs
  double objective = 0.0;    // as expected, where the plan says, else as promised
  double relax_factor = 1.0;
  std::vector<RelaxedBound> relaxed;
  std::vector<AssumedCost> assumed;
};

// Notices, plans that came into force ("plan"), compute times that have changed for good ("cost-change").
struct Event {
  double at_s = 0.0;  // since the start
  std::string kind;
  std::string detail;
  friend bool operator==(const Event&, const Event&) = default;
};

struct Picture {
  std::string app;
  std::string scheduler;
  std::string note;
  bool real_time = false;  // else rates only
  std::vector<int> cpus;   // that the app was started with
  State state = State::kRunning;
  double silent_ms = 0.0;  // since the session's last sign of life
  double up_s = 0.0;       // since the start
  double window_s = 0.0;
  std::uint64_t lost = 0;  // how often events were lost, and figures began anew
  std::optional<PlanInForce> plan;
  std::optional<double> objective;  // the weighted sum of means, as measured; none: a term has no sample
  std::vector<Chain> chains;        // in the order of the objective
  std::vector<Subchain> subchains;  // in the order of the app
  std::vector<Core> cores;          // by CPU
  std::vector<Node> nodes;          // in the order of the app
  std::vector<Event> events;        // the newest, oldest first
  // Of the whole run.
  std::uint64_t plans_made = 0;
  double planning_ms = 0.0;
  std::uint64_t starved = 0;  // how often a core was kept from its controller
  double starved_ms = 0.0;
};

}  // namespace ctn::view
