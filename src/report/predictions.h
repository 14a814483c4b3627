// The plans of a record, averaged over the time each was in force.
#pragma once

#include "base/result.h"
#include "base/time.h"
#include "plan/predicted_means.h"
#include "record/reader.h"

namespace ctn::report {

// Between `begin` and `end`. Time before the first plan counts for nothing.
Result<plan::Predictions> predictions(const record::Reader& record, TimePoint begin, TimePoint end);

}  // namespace ctn::report
