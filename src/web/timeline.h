// How much of each CPU each subchain used in the last 30 seconds, for the timelines of the live page. It takes the
// events of a run (record/sink.h) and keeps busy shares in steps of a tenth of a second, about as fine as a screen can
// show 30 seconds. It also keeps the plan in force.
//
// The CPU time of a run counts evenly between its begin and its end, on the CPU on which it ended. Unscheduled nodes
// are shown like subchains, after these.
//
// Units: instants of the monotonic clock. Thread safety: none; one owner. Memory: at most kMaxCpus CPUs, each with
// kSteps steps for each subchain that used it. No event is trusted.
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

class Timeline final : public record::PartialSink {
 public:
  static constexpr Nanos kStep = std::chrono::milliseconds{100};
  static constexpr std::size_t kSteps = 300;
  static constexpr std::size_t kMaxCpus = 256;

  Timeline(const graph::App& app, TimePoint started);

  using PartialSink::add;
  void add(const record::Run& run) override;
  void add(const record::PlanChange& change) override { plan_ = change.json; }

  // {"step_ms": 100, "until_s": 12.3, "lanes": ["local", "GM"],
  //  "cpus": [{"cpu": 0, "busy": [{"lane": 0, "permille": [0, 250, 1000]}]}]}
  // The last number of each list is for the step that ends at `until_s`, in seconds since the start. Lists go back 30
  // s, or to the start. Lanes that did not use a CPU are left out there. A CPU of null: not known on which one runs
  // ended.
  std::string json(TimePoint now) const;
  // The plan in force as JSON (docs/plan-schema.md); empty: there is none.
  const std::string& plan() const { return plan_; }

 private:
  // The CPU time of one lane on one CPU, by step modulo their count.
  struct Busy {
    std::array<std::int64_t, kSteps> step{};  // the step that each place is for; -1: none
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
