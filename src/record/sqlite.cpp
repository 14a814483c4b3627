#include "record/sqlite.h"

#include <fmt/format.h>

namespace ctn::record::sqlite {
namespace {

Error error_of(sqlite3* database, const std::string& path) {
  const int code = sqlite3_errcode(database) & 0xff;
  const std::string what = fmt::format("{}: {}", path, sqlite3_errmsg(database));
  switch (code) {
    case SQLITE_FULL:
      return Error::environment(what, "make room on the disk");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return Error::environment(what, "close the program that holds the file and try again");
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
    case SQLITE_READONLY:
    case SQLITE_AUTH:
      return Error::environment(what, "check that the file and its folder are there and may be read and written");
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
    case SQLITE_ERROR:
    case SQLITE_CONSTRAINT:
    case SQLITE_MISMATCH:
    case SQLITE_TOOBIG:
    case SQLITE_FORMAT:
      return Error::caller(what, "the file is damaged or no Catan record; take one that `catan run --record` made");
    default:
      return Error::environment(what, "check the disk and try again");
  }
}

}  // namespace

void Statement::bind(int index, std::string_view value) {
  sqlite3_bind_text(statement_.get(), index, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
}

Result<bool> Statement::next() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) {
    sqlite3_reset(statement_.get());
    return false;
  }
  Error error = error_of(sqlite3_db_handle(statement_.get()), path_);
  sqlite3_reset(statement_.get());
  return error;
}

std::string Statement::text(int column) {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  if (bytes == nullptr) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

Status Statement::finish() {
  const Result<bool> row = next();
  if (!row) return row.error();
  reset();
  return Done{};
}

Result<Database> Database::open(const std::string& path, int flags) {
  // SQLite gives ":memory:" and "file:..." a meaning of their own.
  const std::string plain = path.empty() || path.front() == '/' ? path : "./" + path;
  sqlite3* handle = nullptr;
  const int code = sqlite3_open_v2(plain.c_str(), &handle, flags | SQLITE_OPEN_NOMUTEX, nullptr);  // has one owner
  if (handle == nullptr) return Error::environment(path + ": out of memory", "free some memory and try again");
  Database database(handle, path);
  if (code != SQLITE_OK) return database.error();
  sqlite3_extended_result_codes(handle, 1);
  return database;
}

Status Database::execute(const std::string& sql) {
  if (sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) return error();
  return Done{};
}

Result<Statement> Database::prepare(std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v2(database_.get(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr);
  if (code != SQLITE_OK) return error();
  return Statement(statement, path_);
}

void Database::set_busy_timeout(std::chrono::milliseconds limit) {
  sqlite3_busy_timeout(database_.get(), static_cast<int>(limit.count()));
}

Error Database::error() const { return error_of(database_.get(), path_); }

}  // namespace ctn::record::sqlite
