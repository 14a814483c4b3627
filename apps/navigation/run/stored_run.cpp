#include "run/stored_run.h"

#include <fmt/format.h>

#include <algorithm>

#include <nlohmann/json.hpp>

namespace ctn::navigation::run {
namespace {

using StoredJson = nlohmann::ordered_json;

std::optional<double> number_of(const StoredJson& json) {
  return json.is_number() ? std::optional(json.get<double>()) : std::nullopt;
}

std::vector<std::optional<double>> numbers_of(const StoredJson& json, const char* key) {
  std::vector<std::optional<double>> numbers;
  if (!json.contains(key)) return numbers;
  for (const auto& value : json[key]) numbers.push_back(number_of(value));
  return numbers;
}

}  // namespace

std::optional<double> StoredRun::figure(const std::string& name) const {
  const auto found = std::ranges::find(figures, name, &Figure::name);
  return found == figures.end() ? std::nullopt : found->value;
}

Result<StoredRun> read_run(const std::string& text, const std::string& file, const Options& options) {
  const auto json = StoredJson::parse(text, nullptr, false);
  const char* const kHint = "name another folder with --out, or delete the file";
  if (!json.is_object() || !json.contains("figures") || !json["figures"].is_object()) {
    return Error::caller(fmt::format("{} is no outcome of a run", file), kHint);
  }
  const auto asked = StoredJson::parse(identity_of(options));
  for (const auto& [key, value] : asked.items()) {
    if (json.contains(key) && json[key] == value) continue;
    return Error::caller(fmt::format("{} is of a run with another {} ({}, not {})", file, key,
                                     json.contains(key) ? json[key].dump() : "none", value.dump()),
                         kHint);
  }
  StoredRun run;
  run.seed = options.seed;
  run.ended_by = json.value("ended_by", "");
  for (const auto& [name, value] : json["figures"].items()) run.figures.push_back({name, number_of(value)});
  run.staleness = numbers_of(json, "staleness_ms_p95_by_5s");
  run.detector_periods = numbers_of(json, "detector_period_ms_by_10s");
  return run;
}

}  // namespace ctn::navigation::run
