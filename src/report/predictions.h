// The plans of a record, averaged over the time each was in force.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "graph/app.h"
#include "record/reader.h"
#include "report/metrics.h"

namespace ctn::report {

struct Predictions {
  std::uint64_t plans = 0;    // in force at any time in the interval
  double relax_factor = 1.0;  // the largest among them
  std::optional<double> objective;
  std::vector<std::optional<ChainPrediction>> chains;  // by response-time term, in the order of the objective
  std::vector<std::optional<double>> rate_hz;          // by NodeId; none: not in a subchain, or no plan in force
};

// Between `begin` and `end`. Time before the first plan counts for nothing.
Result<Predictions> predictions(const record::Reader& record, TimePoint begin, TimePoint end);

}  // namespace ctn::report
