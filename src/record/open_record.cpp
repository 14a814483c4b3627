#include "record/open_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "record/schema.h"

namespace ctn::record {
namespace {

constexpr std::chrono::milliseconds kWait{5000};  // for a writer's commit
constexpr int kLongestValue = 64 << 20;           // bytes of one value: far above what a writer writes

const char* const kNoRecordHint = "name a file that `catan run --record FILE` made";

Status readable(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "rbe");
  if (file != nullptr) {
    errno = 0;
    const bool refused = std::fgetc(file) == EOF && std::ferror(file) != 0;  // as by a folder
    const int why = errno;
    std::fclose(file);
    if (!refused) return Done{};
    errno = why;
  }
  const std::string what = fmt::format("{} cannot be read: {}", path, std::strerror(errno));
  if (errno == ENOENT || errno == ENOTDIR || errno == EISDIR) return Error::caller(what, kNoRecordHint);
  return Error::environment(what, "get the permission to read it");
}

// Nothing is known yet of what it holds: neither its schema nor its size is trusted.
Status guard(sqlite::Database& database) {
  database.set_busy_timeout(kWait);
  sqlite3* handle = database.handle();
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, kLongestValue);
  return database.execute("PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0");
}

Result<sqlite::Database> open_guarded(const std::string& path, int flags) {
  auto database = sqlite::Database::open(path, flags);
  if (!database) return database;
  if (auto done = guard(*database); !done) return done.error();
  return database;
}

// Puts the file in order where a writer was killed in the middle of a flush: only a connection that may write can.
Status roll_back_journal(const std::string& path) {
  auto database = open_guarded(path, SQLITE_OPEN_READWRITE);
  if (!database) return database.error();
  const auto version = one_integer(*database, "PRAGMA user_version");
  if (!version) return version.error();
  return Done{};
}

// With a consistent content, whatever it is.
Result<sqlite::Database> open_consistent(const std::string& path) {
  if (auto done = readable(path); !done) return done.error();
  auto database = open_guarded(path, SQLITE_OPEN_READONLY);
  if (!database) return database;
  const auto version = one_integer(*database, "PRAGMA user_version");
  if (version) return database;
  const int code = database->code() & 0xff;
  if (code != SQLITE_READONLY && code != SQLITE_CANTOPEN) return version.error();
  if (auto done = roll_back_journal(path); !done) {
    return Error::environment(path +
                                  ": the process that wrote this record was killed in the middle of a write, and the " +
                                  "file cannot be put in order: " + done.error().problems().front().what,
                              "copy the file and the one ending in '-journal' to where they may be written");
  }
  return open_guarded(path, SQLITE_OPEN_READONLY);
}

Status check_version(sqlite::Database& database) {
  const auto application = one_integer(database, "PRAGMA application_id");
  if (!application) return application.error();
  if (*application != kApplicationId) return Error::caller(database.path() + " is no Catan record", kNoRecordHint);
  const auto version = one_integer(database, "PRAGMA user_version");
  if (!version) return version.error();
  if (*version > kSchemaVersion) {
    return Error::caller(
        fmt::format("{} was made by a newer version of Catan (its schema is {}, this one reads up to {})",
                    database.path(), *version, kSchemaVersion),
        "read it with that version");
  }
  if (*version < 1) return Error::caller(database.path() + " is no Catan record", kNoRecordHint);
  return Done{};
}

using Tables = std::map<std::string, std::set<std::string>>;

Result<Tables> tables_of(sqlite::Database& database) {
  Tables tables;
  const Status done = database.each_row(
      "SELECT s.name, c.name FROM sqlite_schema AS s, pragma_table_xinfo(s.name) AS c WHERE s.type = 'table' "
      "AND s.sql LIKE 'CREATE TABLE%' AND c.hidden = 0",
      [&](sqlite::Statement& row) -> Status {
        tables[row.text(0)].insert(row.text(1));
        return Done{};
      });
  if (!done) return done.error();
  return tables;
}

// Tables that the first records did not have.
constexpr std::array<std::string_view, 9> kLater{"age_limits", "app_changes", "clocks", "core_kinds", "cost_changes",
                                                 "exclusive",  "overruns",    "slots",  "steals"};

// Tables and their columns that older records do not have.
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kLaterColumns{
    {{"nodes", "needs_input"}, {"runs", "on_cpu"}, {"runs", "wait_ns"}}};

// An empty one, for this connection alone.
Status stand_in(sqlite::Database& database, sqlite::Database& model, const std::string& table) {
  auto made = model.prepare("SELECT sql FROM sqlite_schema WHERE name = '" + table + "'");
  if (!made) return made.error();
  const Result<bool> row = made->next();
  if (!row) return row.error();
  const std::string sql = made->text(0);
  return database.execute("PRAGMA temp_store = MEMORY; CREATE TEMP" + sql.substr(std::string_view("CREATE").size()));
}

// The file's tables are plain ones with the columns that a writer makes, and maybe more.
Status check_tables(sqlite::Database& database) {
  auto model = sqlite::Database::open(":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_MEMORY);
  if (!model) return model.error();
  if (auto done = model->execute(kSchema); !done) return done;
  const auto expected = tables_of(*model);
  if (!expected) return expected.error();
  const auto found = tables_of(database);
  if (!found) return found.error();
  for (const auto& [table, columns] : *expected) {
    const auto match = found->find(table);
    if (match == found->end()) {
      if (std::find(kLater.begin(), kLater.end(), table) != kLater.end()) {
        if (auto done = stand_in(database, *model, table); !done) return done;
        continue;
      }
      return Error::caller(fmt::format("{} has no table '{}'", database.path(), table), kNoRecordHint);
    }
    for (const std::string& column : columns) {
      const bool later = std::find(kLaterColumns.begin(), kLaterColumns.end(),
                                   std::pair<std::string_view, std::string_view>(table, column)) != kLaterColumns.end();
      if (later || match->second.contains(column)) continue;
      return Error::caller(fmt::format("{}: table '{}' has no column '{}'", database.path(), table, column),
                           kNoRecordHint);
    }
  }
  return Done{};
}

// That it is a record.
Result<sqlite::Database> checked(Result<sqlite::Database> database) {
  if (!database) return database;
  if (auto done = check_version(*database); !done) return done.error();
  if (auto done = check_tables(*database); !done) return done.error();
  return database;
}

}  // namespace

Result<std::int64_t> one_integer(sqlite::Database& database, const std::string& sql) {
  auto rows = database.prepare(sql);
  if (!rows) return rows.error();
  const Result<bool> row = rows->next();
  if (!row) return row.error();
  return *row && rows->type(0) == SQLITE_INTEGER ? rows->integer(0) : 0;
}

Result<sqlite::Database> open_record(const std::string& path) { return checked(open_consistent(path)); }

Result<sqlite::Database> open_record(std::span<const std::byte> image) {
  auto database = sqlite::Database::in_memory(image);
  if (!database) return database;
  if (auto done = guard(*database); !done) return done.error();
  return checked(std::move(database));
}

}  // namespace ctn::record
