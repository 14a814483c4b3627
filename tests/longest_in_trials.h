// For tests: what trials of a schedule come to at worst.
#pragma once

#include <algorithm>
#include <chrono>
#include <memory>

#include "base/time.h"
#include "graph/app.h"
#include "model/cost.h"
#include "trial/samples.h"
#include "trial/schedule.h"
#include "trial/trial.h"
#include "trial_runs.h"

namespace ctn {

// A trial where scheduling costs nothing; its observer is told of each run.
inline void watch(const graph::App& app, const trial::Samples& samples, const trial::Schedule& schedule,
                  trial::Options options) {
  options.overheads = trial::Overheads::none();
  static_cast<void>(trial::Trial(app, samples).run(schedule, options));
}

struct Longest {
  void add(Nanos value) {
    longest = std::max(longest, value);
    ++count;
  }
  Nanos longest{0};
  int count = 0;
};

// Each run takes what is planned.
inline trial::Samples constant(const graph::App& app, const model::CostTable& costs) {
  return {app, trial::MeasuredRuns{}, costs};
}

// What a schedule comes to in so long, where scheduling costs nothing.
inline std::unique_ptr<Measured<Longest>> longest_in(const graph::App& app, const trial::Samples& samples,
                                                     const trial::Schedule& schedule, Nanos horizon) {
  const Nanos warm_up = std::chrono::seconds{1};
  auto seen =
      std::make_unique<Measured<Longest>>(app, record::Interval{TimePoint{warm_up}, TimePoint{warm_up + horizon}});
  watch(app, samples, schedule, {.horizon = horizon, .warm_up = warm_up, .observer = seen.get()});
  return seen;
}

}  // namespace ctn
