// The metrics of a run as an HTML page.
#pragma once

#include <string>

#include "report/metrics.h"

namespace ctn::report {

std::string to_html(const RunFigures& metrics);

}  // namespace ctn::report
