#include "run/stored_run.h"

#include <nlohmann/json.hpp>

#include "program/batch.h"
#include "program/snapshot_json.h"

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

std::optional<double> StoredRun::figure(const std::string& name) const { return program::figure_of(figures, name); }

Result<StoredRun> read_run(const std::string& text, const std::string& file, const Options& options) {
  if (Status checked = program::check_document(text, file, identity_of(options)); !checked) return checked.error();
  const auto json = StoredJson::parse(text);
  StoredRun run;
  run.seed = options.seed;
  run.ended_by = json.value("ended_by", "");
  run.figures = program::figures_in(json);
  run.staleness = numbers_of(json, "staleness_ms_p95_by_5s");
  run.detector_periods = numbers_of(json, "detector_period_ms_by_10s");
  return run;
}

}  // namespace ctn::navigation::run
