// Compute times from a file that a user names: a cost file, or the record of a run.
//
// Units: in the types. Thread safety: pure, but for the file.
#pragma once

#include <string>

#include "base/result.h"
#include "graph/app.h"
#include "model/cost.h"
#include "trial/samples.h"

namespace ctn::api {

struct KnownCosts {
  model::CostTable costs;  // the percentiles that promises go by
  trial::Samples samples;  // what single runs cost
};

// Errors: all that is wrong with the file, or not of the app; of a record as policy::costs_of_record().
Result<KnownCosts> known_costs(const std::string& file, const graph::App& app);

}  // namespace ctn::api
