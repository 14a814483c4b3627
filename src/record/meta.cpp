#include "record/meta.h"

#include <cmath>

#include "record/cells.h"

namespace ctn::record {
namespace {

constexpr std::size_t kMaxKeys = 10'000;  // far above what a writer makes; a bound for files that none made

}  // namespace

Result<Meta> Meta::read(sqlite::Database& database) {
  auto rows = database.prepare("SELECT key, value FROM meta");
  if (!rows) return rows.error();
  Meta meta;
  while (true) {
    const Result<bool> row = rows->next();
    if (!row) return row.error();
    if (!*row) return meta;
    if (rows->type(0) != SQLITE_TEXT || meta.values_.size() >= kMaxKeys) return damaged(database, "meta");
    switch (rows->type(1)) {
      case SQLITE_INTEGER:
        meta.values_[rows->text(0)] = rows->integer(1);
        break;
      case SQLITE_FLOAT:
        meta.values_[rows->text(0)] = rows->real(1);
        break;
      case SQLITE_TEXT:
        meta.values_[rows->text(0)] = rows->text(1);
        break;
      default:  // NULL: as if not there
        break;
    }
  }
}

std::optional<std::int64_t> Meta::integer(std::string_view key) const {
  const auto found = values_.find(key);
  if (found == values_.end()) return std::nullopt;
  const auto* value = std::get_if<std::int64_t>(&found->second);
  return value == nullptr ? std::nullopt : std::optional(*value);
}

std::optional<double> Meta::real(std::string_view key) const {
  const auto found = values_.find(key);
  if (found == values_.end()) return std::nullopt;
  const auto* value = std::get_if<double>(&found->second);
  return value == nullptr || !std::isfinite(*value) ? std::nullopt : std::optional(*value);
}

std::optional<std::string> Meta::text(std::string_view key) const {
  const auto found = values_.find(key);
  if (found == values_.end()) return std::nullopt;
  const auto* value = std::get_if<std::string>(&found->second);
  return value == nullptr ? std::nullopt : std::optional(*value);
}

std::optional<Nanos> Meta::duration(std::string_view key) const {
  const auto value = integer(key);
  return value && *value >= 0 && *value <= kTimeLimit ? std::optional(Nanos{*value}) : std::nullopt;
}

Result<MetaWriter> MetaWriter::prepare(sqlite::Database& database) {
  auto statement = database.prepare("INSERT OR REPLACE INTO meta(key, value) VALUES (?, ?)");
  if (!statement) return statement.error();
  return MetaWriter(std::move(*statement));
}

}  // namespace ctn::record
