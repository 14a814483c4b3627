// The application in a record: its tables (nodes, modes, edges, subchains, chains) and its scheduler options in `meta`.
// What was written can be read back as an equal `App`.
#pragma once

#include "base/result.h"
#include "graph/app.h"
#include "record/meta.h"
#include "record/sqlite.h"

namespace ctn::record {

// Precondition: the tables are there and empty.
Status write_app(sqlite::Database& database, const graph::App& app);

// Errors: kCaller, where the tables hold what no writer wrote.
Result<graph::App> read_app(sqlite::Database& database, const Meta& meta);

}  // namespace ctn::record
