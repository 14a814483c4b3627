// All that a page shows of one recorded run, read from the record in one pass: plain values in the order that the page
// needs.
//
// A lane is a subchain or an unscheduled node: it has a row in the timeline, on the cores that the plan in force gave
// it. What runs lost to others on their cores is inferred (losses.h).
//
// Units: Micros are microseconds since the run's start, clamped to the run; names that end in _ms: milliseconds. Thread
// safety: plain values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "record/reader.h"
#include "report/metrics.h"
#include "why/history.h"

namespace ctn::page {

using Micros = std::int64_t;

struct Lane {
  std::string name;
  std::vector<NodeId> nodes;
  bool scheduled = true;  // a subchain
};

struct RunSpan {
  std::uint32_t node = 0;
  std::uint32_t mode = 0;
  std::uint64_t number = 0;
  Micros begin = 0;
  Micros end = 0;
  float cpu_ms = 0.0F;
  float wait_ms = 0.0F;
};

struct TriggerPoint {
  Micros sent = 0;
  Micros late = 0;  // after it was due; negative: early
};

struct SlotSpan {  // or a steal
  std::size_t core = 0;
  std::size_t lane = 0;
  Micros begin = 0;
  Micros end = 0;
};

struct StealSpan {
  SlotSpan slot;
  std::size_t victim = 0;  // a lane
};

// A response time, and when it ended.
struct ResponsePoint {
  Micros end = 0;
  double response_ms = 0.0;
};

// Where a plan puts a lane.
struct Placement {
  std::size_t lane = 0;
  std::size_t core = 0;
  int priority = 0;  // 0: it owns the core, or takes turns on it
  friend bool operator==(const Placement&, const Placement&) = default;
};

struct Promise {
  double promised_ms = 0.0;
  std::optional<double> expected_ms;
  friend bool operator==(const Promise&, const Promise&) = default;
};

struct PlanSpan {
  Micros at = 0;  // in force from then until the next plan
  std::string reason;
  std::vector<Placement> placements;  // by core; those of one core in the plan's order
  std::vector<Promise> chains;        // by chain of the story; empty: the plan has other chains
};

enum class EventKind { kPlan, kCost, kChange, kNotice, kOverrun };
const char* to_string(EventKind kind);

struct Event {
  Micros at = 0;
  EventKind kind = EventKind::kNotice;
  std::string text;
  std::optional<std::size_t> lane{};  // of an overrun
  std::optional<std::size_t> node{};  // of a cost change
};

struct Story {
  graph::App app;
  report::RunFigures figures;
  Micros duration = 0;
  Micros measured_from = 0;                           // the end of the warm-up, if that does not count
  std::vector<Lane> lanes;                            // subchains as the app has them, then unscheduled nodes
  std::vector<std::size_t> lane_of;                   // by node; kNoLane: external
  std::size_t cores = 0;                              // as many as plans and slots name
  std::vector<RunSpan> runs;                          // by their ends
  std::vector<std::vector<TriggerPoint>> triggers;    // by lane
  std::vector<SlotSpan> slots;                        // by begin
  std::vector<StealSpan> steals;                      // by begin
  std::vector<std::vector<ResponsePoint>> responses;  // by chain of figures.chains, by end
  std::vector<PlanSpan> plans;                        // by time
  std::vector<Event> events;                          // by time
  std::shared_ptr<const why::History> history;        // of the whole run; null: nothing is known of losses
};

constexpr std::size_t kWorstShown = 5;  // responses of each chain

constexpr std::size_t kNoLane = static_cast<std::size_t>(-1);

// `whole`: figures include the warm-up (the timelines always do). Errors: as report::measure().
Result<Story> tell(const record::Reader& record, bool whole = false);

// Clamped to the run.
Micros when(const Story& story, TimePoint time);

// The plan in force at that time; null: before the first plan.
const PlanSpan* plan_at(const Story& story, Micros at);

}  // namespace ctn::page
