#include "run/batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "run/measures.h"

namespace ctn::navigation::run {
namespace {

using BatchJson = nlohmann::ordered_json;

Error cannot_write(const std::filesystem::path& path) {
  return Error::environment(fmt::format("{} cannot be written", path.string()), "name another folder with --out");
}

Status store(const std::filesystem::path& path, const std::string& text) {
  const std::filesystem::path unfinished = path.string() + ".unfinished";
  {
    std::ofstream file(unfinished, std::ios::binary | std::ios::trunc);
    if (!(file << text).flush()) return cannot_write(unfinished);
  }
  std::error_code error;
  std::filesystem::rename(unfinished, path, error);
  if (error) return cannot_write(path);
  return Done{};
}

// "run 3 of 20, seed 3: 61 s, 1 contact; about 4 min left"
std::string line_of(const StoredRun& run, int number, int count, double seconds_left) {
  const auto contacts = static_cast<int>(run.figure("contacts").value_or(0.0));
  std::string line = fmt::format("run {} of {}, seed {}: {:.0f} s, ended by {}, {} contact{}", number, count, run.seed,
                                 run.figure("seconds").value_or(0.0), run.ended_by, contacts, contacts == 1 ? "" : "s");
  if (seconds_left >= 1.0) {
    line += seconds_left < 120.0 ? fmt::format("; about {:.0f} s left", seconds_left)
                                 : fmt::format("; about {:.0f} min left", seconds_left / 60.0);
  }
  return line;
}

}  // namespace

std::vector<Spread> spreads_of(const std::vector<StoredRun>& runs) {
  std::vector<Spread> spreads;
  std::vector<std::string> names;
  for (const StoredRun& run : runs) {
    for (const Figure& figure : run.figures) {
      if (std::ranges::find(names, figure.name) == names.end()) names.push_back(figure.name);
    }
  }
  for (const std::string& name : names) {
    std::vector<double> values;
    for (const StoredRun& run : runs) {
      if (const auto value = run.figure(name)) values.push_back(*value);
    }
    if (values.empty()) {
      spreads.push_back({.figure = name});
      continue;
    }
    spreads.push_back({name, values.size(), *mean_of(values), *std::ranges::min_element(values),
                       *percentile_of(values, 25.0), *percentile_of(values, 50.0), *percentile_of(values, 75.0),
                       *std::ranges::max_element(values)});
  }
  return spreads;
}

ByTime medians_by_time(const std::vector<StoredRun>& runs, ByTime StoredRun::*figure) {
  std::size_t length = 0;
  for (const StoredRun& run : runs) length = std::max(length, (run.*figure).size());
  ByTime medians;
  for (std::size_t bucket = 0; bucket < length; ++bucket) {
    std::vector<double> values;
    for (const StoredRun& run : runs) {
      const ByTime& of_run = run.*figure;
      if (bucket < of_run.size() && of_run[bucket]) values.push_back(*of_run[bucket]);
    }
    medians.push_back(percentile_of(std::move(values), 50.0));
  }
  return medians;
}

Result<Batch> run_batch(const Options& options, const std::function<Result<Outcome>(const Options&)>& run_one,
                        const std::function<void(const std::string&)>& tell) {
  const std::filesystem::path folder = options.out;
  std::error_code error;
  if (!options.out.empty()) {
    std::filesystem::create_directories(folder, error);
    if (error) return cannot_write(folder);
  }
  Batch batch{options, {}, 0};
  double took = 0.0;
  int measured = 0;
  for (int number = 1; number <= options.runs; ++number) {
    Options one = options;
    one.seed = options.seed + static_cast<std::uint64_t>(number - 1);
    const std::filesystem::path path = folder / fmt::format("run-{}.json", one.seed);
    if (!options.out.empty() && std::filesystem::exists(path, error)) {
      std::ostringstream text;
      text << std::ifstream(path, std::ios::binary).rdbuf();
      auto run = read_run(text.str(), path.string(), one);
      if (!run) return run.error();
      tell(line_of(*run, number, options.runs, 0.0) + " (from " + path.string() + ")");
      batch.runs.push_back(std::move(run).value());
      continue;
    }
    auto outcome = run_one(one);
    if (!outcome) return outcome.error();
    if (outcome->signal != 0) {
      batch.signal = outcome->signal;
      break;
    }
    const std::string text = to_json(*outcome);
    if (!options.out.empty()) {
      if (Status stored = store(path, text); !stored) return stored.error();
    }
    auto run = read_run(text, "the outcome", one);
    if (!run) return run.error();
    took += outcome->took_seconds;
    ++measured;
    tell(line_of(*run, number, options.runs, took / measured * (options.runs - number)));
    batch.runs.push_back(std::move(run).value());
  }
  return batch;
}

std::string to_json(const Batch& batch) {
  const auto or_null_of = [](const std::optional<double>& value) {
    return value ? BatchJson(*value) : BatchJson(nullptr);
  };
  BatchJson json = BatchJson::parse(identity_of(batch.options));
  json["runs"] = BatchJson::array();
  for (const StoredRun& run : batch.runs) {
    BatchJson figures = BatchJson::object();
    for (const Figure& figure : run.figures) figures[figure.name] = or_null_of(figure.value);
    json["runs"].push_back({{"seed", run.seed}, {"ended_by", run.ended_by}, {"figures", std::move(figures)}});
  }
  BatchJson summary = BatchJson::object();
  for (const Spread& spread : spreads_of(batch.runs)) {
    summary[spread.figure] = {{"count", spread.count}};
    if (spread.count == 0) continue;
    summary[spread.figure].update({{"mean", spread.mean},
                                   {"min", spread.min},
                                   {"lower_quartile", spread.lower_quartile},
                                   {"median", spread.median},
                                   {"upper_quartile", spread.upper_quartile},
                                   {"max", spread.max}});
  }
  json["summary"] = std::move(summary);
  const auto medians_of = [&](ByTime StoredRun::*figure) {
    BatchJson medians = BatchJson::array();
    for (const auto& median : medians_by_time(batch.runs, figure)) medians.push_back(or_null_of(median));
    return medians;
  };
  json["staleness_ms_p95_by_5s"] = medians_of(&StoredRun::staleness);
  if (batch.options.detector != "none") json["detector_period_ms_by_10s"] = medians_of(&StoredRun::detector_periods);
  json["interrupted"] = batch.signal != 0;
  return json.dump(2, ' ', false, BatchJson::error_handler_t::replace) + "\n";
}

std::string to_text(const Batch& batch) {
  const Options& options = batch.options;
  const auto with_collision = std::ranges::count_if(
      batch.runs, [](const StoredRun& run) { return run.figure("collided").value_or(0.0) > 0.0; });
  std::string text = fmt::format(
      "{} of {} runs on map {} under '{}'{}, seeds from {}, slowdown {}{}: {} with a collision\n", batch.runs.size(),
      options.runs, options.map, options.scheduler, options.stealing ? "" : " without stealing", options.seed,
      options.slowdown, batch.signal != 0 ? " (interrupted)" : "", with_collision);
  text += fmt::format("  {:<46} {:>5} {:>10} {:>10} {:>10} {:>10}\n", "figure", "runs", "mean", "lower q.", "median",
                      "upper q.");
  for (const Spread& spread : spreads_of(batch.runs)) {
    if (spread.count == 0) {
      text += fmt::format("  {:<46} {:>5} {:>10}\n", spread.figure, 0, "-");
      continue;
    }
    text += fmt::format("  {:<46} {:>5} {:>10.5g} {:>10.5g} {:>10.5g} {:>10.5g}\n", spread.figure, spread.count,
                        spread.mean, spread.lower_quartile, spread.median, spread.upper_quartile);
  }
  text +=
      rows_of("staleness_ms_p95 by 5 s, medians", medians_by_time(batch.runs, &StoredRun::staleness), kStalenessBucket);
  if (options.detector != "none") {
    text += rows_of("detector_period_ms by 10 s, medians", medians_by_time(batch.runs, &StoredRun::detector_periods),
                    kDetectorBucket);
  }
  return text;
}

}  // namespace ctn::navigation::run
