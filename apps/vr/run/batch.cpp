#include "run/batch.h"

#include <fmt/format.h>

#include <utility>

#include <nlohmann/json.hpp>

#include "program/batch.h"
#include "program/snapshot_json.h"

namespace ctn::vr::run {
namespace {

using BatchJson = nlohmann::ordered_json;

Result<StoredRun> read_run(const std::string& text, const std::string& file, const Options& options) {
  if (Status checked = program::check_document(text, file, identity_of(options)); !checked) return checked.error();
  return StoredRun{options.seed, program::figures_in(BatchJson::parse(text))};
}

std::string words_on(const StoredRun& run) {
  const auto value = [&run](const char* name) { return program::figure_of(run.figures, name).value_or(0.0); };
  return fmt::format("A {:.2f} ms, B {:.2f} ms, C {:.1f} ms, {:.0f} of {:.0f} ticks missed",
                     value("response_ms A_mean"), value("response_ms B_mean"), value("response_ms C_mean"),
                     value("ticks_missed"), value("ticks"));
}

}  // namespace

Result<Batch> run_batch(const Options& options, const std::function<Result<Outcome>(const Options&)>& run_one,
                        const std::function<void(const std::string&)>& tell) {
  return program::collect_batch<Batch>(options, run_one, read_run, words_on, tell);
}

std::string to_json(const Batch& batch) {
  BatchJson json = program::batch_document(identity_of(batch.options), batch.options);
  json["runs"] = BatchJson::array();
  for (const StoredRun& run : batch.runs) {
    json["runs"].push_back({{"seed", run.seed}, {"figures", program::json_of(run.figures)}});
  }
  json["summary"] = program::json_of(program::spreads_of(batch.runs));
  json["interrupted"] = batch.signal != 0;
  return program::text_of(json);
}

std::string to_text(const Batch& batch) {
  const Options& options = batch.options;
  return fmt::format("{} of {} runs of {} under '{}'{}{}\n", batch.runs.size(), options.runs, note_of(options),
                     options.scheduler, options.stealing ? "" : " without stealing",
                     batch.signal != 0 ? ", interrupted" : "") +
         program::table_of(program::spreads_of(batch.runs));
}

}  // namespace ctn::vr::run
