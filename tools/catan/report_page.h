// catan report --html: the page of a record, or of two side by side.
#pragma once

#include <string>

#include "base/result.h"
#include "record/reader.h"

namespace ctn::tool {

// `path`: of the record. `compare`: another record, or empty. `all`: figures include the warm-up.
Result<std::string> report_page(const record::Reader& record, const std::string& path, const std::string& compare,
                                bool all);

}  // namespace ctn::tool
