// `catan sim --validate RECORD`: how far a simulation is from a real run of the same app, with the same compute times
// run by run, on as many cores, under the same policy and the same changes of plan.
//
// Thread safety: pure, but for reading the record.
#pragma once

#include <functional>
#include <string>

#include "base/result.h"

namespace ctn::tool {

struct Validation {
  std::string text;
  std::string json;  // docs/sim-schema.md
};

// Errors: those of the reader, a record without runs, plans that cannot be read.
// `on_progress`: is told which part of the run is simulated.
Result<Validation> validate_against(const std::string& record, const std::function<void(double)>& on_progress);

}  // namespace ctn::tool
