// What a session has measured, for the snapshot (driver/measurements.h): written by the housekeeping thread, read by
// any.
//
// Units: Nanos in, milliseconds out. Memory: bounded, the newest `kSamples` of each metric.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/statistics.h"
#include "base/time.h"
#include "driver/event_log.h"
#include "driver/measurements.h"

namespace ctn::runtime {

// The newest samples of one metric.
class SampleWindow {
 public:
  static constexpr std::size_t kSamples = 16384;

  void add(Nanos sample);
  Summary summary_ms() const;  // count: all there ever were; the rest: of the ones kept

 private:
  std::vector<double> samples_;  // milliseconds
  std::size_t next_ = 0;
  std::uint64_t count_ = 0;
};

using Measurements = driver::Measurements<SampleWindow>;
using EventLog = driver::EventLog<SampleWindow>;

}  // namespace ctn::runtime
