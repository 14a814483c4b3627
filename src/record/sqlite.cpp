#include "record/sqlite.h"

#include <fmt/format.h>

#include <cstring>

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

Result<Database> Database::in_memory(std::span<const std::byte> image) {
  sqlite3* handle = nullptr;
  const int opened = sqlite3_open_v2(":memory:", &handle, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
  const auto out_of_memory = [] {
    return Error::environment("a record in memory: out of memory", "free some memory and try again");
  };
  if (handle == nullptr) return out_of_memory();
  Database database(handle, "a record in memory");
  if (opened != SQLITE_OK) return database.error();
  sqlite3_extended_result_codes(handle, 1);
  if (image.empty()) return database;
  const auto size = static_cast<sqlite3_int64>(image.size());
  auto* const copy = static_cast<unsigned char*>(sqlite3_malloc64(static_cast<sqlite3_uint64>(size)));
  if (copy == nullptr) return out_of_memory();
  std::memcpy(copy, image.data(), image.size());
  // The database owns the copy from now on, whether or not this succeeds.
  const int code = sqlite3_deserialize(handle, "main", copy, size, size, SQLITE_DESERIALIZE_FREEONCLOSE);
  if (code != SQLITE_OK) return database.error();
  return database;
}

Result<std::vector<std::byte>> Database::image() {
  sqlite3_int64 size = 0;
  const std::unique_ptr<unsigned char, void (*)(void*)> bytes(sqlite3_serialize(database_.get(), "main", &size, 0),
                                                              sqlite3_free);
  if (!bytes) return Error::environment(path_ + ": out of memory", "free some memory and try again");
  const auto* const first = reinterpret_cast<const std::byte*>(bytes.get());
  return std::vector<std::byte>(first, first + size);
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
