#include "run/batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include <nlohmann/json.hpp>

#include "program/batch.h"
#include "program/snapshot_json.h"
#include "run/measures.h"

namespace ctn::navigation::run {
namespace {

using BatchJson = nlohmann::ordered_json;

// "61 s, ended by goal, 1 contact"
std::string words_on(const StoredRun& run) {
  const auto contacts = static_cast<int>(run.figure("contacts").value_or(0.0));
  return fmt::format("{:.0f} s, ended by {}, {} contact{}", run.figure("seconds").value_or(0.0), run.ended_by, contacts,
                     contacts == 1 ? "" : "s");
}

}  // namespace

ByTime medians_by_time(const std::vector<StoredRun>& runs, ByTime StoredRun::*figure) {
  std::vector<ByTime> lists;
  for (const StoredRun& run : runs) lists.push_back(run.*figure);
  return program::medians_by_time(lists);
}

Result<Batch> run_batch(const Options& options, const std::function<Result<Outcome>(const Options&)>& run_one,
                        const std::function<void(const std::string&)>& tell) {
  return program::collect_batch<Batch>(options, run_one, read_run, words_on, tell);
}

std::string to_json(const Batch& batch) {
  BatchJson json = program::batch_document(identity_of(batch.options), batch.options);
  json["runs"] = BatchJson::array();
  for (const StoredRun& run : batch.runs) {
    json["runs"].push_back(
        {{"seed", run.seed}, {"ended_by", run.ended_by}, {"figures", program::json_of(run.figures)}});
  }
  json["summary"] = program::json_of(program::spreads_of(batch.runs));
  const auto medians_of = [&](ByTime StoredRun::*figure) {
    return program::json_of(medians_by_time(batch.runs, figure));
  };
  json["staleness_ms_p95_by_5s"] = medians_of(&StoredRun::staleness);
  if (batch.options.detector != "none") json["detector_period_ms_by_10s"] = medians_of(&StoredRun::detector_periods);
  json["interrupted"] = batch.signal != 0;
  return program::text_of(json);
}

std::string to_text(const Batch& batch) {
  const Options& options = batch.options;
  const auto with_collision = std::ranges::count_if(
      batch.runs, [](const StoredRun& run) { return run.figure("collided").value_or(0.0) > 0.0; });
  std::string text = fmt::format(
      "{} of {} runs on map {} under '{}'{}, seeds from {}, slowdown {}{}: {} with a collision\n", batch.runs.size(),
      options.runs, options.map, options.scheduler, options.stealing ? "" : " without stealing", options.seed,
      options.slowdown, batch.signal != 0 ? " (interrupted)" : "", with_collision);
  text += program::table_of(program::spreads_of(batch.runs));
  text +=
      rows_of("staleness_ms_p95 by 5 s, medians", medians_by_time(batch.runs, &StoredRun::staleness), kStalenessBucket);
  if (options.detector != "none") {
    text += rows_of("detector_period_ms by 10 s, medians", medians_by_time(batch.runs, &StoredRun::detector_periods),
                    kDetectorBucket);
  }
  return text;
}

}  // namespace ctn::navigation::run
