// The record's table of single facts: `meta(key, value)`.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "base/result.h"
#include "base/time.h"
#include "record/sqlite.h"

namespace ctn::record {

class Meta {
 public:
  // Reads the whole table.
  static Result<Meta> read(sqlite::Database& database);

  // nullopt: not there, or not of that type or range.
  std::optional<std::int64_t> integer(std::string_view key) const;
  std::optional<double> real(std::string_view key) const;
  std::optional<std::string> text(std::string_view key) const;
  std::optional<Nanos> duration(std::string_view key) const;

 private:
  std::map<std::string, std::variant<std::int64_t, double, std::string>, std::less<>> values_;
};

// Sets keys in the table, new or not.
class MetaWriter {
 public:
  static Result<MetaWriter> prepare(sqlite::Database& database);

  // The first failure; later calls do nothing once there is one.
  template <class T>
  MetaWriter& set(std::string_view key, const T& value) {
    if (status_) status_ = statement_.run(key, value);
    return *this;
  }
  Status status() const { return status_; }

 private:
  explicit MetaWriter(sqlite::Statement statement) : statement_(std::move(statement)) {}
  sqlite::Statement statement_;
  Status status_ = Done{};
};

}  // namespace ctn::record
