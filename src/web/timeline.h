// Which subchain had how much of which CPU in the last 30 seconds, for the page's timelines: fed by what happens in a
// run (record/sink.h), it keeps the busy shares of steps of a tenth of a second, which is what a screen can show of so
// long a time. It keeps the plan in force, too.
//
// The CPU time of a run counts evenly between its begin and its end, on the CPU on which it ended. Unscheduled nodes
// are shown as subchains are, after them.
//
// Units: instants of the monotonic clock. Thread safety: none; one owner. Memory: at most kMostCpus CPUs, each with
// kSteps steps of all subchains that were there; nothing that it is fed is trusted.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/time.h"
#include "graph/app.h"
#include "record/sink.h"

namespace ctn::web {

class Timeline final : public record::Sink {
 public:
  static constexpr Nanos kStep = std::chrono::milliseconds{100};
  static constexpr std::size_t kSteps = 300;
  static constexpr std::size_t kMostCpus = 256;

  Timeline(const graph::App& app, TimePoint started);

  void add(const record::Run& run) override;
  void add(const record::PlanChange& change) override { plan_ = change.json; }
  void add(const record::Trigger&) override {}
  void add(const record::SlotUse&) override {}
  void add(const record::Steal&) override {}
  void add(const record::Overrun&) override {}
  void add(const record::CostChange&) override {}
  void add(const record::AppChange&) override {}
  void add(const record::ClockReading&) override {}
  void add(const record::Notice&) override {}
  void set_totals(const record::Totals&) override {}

  // {"step_ms": 100, "until_s": 12.3, "lanes": ["local", "GM"],
  //  "cpus": [{"cpu": 0, "busy": [{"lane": 0, "permille": [0, 250, 1000]}]}]}
  // The last of each list is of the step that ends at `until_s`, seconds since the start; as long as 30 s, or since the
  // start. Lanes that were not there are left out. A CPU of null: where a run ended is not known.
  std::string json(TimePoint now) const;
  // JSON (docs/plan-schema.md); empty: there is none.
  const std::string& plan() const { return plan_; }

 private:
  // The CPU time of one lane on one CPU, by step modulo their count.
  struct Busy {
    std::array<std::int64_t, kSteps> step{};  // which one it is of; -1: none
    std::array<float, kSteps> share{};
  };

  std::int64_t step_of(TimePoint at) const { return (at - started_) / kStep; }

  TimePoint started_;
  std::vector<std::string> names_;                 // by lane
  std::vector<std::size_t> lane_of_;               // by NodeId
  std::map<int, std::map<std::size_t, Busy>> of_;  // by CPU, by lane
  std::string plan_;
};

}  // namespace ctn::web
