// Opens the file of a record, of which nothing is known yet, and checks that it is one: neither its schema nor its size
// is trusted.
//
// Thread safety: pure functions on a connection that the caller owns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "base/result.h"
#include "record/sqlite.h"

namespace ctn::record {

// A record of this version or an older one; tables that it lacks because it is older are there, and empty. Errors: see
// Reader::open().
Result<sqlite::Database> open_record(const std::string& path);
// The same of the bytes of one.
Result<sqlite::Database> open_record(std::span<const std::byte> image);

// Of a query that gives one row; 0 where it gives none, or no integer.
Result<std::int64_t> one_integer(sqlite::Database& database, const std::string& sql);

}  // namespace ctn::record
