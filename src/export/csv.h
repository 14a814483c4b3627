// A record's tables as CSV (docs/export.md): names in place of ids, instants in seconds since the start, durations
// in milliseconds, both exact to the nanosecond. Fields are quoted where RFC 4180 requires it; lines end in a newline
// alone.
#pragma once

#include <span>
#include <string_view>

#include "base/result.h"
#include "export/output.h"
#include "record/reader.h"

namespace ctn::exports {

// The names of all tables.
std::span<const std::string_view> csv_tables();

// Writes a table, its column names first. Precondition: `table` is one of csv_tables(). Errors: those of the reader and
// of the sink; a plan in the record that cannot be read (kCaller).
Status write_csv(const record::Reader& record, std::string_view table, const Sink& sink, const Progress& progress);

}  // namespace ctn::exports
