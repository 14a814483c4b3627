#include "run/stored_run.h"

#include <nlohmann/json.hpp>

#include "program/batch.h"
#include "program/snapshot_json.h"

namespace ctn::navigation::run {
namespace {

using StoredJson = nlohmann::ordered_json;

program::ByTime by_time_in(const StoredJson& json, const char* key) {
  return json.contains(key) ? program::by_time_in(json[key]) : program::ByTime{};
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
  run.staleness = by_time_in(json, "staleness_ms_p95_by_5s");
  run.detector_periods = by_time_in(json, "detector_period_ms_by_10s");
  return run;
}

}  // namespace ctn::navigation::run
