#include "report/predictions.h"

#include <fmt/format.h>

#include <cstddef>

#include "plan/json.h"

namespace ctn::report {

Result<plan::Predictions> predictions(const record::Reader& record, TimePoint begin, TimePoint end) {
  const auto changes = record.plans();
  if (!changes) return changes.error();
  plan::PredictedMeans means(record.app(), begin);
  for (std::size_t i = 0; i < changes->size() && changes->at(i).at < end; ++i) {
    if (i + 1 < changes->size() && changes->at(i + 1).at <= begin) continue;
    const record::PlanChange& change = changes->at(i);
    const auto plan = plan::from_json(change.json, record.app(), fmt::format("plan {} of the record", i + 1));
    if (!plan) return plan.error();
    means.in_force(change.at, *plan);
  }
  return means.until(end);
}

}  // namespace ctn::report
