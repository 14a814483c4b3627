// What happened in a run of the app, in memory, sorted for the questions of the analysis: the runs of a node, which run
// had a core when, which trigger a run goes back to, which plan was in force.
//
// It is filled, then sorted by sort(), and asked only after that. A question about n events takes log n steps. A
// million runs take about 100 MB. So those of a long record are added in the order of their ends, and forgotten once no
// question about them is left; the other events stay.
//
// The core of a run is the CPU that it ended on. If the record does not say that, it is the one core that the plan in
// force gave its subchain, or the only CPU there was; else it is not known.
//
// Units: in the types. Thread safety: none while it is filled, then any.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "base/result.h"
#include "base/ticks.h"
#include "graph/app.h"
#include "plan/plan.h"
#include "record/events.h"

namespace ctn::why {

constexpr int kUnknownCore = -1;

struct RunTimes {
  std::uint64_t number = 0;
  TimePoint begin{};
  TimePoint end{};
  Nanos cpu{0};
  Nanos wait{0};
  int core = kUnknownCore;
  bool emitted = false;
};

// A run, by its node and its place among the node's runs.
struct RunRef {
  NodeId node;
  std::size_t index = 0;
  friend bool operator==(const RunRef&, const RunRef&) = default;
};

struct SentTrigger {
  TimePoint due{};
  TimePoint sent{};
};

struct Span {
  TimePoint begin{};
  TimePoint end{};
};

// What had a core for a while: a run of `node`; nothing of the app; or one of several runs, it is not known which
// (`unsure`).
struct Holder {
  Span time;
  std::optional<NodeId> node{};
  bool unsure = false;
};

class History {
 public:
  // `cpus`: how many the app could use.
  History(graph::App app, std::size_t cpus);

  void add(const record::Run& run);
  void add(const record::Trigger& trigger);
  void add(const record::SlotUse& slot);
  void add(const record::Steal& steal);
  void add(const record::ClockReading& reading);
  Status add(const record::PlanChange& change);  // kCaller: a plan that cannot be read
  void sort();
  // For a history that will not have all runs at any time: what is usual of all of them (by NodeId), and whether it is
  // known of any of them on which CPU it ended. To be called before runs are added.
  void expect(const std::vector<Nanos>& usual_cpu, bool knows_cpus);
  // After sort(): forgets the runs that ended before then, except those that a question about later times may lead to:
  // of each node its first one, and the last ones that ended and gave an output before then. Returns how many it forgot
  // of each node, by NodeId: those that followed the first one. It must be sorted again before it is asked.
  std::vector<std::size_t> forget_before(TimePoint time);

  const graph::App& app() const { return app_; }
  std::size_t size() const;  // runs
  std::span<const RunTimes> runs(NodeId node) const { return runs_[node.index()]; }
  const RunTimes& run(const RunRef& ref) const { return runs_[ref.node.index()][ref.index]; }
  std::optional<RunRef> find(NodeId node, std::uint64_t number) const;
  // The last run of the node that had ended by then; with `emitted`, the last one that also gave an output.
  std::optional<RunRef> last_ended(NodeId node, TimePoint by, bool emitted) const;
  // The last end of a run of any of the subchain's nodes in (after, by].
  std::optional<TimePoint> last_end(SubchainId subchain, TimePoint after, TimePoint by) const;
  // The median CPU time of the node's runs.
  Nanos usual_cpu(NodeId node) const { return usual_cpu_[node.index()]; }

  const SentTrigger* last_sent(SubchainId subchain, TimePoint by) const;
  const plan::Plan* plan_at(TimePoint time) const;  // null: none was in force
  // The last time in (after, before) at which a plan replaced another.
  std::optional<TimePoint> plan_changed(TimePoint after, TimePoint before) const;
  // Whether the subchain took turns on its core, in frames.
  bool took_turns(SubchainId subchain, TimePoint time) const;
  std::optional<Ticks> ticks(NodeId node, TimePoint time) const;

  // Passes to `take` (RunRef, bool sure) each run that was under way in `span`, on that core (sure) or on one that is
  // not known, except those of the node `but`. If the core is not known: all runs, on any core.
  template <class Take>
  void each_overlapping(int core, Span span, NodeId but, Take take) const;
  // What had a core in `span`, without gaps: of the runs that were under way, except those of `but`, the one that began
  // last.
  std::vector<Holder> holders(int core, Span span, NodeId but) const;

  // When a subchain that takes turns was active: its own slots, and where it stole, if they overlap with `span`.
  std::vector<Span> active(SubchainId subchain, Span span) const;
  struct Theft {
    Span time;
    SubchainId thief;
  };
  std::vector<Theft> thefts(SubchainId victim, Span span) const;

 private:
  struct Busy {
    TimePoint begin{};
    TimePoint end{};
    TimePoint latest{};  // the latest end of this run and all before it
    RunRef run;
  };
  struct InForce {
    TimePoint at{};
    plan::Plan plan;
  };
  struct Reading {
    TimePoint at{};
    Ticks ticks;
  };
  void place_by_plans();
  void sort_others();
  void find_usual();
  template <class Take>
  void each_in(const std::vector<Busy>& busy, Span span, NodeId but, Take take) const;

  graph::App app_;
  std::size_t cpus_;
  bool knows_cpus_ = false;
  std::vector<std::vector<RunTimes>> runs_;         // by NodeId, by number
  std::vector<std::vector<SentTrigger>> triggers_;  // by SubchainId, by when they were sent
  std::vector<std::vector<Span>> active_;           // by SubchainId
  std::vector<std::vector<Theft>> thefts_;          // by SubchainId
  std::vector<std::vector<Reading>> clocks_;        // by NodeId
  std::vector<InForce> plans_;
  std::map<int, std::vector<Busy>> busy_;  // by core
  std::vector<Nanos> usual_cpu_;           // by NodeId
  bool knows_usual_ = false;               // it was told by expect()
  bool others_sorted_ = false;             // all but runs
};

template <class Take>
void History::each_in(const std::vector<Busy>& busy, Span span, NodeId but, Take take) const {
  auto each = std::partition_point(busy.begin(), busy.end(), [&](const Busy& one) { return one.latest <= span.begin; });
  for (; each != busy.end() && each->begin < span.end; ++each) {
    if (each->end > span.begin && each->run.node != but) take(each->run);
  }
}

template <class Take>
void History::each_overlapping(int core, Span span, NodeId but, Take take) const {
  for (const auto& [number, busy] : busy_) {
    if (core != kUnknownCore && number != kUnknownCore && number != core) continue;
    const bool sure = core != kUnknownCore && number == core;
    each_in(busy, span, but, [&](const RunRef& run) { take(run, sure); });
  }
}

}  // namespace ctn::why
