#include "run.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "statistics.h"

namespace ctn::case_studies {
namespace {

using Json = nlohmann::ordered_json;

bool is_over_time(const std::string& name, const Json& value) {
  return name.find("_by_") != std::string::npos && value.is_array() &&
         std::ranges::all_of(value, [](const Json& item) { return item.is_number() || item.is_null(); });
}

}  // namespace

std::optional<double> StoredRun::figure(const std::string& name) const {
  const auto found = figures.find(name);
  return found == figures.end() ? std::nullopt : std::optional(found->second);
}

Result<StoredRun> parse_run(const std::string& text, const std::string& file) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("figures") || !json["figures"].is_object() || !json.contains("seed") ||
      !json["seed"].is_number_unsigned()) {
    return Error::environment(file + " is no outcome of a run", "delete it, and run again");
  }
  StoredRun run;
  run.seed = json["seed"];
  for (const auto& [name, value] : json["figures"].items()) {
    if (value.is_number()) run.figures[name] = value;
  }
  for (const auto& [name, value] : json.items()) {
    if (!is_over_time(name, value)) continue;
    ByTime& list = run.by_time[name];
    for (const Json& item : value) list.push_back(item.is_null() ? std::nullopt : std::optional<double>(item));
  }
  return run;
}

Result<std::vector<StoredRun>> read_runs(const std::filesystem::path& folder, std::uint64_t first, int count) {
  std::vector<StoredRun> runs;
  for (int number = 0; number < count; ++number) {
    const std::filesystem::path path = folder / fmt::format("run-{}.json", first + static_cast<std::uint64_t>(number));
    std::error_code error;
    if (!std::filesystem::exists(path, error)) continue;
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    Result<StoredRun> run = parse_run(text.str(), path.string());
    if (!run) return run.error();
    runs.push_back(std::move(run).value());
  }
  return runs;
}

ByTime medians_by_time(const std::vector<StoredRun>& runs, const std::string& name) {
  ByTime medians;
  for (std::size_t stretch = 0;; ++stretch) {
    std::size_t reached = 0;
    std::vector<double> values;
    for (const StoredRun& run : runs) {
      const auto list = run.by_time.find(name);
      if (list == run.by_time.end() || stretch >= list->second.size()) continue;
      ++reached;
      if (const auto& value = list->second[stretch]) values.push_back(*value);
    }
    if (reached == 0 || 2 * reached < runs.size()) return medians;
    medians.push_back(percentile_of(std::move(values), 50.0));
  }
}

std::optional<double> mean_between(const StoredRun& run, const std::string& name, double from, double to) {
  const auto list = run.by_time.find(name);
  if (list == run.by_time.end()) return std::nullopt;
  const auto length = static_cast<double>(list->second.size());
  std::vector<double> values;
  for (std::size_t stretch = 0; stretch < list->second.size(); ++stretch) {
    const double middle = (static_cast<double>(stretch) + 0.5) / length;
    if (middle >= from && middle < to && list->second[stretch]) values.push_back(*list->second[stretch]);
  }
  return mean_of(values);
}

}  // namespace ctn::case_studies
