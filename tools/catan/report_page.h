// catan report --html: the page of a record, or of two side by side.
#pragma once

#include <string>

#include "record/reader.h"

namespace ctn::tool {

struct PageOptions {
  std::string file;     // empty: stdout
  std::string compare;  // another record; empty: none
};

// Makes and writes it; gives the exit code. `path`: of the record. `all`: figures include the warm-up.
int report_page(const record::Reader& record, const std::string& path, const PageOptions& options, bool all);

}  // namespace ctn::tool
