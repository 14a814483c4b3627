// Reads the columns of a row that anyone may have written: each value's type and range is checked, and the first that
// is wrong is remembered. Ask ok() before what was read is used.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "base/time.h"
#include "record/sqlite.h"

namespace ctn::record {

// Times of a record lie below this, so that differences of two never overflow: 73 years of a machine's uptime.
constexpr std::int64_t kTimeLimit = std::int64_t{1} << 61;

class Cells {
 public:
  explicit Cells(sqlite::Statement& row) : row_(&row) {}

  bool ok() const { return ok_; }
  void refuse() { ok_ = false; }
  bool null(int column) { return row_->type(column) == SQLITE_NULL; }

  std::int64_t integer(int column, std::int64_t min = 0, std::int64_t max = std::numeric_limits<std::int64_t>::max()) {
    if (row_->type(column) != SQLITE_INTEGER) return wrong(min);
    const std::int64_t value = row_->integer(column);
    return value < min || value > max ? wrong(min) : value;
  }
  std::size_t index(int column, std::size_t size) {
    if (size == 0) return wrong(std::size_t{0});
    return static_cast<std::size_t>(integer(column, 0, static_cast<std::int64_t>(size) - 1));
  }
  std::uint64_t number(int column) { return static_cast<std::uint64_t>(integer(column, 1)); }
  bool flag(int column) { return integer(column, 0, 1) != 0; }
  TimePoint time(int column) { return TimePoint{duration(column)}; }
  Nanos duration(int column) { return Nanos{integer(column, 0, kTimeLimit)}; }

  double real(int column) {
    const int type = row_->type(column);
    if (type != SQLITE_FLOAT && type != SQLITE_INTEGER) return wrong(0.0);
    const double value = row_->real(column);
    return std::isfinite(value) ? value : wrong(0.0);
  }
  std::string text(int column) { return row_->type(column) == SQLITE_TEXT ? row_->text(column) : wrong(std::string{}); }

 private:
  template <class T>
  T wrong(T instead) {
    ok_ = false;
    return instead;
  }

  sqlite::Statement* row_;
  bool ok_ = true;
};

// What a reader says of a table whose rows no writer wrote.
inline Error damaged(const sqlite::Database& database, const std::string& table) {
  return Error::caller(database.path() + ": table '" + table + "' holds values that Catan does not write",
                       "the record is damaged; take a copy that is not");
}

}  // namespace ctn::record
