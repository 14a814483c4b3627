// SQLite's C interface with owners: a database and its statements, failures as values. Only for this module's sources.
//
// Failures are kEnvironment where the machine is at fault (a full disk, no permission), kCaller where the file is (it
// is damaged, or no database). Thread safety: none; one owner of a database and all its statements.
#pragma once

#include <sqlite3.h>

#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"

namespace ctn::record::sqlite {

class Statement {
 public:
  // Binds the values to the parameters in order, runs to the end, and is ready to run again.
  template <class... Values>
  Status run(const Values&... values) {
    int index = 0;
    (bind(++index, values), ...);
    return finish();
  }

  void bind(int index, std::int64_t value) { sqlite3_bind_int64(statement_.get(), index, value); }
  void bind(int index, double value) { sqlite3_bind_double(statement_.get(), index, value); }
  void bind(int index, std::string_view value);
  void bind(int index, std::nullopt_t) { sqlite3_bind_null(statement_.get(), index); }
  template <std::integral T>
  void bind(int index, T value) {
    bind(index, static_cast<std::int64_t>(value));
  }
  template <class T>
  void bind(int index, const std::optional<T>& value) {
    value ? bind(index, *value) : bind(index, std::nullopt);
  }

  // Moves to the next row of the result; false at its end, where the statement is ready to run again.
  Result<bool> next();
  void reset() { sqlite3_reset(statement_.get()); }

  // Of the row moved to; columns count from 0. Precondition for the values: the column is of that type.
  int type(int column) { return sqlite3_column_type(statement_.get(), column); }
  std::int64_t integer(int column) { return sqlite3_column_int64(statement_.get(), column); }
  double real(int column) { return sqlite3_column_double(statement_.get(), column); }
  std::string text(int column);

 private:
  friend class Database;
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  Statement(sqlite3_stmt* statement, std::string path) : statement_(statement), path_(std::move(path)) {}
  Status finish();

  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  std::string path_;
};

class Database {
 public:
  // `flags` as for sqlite3_open_v2. A path is a path: never a URI, never a database in memory.
  static Result<Database> open(const std::string& path, int flags);

  // One of its own in memory, empty, or with the content that image() of another gave.
  static Result<Database> in_memory(std::span<const std::byte> image = {});

  // The bytes of a file with this content.
  Result<std::vector<std::byte>> image();
  // One or more statements without results.
  Status execute(const std::string& sql);
  Result<Statement> prepare(std::string_view sql);
  // Calls `take`, a Status(Statement&), for each row of the query's result, until one fails.
  template <class Take>
  Status each_row(std::string_view sql, Take take) {
    Result<Statement> rows = prepare(sql);
    if (!rows) return rows.error();
    while (true) {
      const Result<bool> row = rows->next();
      if (!row) return row.error();
      if (!*row) return Done{};
      if (Status done = take(*rows); !done) return done;
    }
  }

  // How long a call waits for another program's lock before it fails as busy.
  void set_busy_timeout(std::chrono::milliseconds limit);
  // SQLite's code for the last failure.
  int code() const { return sqlite3_extended_errcode(database_.get()); }
  bool busy() const { return (code() & 0xff) == SQLITE_BUSY; }
  bool in_transaction() const { return sqlite3_get_autocommit(database_.get()) == 0; }
  sqlite3* handle() const { return database_.get(); }
  const std::string& path() const { return path_; }
  Error error() const;

 private:
  struct Close {
    void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
  };
  Database(sqlite3* database, std::string path) : database_(database), path_(std::move(path)) {}

  std::unique_ptr<sqlite3, Close> database_;
  std::string path_;
};

}  // namespace ctn::record::sqlite
