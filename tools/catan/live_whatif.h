// What-if questions about a running app: what would be planned if it had other weights, bounds, costs or cores. This
// plans as the app's session would, by the measured compute times of the runs that its flight recorder still keeps.
// Nothing is changed.
//
// Units: as web/what_if.h. Thread safety: KnownSoFar has one owner; what_if() is a pure function but for the clock.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/ticks.h"
#include "graph/app.h"
#include "os/os.h"
#include "plan/plan.h"
#include "policy/cpu_kinds.h"
#include "policy/measured_costs.h"
#include "record/sink.h"
#include "record/writer.h"
#include "web/what_if.h"

namespace ctn::tool {

// What planning needs to know of a running app. Filled from the app's recording.
class KnownSoFar final : public record::PartialSink {
 public:
  using PartialSink::add;

  // Both outlive it.
  KnownSoFar(const graph::App& app, const record::Header& header);

  void add(const record::Run& run) override { measured_.add(run, kinds_.of(run.on_cpu)); }
  void add(const record::PlanChange& change) override;
  void add(const record::AppChange& change) override;
  void add(const record::ClockReading& reading) override;

  const graph::App& app() const { return app_; }  // with the weights and bounds that hold
  const record::Header& header() const { return header_; }
  const policy::CpuKinds& kinds() const { return kinds_; }
  const policy::MeasuredCosts& measured() const { return measured_; }
  const std::optional<plan::Plan>& plan() const { return plan_; }  // in force
  const std::vector<Ticks>& clocks() const { return clocks_; }     // by NodeId, as in policy::Situation

 private:
  const record::Header& header_;
  graph::App app_;
  policy::CpuKinds kinds_;
  policy::MeasuredCosts measured_;
  std::optional<plan::Plan> plan_;
  TimePoint plan_at_{};
  std::vector<Ticks> clocks_;
};

// JSON, as docs/http.md has it. Takes at most about a second of CPU time, and some seconds of time. Errors
// (kCaller): a change, a cost or a number of cores that does not fit the app; a scheduler that does not plan by what is
// measured; no plan was found.
Result<std::string> what_if(const KnownSoFar& known, const web::WhatIf& asked, os::Clock& clock);

}  // namespace ctn::tool
