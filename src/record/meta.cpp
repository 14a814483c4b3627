#include "record/meta.h"

#include <cmath>

#include "record/cells.h"

namespace ctn::record {
namespace {

constexpr std::size_t kMaxKeys = 10'000;  // far above what a writer makes; a bound for files that none made

}  // namespace

Result<Meta> Meta::read(sqlite::Database& database) {
  Meta meta;
  const Status done = database.each_row("SELECT key, value FROM meta", [&](sqlite::Statement& row) -> Status {
    if (row.type(0) != SQLITE_TEXT || meta.values_.size() >= kMaxKeys) return damaged(database, "meta");
    switch (row.type(1)) {
      case SQLITE_INTEGER:
        meta.values_[row.text(0)] = row.integer(1);
        break;
      case SQLITE_FLOAT:
        meta.values_[row.text(0)] = row.real(1);
        break;
      case SQLITE_TEXT:
        meta.values_[row.text(0)] = row.text(1);
        break;
      default:  // NULL: as if not there
        break;
    }
    return Done{};
  });
  if (!done) return done.error();
  return meta;
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
