// What must be known of a whole run before its responses can be taken apart one after the other, in a second reading:
// which of them are late, what the runs of a node usually cost, how long a run can take, what the record tells at all.
//
// Units: in the types and names. Thread safety: none; one owner. Memory: 4 bytes a run of the app, 8 a response.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/statistics.h"
#include "base/time.h"
#include "graph/app.h"
#include "record/events.h"
#include "record/lineage.h"
#include "record/run_metrics.h"
#include "why/durations.h"

namespace ctn::why {

// Of the responses of one chain.
struct Lengths {
  Summary response_ms{};
  Nanos late_over{0};         // the bound, or the 99th percentile; 0 where there are no responses
  bool usually_late = false;  // the median is longer than that
};
Lengths lengths_of(std::vector<double> responses_ms, std::optional<Nanos> bound);

class Survey {
 public:
  // `app` outlives it. Precondition: the terms are response times.
  Survey(const graph::App& app, const std::vector<std::size_t>& terms, const record::Interval& measured);

  // In the order that record::ChainTracker requires.
  void add(const record::Run& run);
  // Before the runs that end later.
  void add(const record::ClockReading& reading);
  // To be called once, after all were added, and before what follows.
  void finish();

  const std::vector<Lengths>& lengths() const { return lengths_; }     // by place in `terms`
  const std::vector<Nanos>& usual_cpu() const { return usual_cpu_; }   // by NodeId: the median
  Nanos longest_run() const { return longest_run_; }                   // from begin to end
  bool knows_clock(NodeId node) const { return read_[node.index()]; }  // at any time
  bool knows_cpus() const { return knows_cpus_; }                      // of some run it is known on which it ended

 private:
  struct Chain {
    std::size_t term = 0;
    record::ChainTracker tracker;
    std::optional<TimePoint> before{};  // begin of the sample before
    std::vector<double> responses_ms{};
  };

  const graph::App& app_;
  record::Interval measured_;
  std::vector<Chain> chains_;
  std::vector<Durations> cpu_;  // by NodeId
  std::vector<Lengths> lengths_;
  std::vector<Nanos> usual_cpu_;
  Nanos longest_run_{0};
  bool knows_cpus_ = false;
  std::vector<bool> read_;  // by NodeId
};

}  // namespace ctn::why
