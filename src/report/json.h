// The metrics of a run as JSON, for programs.
#pragma once

#include <string>

#include "report/metrics.h"

namespace ctn::report {

// One document, indented by one space, with a newline at its end. Units are in the names of the keys; what was not
// measured or predicted is null. Schema: docs/report-schema.md.
std::string to_json(const RunFigures& metrics);

}  // namespace ctn::report
